//! Which model: each level is left out in turn and predicted from the others; the model that predicts best is chosen.
//!
//! Levels 0 and 1 stay: no model knows a black and a white that were not read.

use super::{models::Curve, sample::Sample};

/// How many times the least error a simpler model may have, whatever its standard error: with few
/// levels that is poorly known.
const MOST_TIMES: f64 = 1.5;
/// Mean squared errors below this, in units of the assumed noise, are none.
const EXACT: f64 = 1e-8;

/// How well a model predicts levels that it was not fitted to.
#[derive(Clone, Debug, PartialEq)]
pub struct CrossValidation {
    /// Root mean square error, 8-bit codes.
    pub rms_codes: f64,
    /// Root mean square error, cd/m².
    pub rms_cd_m2: f64,
    /// Largest error, 8-bit codes.
    pub largest_codes: f64,
    /// Mean squared error in units of the readings' noise: 1 or little more where the model is right.
    pub score: f64,
    /// The squared error at each level of each channel, in a fixed order and in units of the assumed noise.
    squares: Vec<f64>,
}

impl CrossValidation {
    /// With the score in units of a noise, relative to the assumed one.
    pub(super) fn against(self, noise: f64) -> Self {
        Self { score: mean(&self.squares) / noise.powi(2).max(f64::MIN_POSITIVE), ..self }
    }

    /// Mean squared error in units of the assumed noise.
    pub(super) fn square(&self) -> f64 {
        mean(&self.squares)
    }
}

/// Leaves out level by level; `fitted_to` fits the model to the rest.
pub(super) fn validate(sample: &Sample, fitted_to: impl Fn(&Sample) -> Vec<Curve>) -> CrossValidation {
    let (mut codes, mut cd_m2, mut squares) = (Vec::new(), Vec::new(), Vec::new());
    for level in sample.inner_levels() {
        let (rest, left_out) = sample.split_at(level);
        for (channel, curve) in sample.channels.iter().zip(fitted_to(&rest)) {
            let Some((y, sd)) = left_out.mean(|point| point.channel == *channel) else { continue };
            let error = y - curve.cd_m2(level);
            codes.push((255.0 * (curve.encoded(y) - level)).powi(2));
            cd_m2.push(error.powi(2));
            squares.push((error / sd).powi(2));
        }
    }
    CrossValidation {
        rms_codes: mean(&codes).sqrt(),
        rms_cd_m2: mean(&cd_m2).sqrt(),
        largest_codes: codes.iter().copied().fold(0.0, f64::max).sqrt(),
        score: mean(&squares),
        squares,
    }
}

/// Index of the model to use, the first being the simplest: the simplest whose error is within one standard error of the
/// least one (Hastie, Tibshirani & Friedman 2009, The Elements of Statistical Learning, §7.10), the standard error being
/// that of the difference at the same levels, and at most [`MOST_TIMES`] the least.
pub(super) fn simplest_of_the_best(models: &[&CrossValidation]) -> usize {
    let least = models.iter().min_by(|a, b| a.square().total_cmp(&b.square()));
    let is_as_good = |model: &&CrossValidation| {
        let Some(least) = least else { return true };
        let differences: Vec<f64> = model.squares.iter().zip(&least.squares).map(|(a, b)| a - b).collect();
        let (n, excess) = (differences.len() as f64, mean(&differences));
        let variance = differences.iter().map(|d| (d - excess).powi(2)).sum::<f64>() / (n - 1.0).max(1.0);
        let bound = MOST_TIMES.powi(2) * least.square().max(EXACT);
        model.square() <= EXACT || excess <= (variance / n).sqrt() && model.square() <= bound
    };
    models.iter().position(is_as_good).unwrap_or(0)
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}
