//! A model with tests and intervals that hold for few participants: the parametric bootstrap where the χ² distribution is
//! not accurate, and profile intervals.

use rayon::prelude::*;
use serde::Serialize;

use super::{
    checks::{self, Checks, Order, order},
    estimates::{self, Prediction, predictions},
    fitting::{Fitted, fit_counts},
    interactions::{Interaction, interactions},
    likelihood_ratios::{TermTest, recoded, without_terms},
    margins::{self, Comparison, Margin},
    model::{Coefficient, Model, ModelError, ModelSpec},
    profile,
    resampling::{Resampling, simulate},
    terms::Term,
};
use crate::{
    analysis::{
        counts::{Counts, Trial},
        frame::{Frame, factors_of},
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

/// Fits a model and computes its tests, intervals and predictions. Without a `calibration`, probabilities and intervals are those
/// of the χ² and the normal distribution, and neither interactions nor the order of the trials nor the fit are examined.
///
/// # Errors
/// Returns the same errors as [`fit`](super::fit).
pub fn fit_with_tests(
    counts: &Counts,
    spec: &ModelSpec,
    calibration: Option<&Calibration<'_>>,
) -> Result<ModelReport, ModelError> {
    let full = fit_counts(counts, spec, true)?;
    let recoded = recoded(&full, calibration.is_some());
    let (mut model, mut terms) = (estimates::report(&full), without_terms(&full, recoded.as_ref()));
    let mut tested = Vec::new();
    if let Some(calibration) = calibration {
        for test in &mut terms {
            // A distribution that is not accurate even if it is simulated.
            if let Some(reason) = full.withheld(&test.term) {
                (test.p, test.withheld) = (None, Some(reason));
            }
        }
        calibrate_tests((&full, recoded.as_ref()), &mut terms, calibration);
        tested = interactions(&full, calibration.resampling);
        if full.mixed.is_some() && full.frame.subjects.len() < FEW_FOR_LIKELIHOOD_RATIOS {
            // Wald's test rejects too often.
            model.coefficients.iter_mut().for_each(|coefficient| coefficient.p = None);
        }
        profile_coefficients(&full, &terms, &mut model.coefficients);
    }
    let seed = calibration.map_or(0, |calibration| calibration.resampling.seed);
    Ok(ModelReport {
        interactions: tested,
        predictions: predictions(&full, &model),
        margins: margins::margins(&full, &model),
        comparisons: margins::comparisons(&full, &model, &terms),
        order: calibration.and_then(|calibration| order(&full, calibration.trials, seed)),
        checks: calibration.filter(|calibration| calibration.checks).map(|_| checks::checks(&full, seed)),
        terms,
        model,
    })
}

/// Replaces the probabilities and limits of the tests of terms by simulated ones, where they are simulated.
fn calibrate_tests((full, recoded): (&Fitted, Option<&Fitted>), tests: &mut [TermTest], calibration: &Calibration<'_>) {
    let is_simulated = |test: &TermTest| {
        let parameters = full.frame.categories.len() - 1 + full.rank() + test.df;
        let is_uncertain = full.mixed.is_some() || full.frame.total() < MANY_PER_PARAMETER * parameters as u64;
        test.withheld.is_none() && is_uncertain && needs_simulation(&full.frame, &test.term)
    };
    let mut tests: Vec<&mut TermTest> = tests.iter_mut().filter(|test| is_simulated(test)).collect();
    let tested: Vec<(&Term, f64)> = tests.iter().filter_map(|test| Some((&test.term, test.chi_squared?))).collect();
    if tested.is_empty() {
        return;
    }
    let settings = calibration.resampling;
    let done = std::sync::atomic::AtomicUsize::new(0);
    let progress = || {
        let done = done.fetch_add(1, std::sync::atomic::Ordering::Relaxed) + 1;
        (calibration.progress)(done, settings.draws as usize);
    };
    let simulated = simulate(full, recoded, &tested, settings, &progress);
    let is_separated = full.infinite().next().is_some();
    tests.iter_mut().zip(simulated).for_each(|(test, ratios)| test.calibrate(&ratios, is_separated));
}

/// Returns whether the ratio of a term does not have a χ² distribution with this number of participants. A few who rated
/// several levels of a factor do not make it one that varies within participants.
fn needs_simulation(frame: &Frame, term: &Term) -> bool {
    let people = frame.subjects.len();
    let is_between = || factors_of(frame.counts, term).any(|factor| !frame.counts.is_within(factor));
    people < FEW_FOR_LIKELIHOOD_RATIOS || people < FEW_BETWEEN && is_between()
}

fn profile_coefficients(full: &Fitted, tests: &[TermTest], coefficients: &mut [Coefficient]) {
    let are_profiled = coefficients.len() <= MAX_PROFILES;
    coefficients.par_iter_mut().enumerate().for_each(|(column, coefficient)| {
        // The coefficients of a term in an interaction are simple effects, and have their intervals, so that a difference has one
        // interval.
        let mut limits = tests.iter().filter(|test| test.term.contains(&coefficient.term)).map(TermTest::limit);
        let Ok(limit) = limits.try_fold(0.0, |most: f64, limit| limit.map(|limit| most.max(limit))) else {
            coefficient.interval = None;
            return;
        };
        let is_profiled = are_profiled && !full.spec.terms.is_marginal(&coefficient.term);
        coefficient.interval = (coefficient.se.filter(|_| is_profiled && coefficient.estimate.is_finite()))
            .and_then(|se| profile::interval(full, column, coefficient.estimate, se, limit))
            .or_else(|| Interval::around(coefficient.estimate, coefficient.se, limit.sqrt()));
    });
}
