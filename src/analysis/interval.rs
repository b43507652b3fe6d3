//! Intervals: of a mean over participants, and from an estimate and its standard error. Ratings by the same person are
//! related, so the unit of every mean is the person.

use serde::Serialize;
use statrs::distribution::{ContinuousCDF as _, StudentsT};

use crate::light::random::Z_95;

/// An interval around an estimate.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Interval {
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

impl Interval {
    /// Returns the 95 % interval of an estimate from its standard error, or `None` if either is missing or not finite.
    pub fn wald(estimate: f64, se: Option<f64>) -> Option<Self> {
        Self::around(estimate, se, Z_95)
    }

    /// Returns the interval that reaches a number of standard errors from an estimate, or `None` if either is missing
    /// or not finite.
    pub fn around(estimate: f64, se: Option<f64>, errors: f64) -> Option<Self> {
        let reach = errors * se.filter(|se| se.is_finite() && estimate.is_finite())?;
        Some(Self { low: estimate - reach, high: estimate + reach })
    }
}

/// Returns the 97.5 % quantile of the t distribution, or infinity without degrees of freedom.
pub fn t_quantile(df: f64) -> f64 {
    StudentsT::new(0.0, 1.0, df).map_or(f64::INFINITY, |distribution| distribution.inverse_cdf(0.975))
}

/// Returns the mean and the standard deviation (with n − 1) of a sample; NaN for too few values.
pub(super) fn mean_and_sd(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    (mean, (values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (n - 1.0)).sqrt())
}

/// Returns the 95 % t interval of the mean of a sample, one value for each participant. `None` if there are fewer than
/// two values or all are the same: then nothing is known about how other participants differ.
pub(super) fn t_interval(values: &[f64]) -> Option<Interval> {
    let (mean, sd) = mean_and_sd(values);
    let n = values.len() as f64;
    let se = Some(sd / n.sqrt()).filter(|se| *se > 1e-12 * (1.0 + mean.abs()));
    Interval::around(mean, se, t_quantile(n - 1.0))
}

/// Returns the 95 % interval of the mean of `n` values between `ends` with this mean and standard deviation. `None` as
/// for [`t_interval`].
///
/// It is the t interval with the score of Wilson (1927, J. Am. Stat. Assoc. 22, 209): the variance is not that at the
/// sample's mean but that at the value in question, taken as proportional to its distances from both ends. So it stays
/// between the ends and also covers where most ratings are at an end. Simulated coverage: docs/statistics.md.
pub(super) fn score_interval(n: f64, mean: f64, sd: f64, [low, high]: [f64; 2]) -> Option<Interval> {
    let span = high - low;
    let (share, sd) = ((mean - low) / span, sd / span);
    let variance = share * (1.0 - share);
    if !(sd > 1e-9 && variance > 0.0) {
        return None;
    }
    let square = t_quantile(n - 1.0).powi(2) * sd * sd / (variance * n);
    let middle = (share + square / 2.0) / (1.0 + square);
    let half = (square * variance + square * square / 4.0).sqrt() / (1.0 + square);
    Some(Interval { low: low + span * (middle - half).max(0.0), high: low + span * (middle + half).min(1.0) })
}
