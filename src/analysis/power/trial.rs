//! One simulated study, analysed.

use nalgebra::DVector;

use super::{
    super::{
        ModelSpec,
        counts::Counts,
        fitting::{Fitted, fit_counts},
        mixed::MixedEnd,
        rank_tests::{SubjectMeans, friedman},
        standard,
        term_tests::without_terms,
    },
    hypothesis::{Hypothesis, Test},
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
    let predictors = (fitted.as_ref()).filter(|_| tests.is_some()).map(|fitted| predictors(fitted, counts));
    let outcome = |hypothesis: &Hypothesis| match (hypothesis.test, hypothesis.factor) {
        (Test::Friedman, Some(factor)) => {
            Outcome { p: friedman(&SubjectMeans::new(counts, factor)).map(|test| test.p), estimate: None }
        }
        _ => Outcome {
            p: (tests.iter().flatten()).find(|test| test.term == hypothesis.term).and_then(|test| test.p),
            estimate: (hypothesis.contrast.as_ref().zip(predictors.as_ref()))
                .map(|(contrast, predictors)| dot(contrast, predictors))
                .filter(|estimate| !estimate.is_nan()),
        },
    };
    hypotheses.iter().map(outcome).collect()
}

/// The fitted linear predictor of every condition, thresholds apart.
fn predictors(fitted: &Fitted, counts: &Counts) -> DVector<f64> {
    let mixed = fitted.mixed.as_ref().filter(|mixed| mixed.end != MixedEnd::Runaway);
    let parameters = mixed.map_or(&fitted.clm.parameters, |mixed| &mixed.parameters);
    let thresholds = fitted.frame.categories.len() - 1;
    let back = standard::back(&fitted.standards.0, &fitted.standards.1, thresholds, parameters.len());
    let mut coefficients = (back * parameters).rows(thresholds, fitted.x.columns.len()).clone_owned();
    if let Some(direction) = fitted.direction() {
        for column in (0..coefficients.len()).filter(|column| fitted.is_infinite(thresholds + column)) {
            coefficients[column] = direction[thresholds + column] * f64::INFINITY;
        }
    }
    let conditions: Vec<u32> = (0..counts.conditions.len() as u32).collect();
    let x = fitted.x.matrix(&conditions);
    DVector::from_iterator(x.nrows(), x.row_iter().map(|row| dot(&row.transpose(), &coefficients)))
}

/// The scalar product, where nothing of something infinite is nothing.
fn dot(weights: &DVector<f64>, values: &DVector<f64>) -> f64 {
    let pairs = weights.iter().zip(values.iter());
    pairs.filter(|(weight, _)| weight.abs() > 1e-12).map(|(weight, value)| weight * value).sum()
}
