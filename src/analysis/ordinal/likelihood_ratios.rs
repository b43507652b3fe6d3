//! Likelihood-ratio tests of each term, of proportional odds and of scale effects.

use rayon::prelude::*;
use serde::Serialize;

use super::{
    clm::FitEnd,
    design::Design,
    estimates::{self, Prediction, predictions},
    fitting::{Fitted, How, clm_data, fit_clm, fit_counts, fit_terms},
    model::{Model, ModelError, ModelSpec, Random},
    search::MixedFitEnd,
    terms::{Term, Terms},
};
use crate::analysis::counts::Counts;

/// The part of a model that a test concerns.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Part {
    /// Location: shifts the ratings.
    Location,
    /// Scale: changes the spread of the ratings.
    Scale,
    /// Effects that differ between the thresholds.
    Nominal,
}

/// A likelihood-ratio test of one term.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct TermTest {
    pub term: String,
    /// The part of the model in which the term is, or would be.
    pub part: Part,
    /// Twice the difference of the log-likelihoods; `None` if one of the models has no maximum.
    pub lr: Option<f64>,
    /// The difference in the number of parameters.
    pub df: usize,
    /// Probability of a larger ratio if the smaller model were true, from the χ² distribution.
    pub p: Option<f64>,
}

/// A model with its tests.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ModelReport {
    pub model: Model,
    /// Tests of each term against the model without it.
    pub terms: Vec<TermTest>,
    /// Tests of proportional odds.
    pub proportional_odds: Vec<TermTest>,
    /// The model's expected ratings in each condition on which it was fitted.
    pub predictions: Vec<Prediction>,
}

/// Fits a model and computes its tests and predictions.
///
/// # Errors
/// Returns the same errors as [`fit`](super::fit).
pub fn fit_with_tests(counts: &Counts, spec: &ModelSpec) -> Result<ModelReport, ModelError> {
    let full = fit_counts(counts, spec, true)?;
    let model = estimates::report(&full);
    let (terms, proportional_odds) = rayon::join(|| without_terms(&full), || nominal_tests(&full));
    Ok(ModelReport {
        terms: terms?,
        proportional_odds: proportional_odds?,
        predictions: predictions(&full, &model),
        model,
    })
}

/// Tests each term by the likelihood ratio against the model without it. A term that is part of an interaction in the
/// model is not tested, because the model without it would be the same model (as in R's `drop1`).
pub(crate) fn without_terms(full: &Fitted) -> Result<Vec<TermTest>, ModelError> {
    let parts = [(Part::Location, &full.spec.terms), (Part::Scale, &full.spec.scale)];
    let tested = parts.map(|(part, terms)| {
        terms.iter().filter(|term| !terms.is_marginal(term)).map(move |term| (part, term)).collect::<Vec<_>>()
    });
    let without = |(part, term): (Part, &Term)| {
        let mut spec = full.spec.clone();
        match part {
            Part::Location => spec.terms = spec.terms.without(term),
            _ => spec.scale = spec.scale.without(term),
        }
        let how = How { random: Some(&full.random), near: full.mixed.as_ref(), ..How::default() };
        let reduced = fit_terms(full.frame.clone(), spec, Vec::new(), how)?;
        let difference = comparable(full, &reduced).then(|| full.loglik() - reduced.loglik());
        Ok(TermTest::new(term, part, difference, full.rank().saturating_sub(reduced.rank())))
    };
    tested.concat().into_par_iter().map(without).collect()
}

/// Returns whether both fits found a maximum of the same kind of likelihood.
fn comparable(one: &Fitted, other: &Fitted) -> bool {
    let fine = |fitted: &Fitted| {
        fitted.clm.end != FitEnd::Stalled
            && !matches!(
                fitted.mixed.as_ref().map(|mixed| mixed.end),
                Some(MixedFitEnd::Diverged | MixedFitEnd::Stalled)
            )
    };
    fine(one) && fine(other) && one.mixed.is_some() == other.mixed.is_some()
}

/// Maximum number of parameters for a test of proportional odds. A separate effect of each level at each threshold
/// needs levels × thresholds parameters, and the time for a fit grows with the cube of their number. On a scale of 101
/// steps, the test would be useless.
const MAX_NOMINAL: usize = 300;

/// Tests proportional odds. Each term in turn gets a separate effect at each threshold, which is compared with one
/// common effect (R's `nominal_test`). The random intercept is omitted, because this checks the scale and not the
/// effects. A test with more than [`MAX_NOMINAL`] parameters is not performed and has no ratio.
fn nominal_tests(full: &Fitted) -> Result<Vec<TermTest>, ModelError> {
    let with_separate_effects = |term: &Term| {
        let own = Terms::new([term.clone()]);
        let nominal = Design::new(&full.frame, &own)?.independent(&full.frame);
        let x = full.x.independent_of(&nominal, &full.frame);
        let (data, _) = clm_data(&full.frame, full.spec.link, &x, &nominal, &full.scale);
        let thresholds = data.thresholds();
        let df = (thresholds * nominal.columns.len() + x.columns.len()).saturating_sub(full.x.columns.len());
        let feasible = thresholds * (1 + nominal.columns.len()) + x.columns.len() <= MAX_NOMINAL;
        let fit = if feasible { fit_clm(&data).ok() } else { None };
        let difference = fit.filter(|fit| fit.end != FitEnd::Stalled && full.clm.end != FitEnd::Stalled);
        Ok(TermTest::new(term, Part::Nominal, difference.map(|fit| fit.loglik - full.clm.loglik), df))
    };
    full.spec.terms.iter().collect::<Vec<_>>().into_par_iter().map(with_separate_effects).collect()
}

/// Tests scale effects. Each location term in turn may also affect the spread of the ratings (R's `scale_test`). The
/// random intercept is omitted.
///
/// # Errors
/// The same as for [`fit`](super::fit).
pub fn scale_tests(counts: &Counts, spec: &ModelSpec) -> Result<Vec<TermTest>, ModelError> {
    let spec = ModelSpec { random: Random::None, ..spec.clone() };
    let full = fit_counts(counts, &spec, true)?;
    let mut tests = Vec::new();
    for term in full.spec.terms.iter().filter(|term| !full.spec.scale.has(term)) {
        let mut spec = full.spec.clone();
        spec.scale = Terms::new(spec.scale.iter().cloned().chain([term.clone()]));
        let larger = fit_terms(full.frame.clone(), spec, Vec::new(), How::default())?;
        let difference = comparable(&larger, &full).then(|| larger.loglik() - full.loglik());
        tests.push(TermTest::new(term, Part::Scale, difference, larger.rank().saturating_sub(full.rank())));
    }
    Ok(tests)
}

impl TermTest {
    /// Creates a test from the difference of two log-likelihoods.
    fn new(term: &Term, part: Part, difference: Option<f64>, df: usize) -> Self {
        let lr = difference.filter(|_| df > 0).map(|difference| (2.0 * difference).max(0.0));
        Self { term: term.to_string(), part, lr, df, p: lr.map(|lr| chi_squared_tail(lr, df)) }
    }
}

/// Returns P(χ² > x) for `df` degrees of freedom.
pub(crate) fn chi_squared_tail(x: f64, df: usize) -> f64 {
    if x <= 0.0 { 1.0 } else { statrs::function::gamma::gamma_ur(df as f64 / 2.0, x / 2.0) }
}
