//! A plan: the tests that the studies of a definition allow, and how often they find an effect.

use rayon::prelude::*;

use super::scenario::{Hypothesis, PlanError, Scenario, Shift, Slope, Test};
use crate::{
    analysis::{
        FEW_FOR_LIKELIHOOD_RATIOS, MAX_COEFFICIENTS, ModelSpec, Options, Slopes, Withheld,
        counts::Counts,
        frame::Frame,
        ordinal::{Fitted, check_size, fit_counts, terms::Term, without_term},
        rank_tests::{SubjectMeans, friedman},
        results::model_spec,
    },
    experiment::{OrderedLogit, Protocol},
    statistics::Interval,
};

/// Fewest and most studies without an effect that calibrate its test.
const WITHOUT_EFFECT: (u32, u32) = (199, 999);

/// The size of the simulation, and the criterion for finding an effect.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sampling {
    /// Number of studies for each number of participants.
    pub studies: u32,
    /// Significance level: an effect counts as found if p is below it.
    pub alpha: f64,
    /// Seed of all ratings.
    pub seed: u64,
}

impl Default for Sampling {
    fn default() -> Self {
        Self { studies: 200, alpha: 0.05, seed: 1 }
    }
}

/// A definition, an observer and a model: everything except the number of participants.
#[derive(Clone, Debug)]
pub struct Plan {
    pub scenario: Scenario,
    pub spec: ModelSpec,
    /// The hypotheses and their tests.
    pub hypotheses: Vec<Hypothesis>,
}

/// How often the test of one hypothesis was significant.
#[derive(Clone, Debug, PartialEq)]
pub struct Power {
    /// Number of participants in each study.
    pub participants: u32,
    /// Index into [`Plan::hypotheses`].
    pub hypothesis: usize,
    pub studies: usize,
    /// Number of studies in which p is below α.
    pub found: usize,
    /// Number of studies with no test, because there was no model, all ratings were the same, or an analysis withholds the
    /// test. They count as not found.
    pub untested: usize,
    /// Why an analysis withholds the test in the last of these studies, if it does.
    pub withheld: Option<Withheld>,
}

impl Power {
    /// Returns the proportion of studies that found the effect.
    pub fn share(&self) -> f64 {
        self.found as f64 / self.studies.max(1) as f64
    }

    /// Returns the exact 95 % interval of that proportion (Clopper & Pearson).
    pub fn interval(&self) -> Interval {
        Interval::of_proportion(self.found, self.studies)
    }
}

impl Plan {
    /// Prepares the simulation and its tests.
    ///
    /// # Errors
    /// Returns a [`PlanError`] if a term, factor or level is not in the definition, or if there is nothing to test.
    pub fn new(
        protocol: &Protocol,
        observer: &OrderedLogit,
        shifts: &[Shift],
        slopes: &[Slope],
        model: &Options,
    ) -> Result<Self, PlanError> {
        let scenario = Scenario::new(protocol, observer, shifts, slopes)?;
        let outline = &scenario.outline;
        // The factors of a definition are no covariates, however many levels they have.
        let model = Options { covariates: Some(Vec::new()), ..model.clone() };
        let (spec, _) = model_spec(outline, &[], &model);
        if spec.terms.is_empty() {
            return Err(PlanError::NothingVaries);
        }
        if spec.max_coefficients <= MAX_COEFFICIENTS {
            outline.check_size().map_err(PlanError::TooLarge)?;
        }
        let (frame, _) = Frame::new(outline, &spec)?;
        check_size(&frame, &spec.terms, spec.max_coefficients)?;
        let hypotheses = scenario.hypotheses(&frame, &spec.terms)?;
        Ok(Self { scenario, spec, hypotheses })
    }

    /// Returns the simulated slopes if the model of several participants allows for none, so that its p values are too small.
    /// If only the design allows for none, the test is withheld.
    pub fn unmodeled(&self) -> impl Iterator<Item = &Slope> {
        let varies = |slope: &Slope| {
            self.scenario.outline.factor(&slope.factor).is_some_and(|(_, factor)| factor.levels.len() > 1)
        };
        let has_none = self.spec.slopes == Slopes::None;
        self.scenario.slopes.iter().filter(move |slope| has_none && slope.sd > 0.0 && varies(slope))
    }

    /// Returns the number of studies without an effect that calibrate its likelihood ratio, or `None` if the χ²
    /// distribution is accurate enough for this number of participants.
    fn calibration(&self, participants: u32, sampling: &Sampling) -> Option<u32> {
        let (fewest, most) = WITHOUT_EFFECT;
        ((participants as usize) < FEW_FOR_LIKELIHOOD_RATIOS).then(|| sampling.studies.clamp(fewest, most))
    }

    /// Returns the number of participants that [`Self::run`] simulates, over all studies.
    pub fn simulated(&self, participants: &[u32], sampling: &Sampling) -> u64 {
        let calibrated = self.hypotheses.iter().filter(|hypothesis| hypothesis.absent.is_some()).count() as u64;
        let studies = |people: u32| {
            let without_effect = self.calibration(people, sampling).map_or(0, u64::from);
            u64::from(sampling.studies) + calibrated * without_effect
        };
        participants.iter().map(|people| u64::from(*people) * studies(*people)).sum()
    }

    /// Returns the number of ratings that each participant gives.
    pub fn ratings(&self) -> u64 {
        self.scenario.predictors.len() as u64 * u64::from(self.scenario.repetitions)
    }

    /// Simulates and analyzes studies for each number of participants, on all threads of the pool. After each completed
    /// study, `progress` receives its number of participants. Friedman's test needs at least two participants; with
    /// one, it is omitted.
    pub fn run(&self, participants: &[u32], sampling: &Sampling, progress: &(dyn Fn(u64) + Sync)) -> Vec<Power> {
        participants.iter().flat_map(|people| self.powers(*people, sampling, progress)).collect()
    }

    fn powers(&self, people: u32, sampling: &Sampling, progress: &(dyn Fn(u64) + Sync)) -> Vec<Power> {
        let nulls: Vec<Option<Vec<f64>>> = (self.hypotheses.iter())
            .map(|hypothesis| {
                let studies = self.calibration(people, sampling)?;
                let absent = (&hypothesis.term, &hypothesis.absent.as_ref()?[..]);
                Some(self.ratios_without(absent, people, studies, sampling.seed, progress))
            })
            .collect();
        let outcomes: Vec<Vec<Outcome>> = (0..sampling.studies)
            .into_par_iter()
            .map(|study| {
                let Scenario { predictors, slopes, .. } = &self.scenario;
                let counts = self.scenario.study((predictors, slopes), true, people, study, sampling.seed);
                // Omit the standard errors: likelihood-ratio tests do not need them.
                let fitted = fit_counts(&counts, &self.spec, false).ok();
                let of = |(hypothesis, null): (&Hypothesis, &Option<Vec<f64>>)| {
                    outcome(&counts, fitted.as_ref(), hypothesis, null.as_deref())
                };
                let outcomes = self.hypotheses.iter().zip(&nulls).map(of).collect();
                progress(people.into());
                outcomes
            })
            .collect();
        let power = |(index, hypothesis): (usize, &Hypothesis)| {
            let all = || outcomes.iter().map(|outcomes| outcomes[index]);
            (people > 1 || hypothesis.test != Test::Friedman).then(|| Power {
                participants: people,
                hypothesis: index,
                studies: outcomes.len(),
                found: all().filter(|(p, _)| p.is_some_and(|p| p < sampling.alpha)).count(),
                untested: all().filter(|(p, _)| p.is_none()).count(),
                withheld: all().rev().find_map(|(_, withheld)| withheld),
            })
        };
        self.hypotheses.iter().enumerate().filter_map(power).collect()
    }

    /// Returns the likelihood ratios of a term in studies in which it has no effect; not finite where a study allows no
    /// fit.
    ///
    /// They calibrate the ratios in all planned studies, because a bootstrap within each one, as in an analysis, would
    /// take hundreds of times as long. Like those of a bootstrap, these people have slopes only if the model has, so that a
    /// model without slopes gives as many false alarms here as in an analysis.
    fn ratios_without(
        &self,
        (term, predictors): (&Term, &[f64]),
        people: u32,
        studies: u32,
        seed: u64,
        progress: &(dyn Fn(u64) + Sync),
    ) -> Vec<f64> {
        // The model of one participant has no random effects.
        let slopes = if people > 1 && self.spec.slopes != Slopes::None { &self.scenario.slopes[..] } else { &[] };
        let ratio = |study: u32| {
            let counts = self.scenario.study((predictors, slopes), false, people, study, seed);
            let fitted = fit_counts(&counts, &self.spec, false).ok();
            let ratio = fitted.and_then(|fitted| without_term(&fitted, term).chi_squared);
            progress(people.into());
            ratio.unwrap_or(f64::NAN)
        };
        (0..studies).into_par_iter().map(ratio).collect()
    }
}

/// The outcome of one hypothesis in one study: the probability from the test, if there is one, and why an analysis withholds it.
type Outcome = (Option<f64>, Option<Withheld>);

/// Returns the outcome of a hypothesis in a study, which was fitted if possible. `null` are the likelihood ratios without the
/// effect, if they calibrate the test.
fn outcome(counts: &Counts, fitted: Option<&Fitted>, hypothesis: &Hypothesis, null: Option<&[f64]>) -> Outcome {
    let Hypothesis { term, test, .. } = hypothesis;
    if let (Test::Friedman, Some((factor, _))) = (test, counts.factor(term.name())) {
        return (friedman(&SubjectMeans::new(counts, factor)).map(|test| test.p), None);
    }
    let Some(fitted) = fitted else { return (None, None) };
    let withheld = fitted.withheld(term);
    let probability = || {
        let mut test = without_term(fitted, term);
        null.iter().for_each(|ratios| test.calibrate(ratios, false));
        test.p
    };
    (if withheld.is_none() { probability() } else { None }, withheld)
}
