//! One simulated study, analyzed.

use super::hypothesis::{Hypothesis, Test};
use crate::analysis::{
    ModelSpec,
    counts::Counts,
    ordinal::{finite_product, fit_counts, predictors, without_terms},
    rank_tests::{SubjectMeans, friedman},
};

/// What one study says about one hypothesis.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Outcome {
    /// Probability by the test; none where there is no test, as without a model.
    pub p: Option<f64>,
    /// Estimate of the effect; infinite where the ratings are separated.
    pub estimate: Option<f64>,
}

/// The outcome of every hypothesis.
pub(super) fn outcomes(counts: &Counts, spec: &ModelSpec, hypotheses: &[Hypothesis]) -> Vec<Outcome> {
    // Without standard errors, which no likelihood-ratio test needs.
    let fitted = fit_counts(counts, spec, false).ok();
    let tests = fitted.as_ref().and_then(|fitted| without_terms(fitted).ok());
    let conditions: Vec<u32> = (0..counts.conditions.len() as u32).collect();
    let predictors = (fitted.as_ref()).filter(|_| tests.is_some()).map(|fitted| predictors(fitted, &conditions));
    let outcome = |hypothesis: &Hypothesis| match (hypothesis.test, hypothesis.factor) {
        (Test::Friedman, Some(factor)) => {
            Outcome { p: friedman(&SubjectMeans::new(counts, factor)).map(|test| test.p), estimate: None }
        }
        _ => Outcome {
            p: (tests.iter().flatten()).find(|test| test.term == hypothesis.term).and_then(|test| test.p),
            estimate: (hypothesis.contrast.as_ref().zip(predictors.as_ref()))
                .map(|(contrast, predictors)| finite_product(contrast.iter(), predictors.iter()))
                .filter(|estimate| !estimate.is_nan()),
        },
    };
    hypotheses.iter().map(outcome).collect()
}
