//! A plan: the tests that the studies of a definition allow, and how often they find an effect.

use rayon::prelude::*;
use statrs::function::beta::beta_reg;

use super::{
    hypothesis::{Hypothesis, Layout, Test},
    scenario::{PlanError, Scenario, Shift},
};
use crate::{
    analysis::{
        Link, MAX_COEFFICIENTS, MAX_NODES, ModelError, ModelSpec, Random,
        counts::Counts,
        frame::Frame,
        interval::Interval,
        ordinal::{
            check_size, chi_squared_tail, dot_ignoring_zero_weights, fit_counts, predictors, terms::Terms,
            without_terms,
        },
        rank_tests::{SubjectMeans, friedman},
    },
    experiment::{OrderedLogit, Protocol},
};

/// Number of random orders in Friedman's test of a simulated study, if they cannot be enumerated.
const PERMUTATIONS: usize = 1999;

/// How studies are analyzed.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ModelChoice {
    /// Terms of the model. `None` means the main effects of all factors with two or more levels.
    pub terms: Option<Terms>,
    pub link: Link,
    /// Number of quadrature nodes; 1 is the Laplace approximation.
    pub quadrature: usize,
    /// True if the number of levels, conditions and coefficients has no limit.
    pub large: bool,
}

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
    scenario: Scenario,
    spec: ModelSpec,
    hypotheses: Vec<Hypothesis>,
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
    /// Number of studies with no test, because there was no model or all ratings were the same. They count as not
    /// found.
    pub untested: usize,
    /// Median of the estimated effect over studies, on the scale of the link, for the same contrast as
    /// `Effect::logits`. It is infinite if the ratings are separated in half of the studies or more.
    pub estimate: Option<f64>,
}

impl Power {
    /// Returns the proportion of studies that found the effect.
    pub fn share(&self) -> f64 {
        self.found as f64 / self.studies.max(1) as f64
    }

    /// Returns the exact 95 % interval of that proportion (Clopper & Pearson).
    pub fn interval(&self) -> Interval {
        clopper_pearson(self.found, self.studies, 0.95)
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
        model: &ModelChoice,
    ) -> Result<Self, PlanError> {
        if !(1..=MAX_NODES).contains(&model.quadrature) {
            return Err(ModelError::Quadrature { nodes: model.quadrature, most: MAX_NODES }.into());
        }
        let scenario = Scenario::new(protocol, observer, shifts)?;
        let varied = scenario.empty.factors.iter().filter(|factor| factor.levels.len() > 1);
        let varied: Vec<&str> = varied.map(|factor| factor.name.as_str()).collect();
        let terms = model.terms.clone().unwrap_or_else(|| Terms::factors(&varied));
        if terms.is_empty() {
            return Err(PlanError::NothingVaries);
        }
        let outline = scenario.outline();
        if !model.large {
            outline.check_size().map_err(PlanError::TooLarge)?;
        }
        let max_coefficients = if model.large { usize::MAX } else { MAX_COEFFICIENTS };
        let (frame, _) = Frame::new(&outline, &[&terms])?;
        check_size(&frame, &[&terms], max_coefficients)?;
        let hypotheses = Layout::new(&scenario, &frame, &terms).hypotheses()?;
        let spec = ModelSpec {
            link: model.link,
            random: Random::Subject,
            quadrature: model.quadrature,
            max_coefficients,
            ..ModelSpec::new(terms)
        };
        Ok(Self { scenario, spec, hypotheses })
    }

    /// Returns the hypotheses and their tests.
    pub fn hypotheses(&self) -> &[Hypothesis] {
        &self.hypotheses
    }

    pub fn spec(&self) -> &ModelSpec {
        &self.spec
    }

    pub fn observer(&self) -> &OrderedLogit {
        self.scenario.observer()
    }

    /// Returns the smallest p that Friedman's test can reach with this number of participants, when all of them agree,
    /// or `None` for other tests.
    pub fn least_p(&self, power: &Power) -> Option<f64> {
        let factor = self.hypotheses[power.hypothesis].factor?;
        let df = self.scenario.empty.factors[factor].levels.len() - 1;
        Some(chi_squared_tail(f64::from(power.participants) * df as f64, df))
    }

    /// Returns the number of ratings that each participant gives.
    pub fn ratings(&self) -> u64 {
        self.scenario.ratings()
    }

    /// Simulates and analyzes studies for each number of participants, on all threads of the pool. After each completed
    /// study, `progress` receives its number of participants. Friedman's test needs at least two participants; with
    /// one, it is omitted.
    pub fn run(&self, participants: &[u32], sampling: &Sampling, progress: &(dyn Fn(u64) + Sync)) -> Vec<Power> {
        let pieces: Vec<(u32, u32)> =
            participants.iter().flat_map(|people| (0..sampling.studies).map(|study| (*people, study))).collect();
        let outcomes: Vec<Vec<Outcome>> = (pieces.par_iter())
            .map(|&(people, study)| {
                let counts = self.scenario.study(people, study, sampling.seed);
                let outcomes = outcomes(&counts, &self.spec, &self.hypotheses);
                progress(people.into());
                outcomes
            })
            .collect();
        let mut powers = Vec::new();
        for (people, outcomes) in participants.iter().zip(outcomes.chunks(sampling.studies.max(1) as usize)) {
            let tested = (0..self.hypotheses.len())
                .filter(|index| *people > 1 || self.hypotheses[*index].test != Test::Friedman);
            powers.extend(tested.map(|index| power(*people, index, outcomes, sampling.alpha)));
        }
        powers
    }
}

/// Counts the outcomes of a hypothesis over all studies.
fn power(participants: u32, hypothesis: usize, outcomes: &[Vec<Outcome>], alpha: f64) -> Power {
    let all = || outcomes.iter().map(|outcomes| outcomes[hypothesis]);
    Power {
        participants,
        hypothesis,
        studies: outcomes.len(),
        found: all().filter(|outcome| outcome.p.is_some_and(|p| p < alpha)).count(),
        untested: all().filter(|outcome| outcome.p.is_none()).count(),
        estimate: median(all().filter_map(|outcome| outcome.estimate).collect()),
    }
}

fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    let (low, high) = (values.get(values.len().checked_sub(1)? / 2)?, values.get(values.len() / 2)?);
    // The mean of two equal infinite values is infinite; two opposite infinite values have no mean.
    Some(if low == high { *low } else { (low + high) / 2.0 }).filter(|median| !median.is_nan())
}

/// The outcome of one hypothesis in one study.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Outcome {
    /// Probability from the test; `None` if there is no test, for example because there is no model.
    pub p: Option<f64>,
    /// Estimate of the effect; infinite if the ratings are separated.
    pub estimate: Option<f64>,
}

/// Returns the outcome of each hypothesis in a study.
fn outcomes(counts: &Counts, spec: &ModelSpec, hypotheses: &[Hypothesis]) -> Vec<Outcome> {
    // Omit the standard errors: likelihood-ratio tests do not need them.
    let fitted = fit_counts(counts, spec, false).ok();
    let tests = fitted.as_ref().and_then(|fitted| without_terms(fitted).ok());
    let conditions: Vec<u32> = (0..counts.conditions.len() as u32).collect();
    let predictors = (fitted.as_ref()).filter(|_| tests.is_some()).map(|fitted| predictors(fitted, &conditions));
    let outcome = |hypothesis: &Hypothesis| match (hypothesis.test, hypothesis.factor) {
        (Test::Friedman, Some(factor)) => {
            Outcome { p: friedman(&SubjectMeans::new(counts, factor), PERMUTATIONS).map(|test| test.p), estimate: None }
        }
        _ => Outcome {
            p: (tests.iter().flatten()).find(|test| test.term == hypothesis.term).and_then(|test| test.p),
            estimate: (hypothesis.contrast.as_ref().zip(predictors.as_ref()))
                .map(|(contrast, predictors)| dot_ignoring_zero_weights(contrast.iter(), predictors.iter()))
                .filter(|estimate| !estimate.is_nan()),
        },
    };
    hypotheses.iter().map(outcome).collect()
}

/// Returns the exact interval of Clopper & Pearson (1934), Biometrika 26, 404, for `found` out of `all`. It covers the
/// true proportion with a probability of at least `level`.
pub fn clopper_pearson(found: usize, all: usize, level: f64) -> Interval {
    let tail = (1.0 - level) / 2.0;
    let (k, n) = (found as f64, all as f64);
    // P(X ≥ k) rises with the proportion, and P(X ≤ k) falls. Both are incomplete beta functions.
    let low = if found == 0 { 0.0 } else { crossing(|p| beta_reg(k, n - k + 1.0, p) - tail) };
    let high = if found >= all { 1.0 } else { crossing(|p| beta_reg(k + 1.0, n - k, p) - (1.0 - tail)) };
    Interval { low, high }
}

/// Finds by bisection where a function that rises on 0…1 is 0.
fn crossing(rising: impl Fn(f64) -> f64) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..60 {
        let middle = (low + high) / 2.0;
        *if rising(middle) < 0.0 { &mut low } else { &mut high } = middle;
    }
    (low + high) / 2.0
}
