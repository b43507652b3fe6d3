//! A model with tests and intervals that hold for few participants: the parametric bootstrap where the χ² distribution is
//! not accurate, and profile intervals.

use rayon::prelude::*;
use serde::Serialize;

use super::{
    checks::{self, Checks, Order, order},
    estimates::{self, Prediction, predictions},
    fitting::{Fitted, fit_counts},
    interactions::{Interaction, interactions},
    likelihood_ratios::{TermTest, Withheld, quantile, recoded, without_terms},
    margins::{self, Comparison, Margin},
    model::{Model, ModelError, ModelSpec},
    profile::{self, chi_squared_limit},
    resampling::{Resampling, simulate},
    terms::Term,
};
use crate::{
    analysis::{
        counts::{Counts, Trial},
        frame::{Frame, find_factor},
    },
    statistics::Interval,
};

/// With fewer participants than this, likelihood ratios are calibrated by simulation.
pub const FEW_FOR_LIKELIHOOD_RATIOS: usize = 41;
/// A term that varies only between participants is calibrated by simulation up to this number of participants.
const FEW_BETWEEN: usize = 100;
/// Maximum number of coefficients with profile intervals; the others have Wald intervals.
const MAX_PROFILES: usize = 60;
/// Number of ratings for each parameter of the wider model from which the ratio of a test without random effects has a χ²
/// distribution.
const MANY_PER_PARAMETER: u64 = 50;

/// A model with its tests.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ModelReport {
    #[serde(flatten)]
    pub model: Model,
    /// Tests of each term against the model without it.
    #[serde(rename = "likelihood_ratio")]
    pub terms: Vec<TermTest>,
    /// Tests of the two-way interactions that the model leaves out.
    pub interactions: Vec<Interaction>,
    /// The model's expected ratings in each condition on which it was fitted.
    #[serde(skip)]
    pub predictions: Vec<Prediction>,
    /// The model's expected ratings at each level of each factor.
    pub margins: Vec<Margin>,
    /// Differences between levels.
    pub comparisons: Vec<Comparison>,
    /// How ratings depend on the order of the trials, if it is known.
    pub order: Option<Order>,
    /// How well the model describes the data; only for the main analysis.
    pub checks: Option<Checks>,
}

/// Fits a model and computes its tests, with probabilities from the χ² distribution, and its predictions.
///
/// # Errors
/// Returns the same errors as [`fit`](super::fit).
pub fn fit_with_tests(counts: &Counts, spec: &ModelSpec) -> Result<ModelReport, ModelError> {
    let full = fit_counts(counts, spec, true)?;
    let mut report = report_with_tests(&full, recoded(&full, false).as_ref())?;
    report.comparisons = margins::comparisons(&full, &report.model, &usual_limits(&full), &report.terms);
    Ok(report)
}

fn report_with_tests(full: &Fitted, recoded: Option<&Fitted>) -> Result<ModelReport, ModelError> {
    let model = estimates::report(full);
    Ok(ModelReport {
        terms: without_terms(full, recoded)?,
        interactions: Vec::new(),
        predictions: predictions(full, &model),
        margins: margins::margins(full, &model),
        comparisons: Vec::new(),
        order: None,
        checks: None,
        model,
    })
}

/// For each term, the limit of its likelihood ratio for one degree of freedom, which may be simulated, or the reason why
/// its test is withheld: there are then no intervals or comparisons either.
pub(super) type Limits = Vec<Result<f64, Withheld>>;

fn usual_limits(full: &Fitted) -> Limits {
    vec![Ok(chi_squared_limit(1)); full.spec.terms.iter().count()]
}

/// How to calibrate tests and intervals.
#[derive(Clone, Copy)]
pub struct Calibration<'a> {
    pub resampling: Resampling,
    /// The trials that are known one by one.
    pub trials: &'a [Trial],
    /// Whether to compute [`ModelReport::checks`].
    pub checks: bool,
    /// Called after each simulated study, with the number of those done and of all.
    pub progress: &'a (dyn Fn(usize, usize) + Sync),
}

/// Fits a model and computes its tests, intervals and predictions.
///
/// # Errors
/// Returns the same errors as [`fit`](super::fit).
pub fn fit_calibrated(
    counts: &Counts,
    spec: &ModelSpec,
    calibration: &Calibration<'_>,
) -> Result<ModelReport, ModelError> {
    let full = fit_counts(counts, spec, true)?;
    let recoded = recoded(&full, true);
    let mut report = report_with_tests(&full, recoded.as_ref())?;
    for (test, term) in report.terms.iter_mut().zip(full.spec.terms.iter()) {
        // A distribution that is not accurate even if it is simulated.
        if let Some(reason) = full.withheld(term) {
            (test.p, test.withheld) = (None, Some(reason));
        }
    }
    let mut limits = usual_limits(&full);
    calibrate_tests((&full, recoded.as_ref()), &mut report.terms, &mut limits, calibration);
    for (limit, test) in limits.iter_mut().zip(&report.terms) {
        // Where a mean effect has no test, the coefficients of the term are effects in the larger one.
        let reason = test.withheld.filter(|reason| *reason != Withheld::EmptyCells);
        *limit = reason.map_or(*limit, Err);
    }
    report.interactions = interactions(&full, calibration.resampling);
    report.order = order(&full, calibration.trials, calibration.resampling.seed);
    if full.mixed.is_some() && full.frame.subjects.len() < FEW_FOR_LIKELIHOOD_RATIOS {
        // Wald's test rejects too often.
        report.model.coefficients.iter_mut().for_each(|coefficient| coefficient.p = None);
    }
    profile_coefficients(&full, &mut report.model, &limits);
    report.comparisons = margins::comparisons(&full, &report.model, &limits, &report.terms);
    for own in report.comparisons.iter_mut().filter(|own| own.at.is_none() && own.p.is_some()) {
        // The only difference of a term has the term's probability.
        let is_own = |test: &&TermTest| test.df == 1 && test.term == Term::factor(&own.factor);
        if let Some(p) = report.terms.iter().find(is_own).and_then(|test| test.p) {
            (own.p, own.p_holm) = (Some(p), Some(p));
        }
    }
    report.checks = (calibration.checks).then(|| checks::checks(&full, calibration.resampling.seed));
    Ok(report)
}

/// Replaces the probabilities of the tests of terms by simulated ones, and the limits of the profiles, where they are
/// simulated.
fn calibrate_tests(
    (full, recoded): (&Fitted, Option<&Fitted>),
    tests: &mut [TermTest],
    limits: &mut Limits,
    calibration: &Calibration<'_>,
) {
    let terms: Vec<&Term> = full.spec.terms.iter().collect();
    let is_uncertain = |test: &TermTest| {
        let parameters = full.frame.categories.len() - 1 + full.rank() + test.df;
        full.mixed.is_some() || full.frame.total() < MANY_PER_PARAMETER * parameters as u64
    };
    let ratio = |place: usize| {
        let test = &tests[place];
        let is_simulated = test.withheld.is_none() && is_uncertain(test) && needs_simulation(&full.frame, terms[place]);
        test.chi_squared.filter(|_| is_simulated).map(|lr| (place, lr))
    };
    let places: Vec<(usize, f64)> = (0..terms.len()).filter_map(ratio).collect();
    if places.is_empty() {
        return;
    }
    let settings = calibration.resampling;
    let done = std::sync::atomic::AtomicUsize::new(0);
    let progress = || {
        let done = done.fetch_add(1, std::sync::atomic::Ordering::Relaxed) + 1;
        (calibration.progress)(done, settings.draws as usize);
    };
    let tested: Vec<(&Term, f64)> = places.iter().map(|&(place, lr)| (terms[place], lr)).collect();
    let simulated = simulate(full, recoded, &tested, settings, &progress);
    // If the ratings are separated, those of the simulated studies are too, and their ratios are too small.
    let is_separated = full.infinite().next().is_some();
    for ((place, _), ratios) in places.into_iter().zip(simulated) {
        let test = &mut tests[place];
        let usual = test.p;
        test.calibrate(&ratios);
        if is_separated && test.p < usual && test.p.is_some() {
            (test.p, test.draws, test.p_error) = (usual, None, None);
        }
        // The distribution of a ratio with several degrees of freedom differs from χ² by about the same factor.
        if let Some(simulated) = quantile(&ratios, profile::LEVEL) {
            let factor = simulated / chi_squared_limit(test.df);
            limits[place] = limits[place].map(|limit| limit * if is_separated { factor.max(1.0) } else { factor });
        }
    }
}

/// Returns whether the ratio of a term does not have a χ² distribution with this number of participants. A few who rated
/// several levels of a factor do not make it one that varies within participants.
fn needs_simulation(frame: &Frame, term: &Term) -> bool {
    let mut factors = term.variables.iter().filter_map(|variable| find_factor(frame.counts, variable).ok());
    let people = frame.subjects.len();
    people < FEW_FOR_LIKELIHOOD_RATIOS
        || (people < FEW_BETWEEN && factors.any(|(factor, _)| !frame.counts.is_within(factor)))
}

fn profile_coefficients(full: &Fitted, model: &mut Model, limits: &Limits) {
    let columns = &full.x.columns;
    let profiled = columns.len() <= MAX_PROFILES;
    model.coefficients.par_iter_mut().enumerate().for_each(|(column, coefficient)| {
        let Ok(limit) = largest(full, limits, columns[column].term) else {
            coefficient.interval = None;
            return;
        };
        let profiled = profiled && !full.spec.terms.is_marginal(full.term_of(column));
        coefficient.interval = (coefficient.se.filter(|_| profiled && coefficient.estimate.is_finite()))
            .and_then(|se| profile::interval(full, column, coefficient.estimate, se, limit))
            .or_else(|| Interval::around(coefficient.estimate, coefficient.se, limit.sqrt()));
    });
}

/// Returns the largest limit of a term, given by index, and of those that contain it, or the reason why there is none. The
/// coefficients of a term in an interaction are simple effects, and have their intervals, so that a difference has one interval.
fn largest(full: &Fitted, limits: &Limits, term: usize) -> Result<f64, Withheld> {
    let terms = full.spec.terms.iter().as_slice();
    let own = terms.iter().zip(limits).filter(|(other, _)| other.contains(&terms[term]));
    own.map(|(_, limit)| *limit).try_fold(0.0, |most: f64, limit| Ok(most.max(limit?)))
}
