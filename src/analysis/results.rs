//! The complete analysis of a study: descriptive statistics, model, tests and agreement.

use rayon::prelude::*;
use serde::Serialize;

use super::{
    Calibration, Link, MAX_COEFFICIENTS, Margin, ModelError, ModelReport, ModelSpec, Note, Random, Resampling, Slopes,
    agreement::{Alpha, kappa, mean_kappa, ordinal_alpha},
    counts::{Counts, MAX_LEVELS, Measured},
    fit_with_tests,
    rank_tests::{Friedman, SubjectMeans, friedman},
    summary::{Group, by_cell, by_factor, by_subject},
    terms::{Term, Terms, Variable},
};
use crate::{statistics::Interval, stimulus::Parameter};

/// What to compute.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Options {
    /// Terms of the model. `None` means the main effects of all factors with two or more levels and of the covariates.
    pub terms: Option<Terms>,
    /// Factors that are covariates. `None` means those that [`Counts::is_covariate`] says or that have more levels than can be
    /// listed.
    pub covariates: Option<Vec<String>>,
    /// The factor whose levels are items, each with a random intercept ([`ModelSpec::items`]).
    pub items: Option<String>,
    pub link: Link,
    /// The random part. `None` means an intercept for each participant; a single participant has none in any case.
    pub random: Option<Random>,
    /// Random slopes, where the design supports them.
    pub slopes: Slopes,
    /// Maximum number of coefficients of the model; `None` means the usual one.
    pub max_coefficients: Option<usize>,
    /// The simulated studies that calibrate tests and intervals.
    pub resampling: Resampling,
    /// Whether not to compute how well the model describes the data.
    pub unchecked: bool,
    /// The parameters of the stimulus that was rated, whose names the factors have; `None` if the ratings are from elsewhere.
    pub parameters: Option<&'static [Parameter]>,
}

impl Options {
    /// Returns the terms that are asked for. The name of a covariate means its number.
    pub fn terms(&self, counts: &Counts) -> Option<Terms> {
        let covariates = covariates(counts, self);
        let is_covariate = |name: &str| counts.factor(name).is_some_and(|(factor, _)| covariates.contains(&factor));
        let with_number = |variable: &Variable| match variable {
            Variable::Factor(name) if is_covariate(name) => Variable::Number(name.clone()),
            variable => variable.clone(),
        };
        let with_numbers = |term: &Term| Term { variables: term.variables.iter().map(with_number).collect() };
        self.terms.as_ref().map(|terms| Terms::new(terms.iter().map(with_numbers)))
    }
}

#[derive(Clone, Debug)]
pub struct Results {
    /// The ratings, without the covariates and the items.
    pub measured: Measured,
    /// The ratings with the covariates and the items, on which the model was fitted, if there are any.
    pub whole: Option<Measured>,
    /// Names of the covariates: each has one slope in the model, and no levels in the descriptions.
    pub covariates: Vec<String>,
    pub options: Options,
    /// The ratings in each cell of the design.
    pub cells: Vec<Group>,
    pub factors: Vec<FactorResults>,
    pub subjects: Vec<SubjectResults>,
    /// The specification of the model.
    pub spec: ModelSpec,
    /// The model with its tests, or the reason why there is none.
    pub model: Result<ModelReport, ModelError>,
    /// Agreement between participants; `None` if there is only one participant.
    pub alpha: Option<Alpha>,
    /// Agreement within participants: the mean of weighted κ over participants and its interval.
    pub kappa: Option<(f64, Option<Interval>)>,
}

/// The results for one factor.
#[derive(Clone, Debug, Serialize)]
pub struct FactorResults {
    /// Name of the factor.
    pub name: String,
    /// The ratings at each level.
    pub levels: Vec<Group>,
    /// The model's expected rating at each level, if the raw means of the levels cannot be compared; of a factor that varies
    /// only between participants, if the model has another order.
    pub marginal: Option<Vec<f64>>,
    /// Whether the raw means can be compared: every participant rated all levels in the same conditions of the other factors.
    pub comparable: bool,
    /// Whether the levels can meaningfully increase; if so, a trend is described.
    pub ordered: bool,
    /// Whether most participants rated several levels.
    pub within: bool,
    /// Each participant's mean at every level, of which the differences and the rank test are.
    pub matched: SubjectMeans,
    /// Test of whether any level differs; `None` if there is only one participant or level, or if there are items.
    pub friedman: Option<Friedman>,
    /// The median response time at each level, in seconds.
    pub times: Vec<Option<f64>>,
}

#[derive(Clone, Debug, Serialize)]
pub struct SubjectResults {
    /// The participant's ratings.
    pub group: Group,
    /// Number of conditions that the participant rated at least twice.
    pub retests: u64,
    /// Quadratically weighted κ of first and second ratings; `None` if there are no repetitions or all ratings are the
    /// same.
    pub kappa: Option<f64>,
    /// The participant's median response time, in seconds.
    pub time: Option<f64>,
}

impl FactorResults {
    /// Returns the mean at each level to which words refer: the marginal mean, if there is one, or the raw mean. Means that
    /// differ only by rounding errors are the same.
    pub fn means(&self) -> Vec<f64> {
        let raw = || self.levels.iter().map(|level| level.summary.mean).collect();
        let means = self.marginal.clone().unwrap_or_else(raw);
        means.into_iter().map(|mean| (mean * 1e9).round() / 1e9).collect()
    }

    /// Returns the same results with the marginal means of the levels, if their raw means cannot be compared.
    /// `is_adjusted`: the model holds a number constant that differs between the levels.
    pub fn with_margins(&self, margin: impl Fn(&str) -> Option<f64>, is_adjusted: bool) -> Self {
        // If the ratings are separated, there may be no expected rating.
        let own = |level: &Group| margin(&level.names[0]).filter(|mean| mean.is_finite());
        let marginal: Option<Vec<f64>> = self.levels.iter().map(own).collect();
        let with = Self { marginal, comparable: false, ..self.clone() };
        let is_same = (self.course(), self.extremes()) == (with.course(), with.extremes());
        // If a factor varies only between participants, none of them could rate all levels.
        let is_raw = if self.comparable { is_same || !is_adjusted } else { is_same && !self.within };
        if is_raw { self.clone() } else { with }
    }

    /// Returns Kendall's τ-a between the means and the positions of the levels, if there is at least a tendency; 1 if the
    /// mean rises at every step.
    pub fn course(&self) -> Option<f64> {
        /// Minimum |τ| for a trend to be called a tendency.
        const TENDENCY: f64 = 0.7;
        let means = self.means();
        let mut sum = 0.0;
        for (index, first) in means.iter().enumerate() {
            for second in &means[index + 1..] {
                sum += f64::from(i8::from(second > first) - i8::from(second < first));
            }
        }
        let tau = sum / (means.len() * means.len().saturating_sub(1) / 2) as f64;
        (self.ordered && tau.abs() >= TENDENCY).then_some(tau)
    }

    /// Returns the indices of the levels with the highest and the lowest mean; among equal means, the first level is
    /// chosen.
    pub fn extremes(&self) -> (usize, usize) {
        let means = self.means();
        let by_mean = |l: &usize, r: &usize| means[*l].total_cmp(&means[*r]);
        let indices = || 0..self.levels.len();
        (indices().rev().max_by(by_mean).unwrap_or(0), indices().min_by(by_mean).unwrap_or(0))
    }

    /// Returns the two levels whose difference describes the effect, the earlier one first, and whether they were chosen because
    /// their means are the extremes: otherwise, they are the ends of a trend, or the only two levels.
    pub fn contrast(&self) -> ([usize; 2], bool) {
        let chosen = self.levels.len() > 2 && self.course().is_none();
        let (first, second) = if chosen { self.extremes() } else { (0, self.levels.len().saturating_sub(1)) };
        ([first.min(second), first.max(second)], chosen)
    }
}

impl Results {
    /// Returns the ratings on which the model was fitted.
    pub fn modeled(&self) -> &Counts {
        &self.whole.as_ref().unwrap_or(&self.measured).counts
    }

    /// Returns the number of participants.
    pub fn people(&self) -> usize {
        self.measured.counts.subjects.len()
    }

    /// Returns whether the results allow inferences about other people; those of one participant are about that person.
    pub fn is_inferential(&self) -> bool {
        self.people() > 1
    }

    /// Returns whether the model was asked to treat ratings by the same participant as independent.
    pub fn ignores_people(&self) -> bool {
        let is_repeated = self.subjects.iter().any(|subject| subject.group.summary.n > 1);
        self.is_inferential() && self.spec.random == Random::None && is_repeated
    }
}

/// Analyzes a study.
///
/// Descriptive statistics are always available. If there is no model, `model` gives the reason.
pub fn analyze(measured: Measured, options: &Options) -> Results {
    analyze_with(measured, options, &|_, _| ())
}

/// Analyzes a study. `progress` is called after each simulated study, with the number of those done and of all.
pub fn analyze_with(measured: Measured, options: &Options, progress: &(dyn Fn(usize, usize) + Sync)) -> Results {
    let covariates = covariates(&measured.counts, options);
    // The model needs them, and describes the same ratings as the rest.
    let measured = measured.complete(&covariates);
    let (spec, nested) = model_spec(&measured.counts, &covariates, options);
    let items = options.items.as_ref().and_then(|items| measured.counts.factor(items)).map(|(items, _)| items);
    // Agreement is about items, if there are any.
    let agreed = items.map(|_| measured.without_factors(&covariates));
    let left_out: Vec<usize> = covariates.into_iter().chain(items).collect();
    let (measured, whole) =
        if left_out.is_empty() { (measured, None) } else { (measured.without_factors(&left_out), Some(measured)) };
    let counts = &measured.counts;
    let modeled = whole.as_ref().map_or(counts, |whole| &whole.counts);
    let trials = &whole.as_ref().unwrap_or(&measured).trials;
    let people = counts.subjects.len();
    let described = |factor: usize| {
        // Conditions differ only in factors that can vary on their own.
        let is_tied = |other: &usize| counts.determines(*other, factor) || counts.determines(factor, *other);
        let tied: Vec<usize> = (0..counts.factors.len()).filter(is_tied).collect();
        if tied.is_empty() {
            return factor_results(&measured, factor);
        }
        let place = factor - tied.iter().filter(|other| **other < factor).count();
        factor_results(&measured.without_factors(&tied), place)
    };
    let factors: Vec<FactorResults> = (0..counts.factors.len()).into_par_iter().map(described).collect();
    let is_number = |other: &usize| spec.terms.has_number(&modeled.factors[*other].name);
    let numbers: Vec<usize> = (0..modeled.factors.len()).filter(is_number).collect();
    let with_margins = |factor: &FactorResults, margins: &[Margin]| {
        let is_own = |margin: &&Margin, level: &str| margin.factor == factor.name && margin.level == level;
        let differs = |own: usize| numbers.iter().any(|&number| modeled.differs_between(number, own));
        let is_adjusted = modeled.factor(&factor.name).is_some_and(|(own, _)| differs(own));
        factor.with_margins(|level| Some(margins.iter().find(|margin| is_own(margin, level))?.mean), is_adjusted)
    };
    let Options { resampling, unchecked, .. } = *options;
    let calibration = Calibration { resampling, trials, checks: !unchecked, progress };
    let agreed = agreed.as_ref().unwrap_or(&measured);
    let (model, (cells, alpha)) = rayon::join(
        || {
            fit_with_tests(modeled, &spec, Some(&calibration)).map(|mut report| {
                report.model.notes.splice(0..0, nested);
                report
            })
        },
        || (by_cell(counts), ordinal_alpha(&agreed.counts)),
    );
    let subjects: Vec<SubjectResults> = (by_subject(counts).into_iter())
        .zip(agreed.retests())
        .zip(measured.times_by(people, |row| Some(row.subject as usize)))
        .map(|((group, retest), time)| SubjectResults {
            group,
            retests: retest.len() as u64,
            kappa: kappa(&retest),
            time,
        })
        .collect();
    let margins = model.as_ref().map_or(&[][..], |report| &report.margins);
    let described = |factor: &FactorResults| FactorResults {
        // Ranks do not know of items.
        friedman: factor.friedman.filter(|_| options.items.is_none()),
        ..with_margins(factor, margins)
    };
    let factors = factors.iter().map(described).collect();
    let kappas: Vec<f64> = subjects.iter().filter_map(|subject| subject.kappa).collect();
    Results {
        cells,
        factors,
        subjects,
        covariates: spec.covariates.clone(),
        spec,
        model,
        alpha: if people > 1 { alpha } else { None },
        kappa: mean_kappa(&kappas),
        options: options.clone(),
        whole,
        measured,
    }
}

/// Returns the indices of the covariates.
pub(crate) fn covariates(counts: &Counts, options: &Options) -> Vec<usize> {
    let is_covariate = |&factor: &usize| {
        let name = &counts.factors[factor].name;
        match &options.covariates {
            _ if options.items.as_ref() == Some(name) => false,
            Some(names) => names.contains(name),
            None => counts.is_covariate(factor) || counts.factors[factor].levels.len() > MAX_LEVELS,
        }
    };
    (0..counts.factors.len()).filter(is_covariate).collect()
}

/// Returns the model, and notes about factors that it has not. By default, every factor that varies is a term, except those
/// that determine another one, and of two that determine each other the later one.
pub(super) fn model_spec(counts: &Counts, covariates: &[usize], options: &Options) -> (ModelSpec, Vec<Note>) {
    let name = |factor: usize| counts.factors[factor].name.clone();
    let is_varied = |factor: &usize| counts.factors[*factor].levels.len() > 1 && options.items != Some(name(*factor));
    let varied: Vec<usize> = (0..counts.factors.len()).filter(is_varied).collect();
    let determined = |own: usize| counts.determined_by(own, &varied).filter(|_| !covariates.contains(&own));
    let nested = |own: &usize| {
        determined(*own).map(|other| Note::Nested {
            factor: name(*own),
            other: name(other),
            varies: counts.is_within(*own),
        })
    };
    let main = |own: usize| {
        let variable =
            if covariates.contains(&own) { Variable::Number(name(own)) } else { Variable::Factor(name(own)) };
        determined(own).is_none().then(|| Term { variables: vec![variable] })
    };
    let all = || Terms::new(varied.iter().copied().filter_map(main));
    // A covariate that was asked for is in the model, whatever the other terms are.
    let named =
        options.covariates.iter().flatten().map(|name| Term { variables: vec![Variable::Number(name.clone())] });
    let asked = options.terms(counts).map(|terms| Terms::new(terms.iter().cloned().chain(named)));
    let notes = if asked.is_none() { varied.iter().filter_map(nested).collect() } else { Vec::new() };
    let spec = ModelSpec {
        link: options.link,
        random: options.random.unwrap_or(Random::Subject),
        slopes: options.slopes,
        items: options.items.clone(),
        covariates: covariates.iter().copied().map(name).collect(),
        max_coefficients: options.max_coefficients.unwrap_or(MAX_COEFFICIENTS),
        ..ModelSpec::new(asked.unwrap_or_else(all))
    };
    (spec, notes)
}

/// Describes one factor, given by index, and tests it by ranks.
pub fn factor_results(measured: &Measured, factor: usize) -> FactorResults {
    let counts = &measured.counts;
    let means = SubjectMeans::new(counts, factor);
    let level_of = |condition: u32| counts.conditions[condition as usize][factor].map(|level| level as usize);
    let levels = by_factor(counts, factor);
    let people = means.rows.len() as f64;
    let matched = |place: usize| means.rows.iter().filter_map(|(_, row)| row.get(place)).sum::<f64>() / people;
    let differs = |(place, level): (usize, &Group)| (level.summary.mean - matched(place)).abs() > 1e6 * means.tolerance;
    FactorResults {
        name: counts.factors[factor].name.clone(),
        comparable: means.incomplete.is_empty() && !levels.iter().enumerate().any(differs),
        levels,
        marginal: None,
        ordered: counts.factors[factor].is_ordered(),
        within: counts.is_within(factor),
        friedman: friedman(&means),
        matched: means,
        times: measured.times_by(counts.factors[factor].levels.len(), |row| level_of(row.condition)),
    }
}
