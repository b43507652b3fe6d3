//! Statistics that several rooms need: intervals, quantiles and tail probabilities of distributions, the correction for
//! multiple testing, and random orders.

use rand_chacha::{ChaCha8Rng, rand_core::Rng as _};
use serde::Serialize;
use statrs::{
    distribution::{ChiSquared, ContinuousCDF as _, StudentsT},
    function::{beta::inv_beta_reg, erf::erfc, gamma::gamma_ur},
};

/// The number of standard errors from an estimate to either end of its 95 % interval: the 97.5 % quantile of the normal
/// distribution.
pub const Z_95: f64 = 1.959_963_984_540_054;

/// An interval around an estimate.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Interval {
    /// Lower end.
    #[serde(serialize_with = "crate::text::as_cell")]
    pub low: f64,
    /// Upper end.
    #[serde(serialize_with = "crate::text::as_cell")]
    pub high: f64,
}

impl Interval {
    /// Returns the interval that reaches a number of standard errors from an estimate, or `None` if either is missing
    /// or not finite.
    pub fn around(estimate: f64, se: Option<f64>, errors: f64) -> Option<Self> {
        let reach = errors * se.filter(|se| se.is_finite() && estimate.is_finite())?;
        Some(Self { low: estimate - reach, high: estimate + reach })
    }

    /// Returns whether a value lies in the interval.
    pub fn contains(&self, value: f64) -> bool {
        (self.low..=self.high).contains(&value)
    }

    /// Returns the interval of a function of the estimate, which rises or falls throughout.
    #[must_use]
    pub fn map(self, function: impl Fn(f64) -> f64) -> Self {
        let (one, other) = (function(self.low), function(self.high));
        Self { low: one.min(other), high: one.max(other) }
    }

    /// Returns the 95 % t interval of the mean of a sample, one value for each participant. `None` if there are fewer
    /// than two values or all are the same: then nothing is known about how other participants differ.
    pub fn of_mean(values: &[f64]) -> Option<Self> {
        let (mean, sd) = mean_and_sd(values);
        let n = values.len() as f64;
        let se = Some(sd / n.sqrt()).filter(|se| *se > 1e-12 * (1.0 + mean.abs()));
        Self::around(mean, se, t_quantile(n - 1.0))
    }

    /// Returns the 95 % interval of the mean of `n` values between `ends` with this mean and standard deviation. `None`
    /// as for [`Self::of_mean`].
    ///
    /// It is the t interval with the score of Wilson (1927, J. Am. Stat. Assoc. 22, 209): the variance is not that at
    /// the sample's mean but that at the value in question, taken as proportional to its distances from both ends. So it
    /// stays between the ends and also covers where most ratings are at an end. Simulated coverage: docs/statistics.md.
    pub fn of_bounded_mean(n: f64, mean: f64, sd: f64, [low, high]: [f64; 2]) -> Option<Self> {
        let span = high - low;
        let (share, sd) = ((mean - low) / span, sd / span);
        let variance = share * (1.0 - share);
        if !(sd > 1e-9 && variance > 0.0) {
            return None;
        }
        let square = t_quantile(n - 1.0).powi(2) * sd * sd / (variance * n);
        let middle = (share + square / 2.0) / (1.0 + square);
        let half = (square * variance + square * square / 4.0).sqrt() / (1.0 + square);
        Some(Self { low: low + span * (middle - half).max(0.0), high: low + span * (middle + half).min(1.0) })
    }

    /// Returns the exact 95 % interval of Clopper & Pearson (1934), Biometrika 26, 404, for `found` out of `all`.
    pub fn of_proportion(found: usize, all: usize) -> Self {
        let tail = 0.025;
        let (k, n) = (found as f64, all as f64);
        // P(X ≥ k) rises with the proportion, and P(X ≤ k) falls. Both are incomplete beta functions.
        let low = if found == 0 { 0.0 } else { inv_beta_reg(k, n - k + 1.0, tail) };
        let high = if found >= all { 1.0 } else { inv_beta_reg(k + 1.0, n - k, 1.0 - tail) };
        Self { low, high }
    }
}

/// Returns the mean and the standard deviation (with n − 1) of a sample; NaN for too few values.
pub fn mean_and_sd(values: &[f64]) -> (f64, f64) {
    let n = values.len() as f64;
    let mean = values.iter().sum::<f64>() / n;
    (mean, (values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (n - 1.0)).sqrt())
}

/// Returns the median; `None` without values, or halfway between two opposite infinite values.
pub fn median(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    let (low, high) = (values.get(values.len().checked_sub(1)? / 2)?, values.get(values.len() / 2)?);
    // The mean of two equal infinite values is infinite.
    Some(if low == high { *low } else { (low + high) / 2.0 }).filter(|median| !median.is_nan())
}

/// Returns the two-sided probability of a standard normal z.
pub fn normal_two_sided(z: f64) -> f64 {
    erfc(z.abs() * std::f64::consts::FRAC_1_SQRT_2)
}

/// Returns the 97.5 % quantile of the t distribution: that of the normal distribution if the degrees of freedom are
/// infinite, and infinity without degrees of freedom.
pub fn t_quantile(df: f64) -> f64 {
    if df == f64::INFINITY {
        return Z_95;
    }
    StudentsT::new(0.0, 1.0, df).map_or(f64::INFINITY, |distribution| distribution.inverse_cdf(0.975))
}

/// Returns the two-sided probability of a value of the t distribution.
pub fn t_two_sided(t: f64, df: f64) -> f64 {
    StudentsT::new(0.0, 1.0, df).map_or(f64::NAN, |distribution| 2.0 * distribution.sf(t.abs()))
}

/// Returns P(χ² > x) for `df` degrees of freedom.
pub fn chi_squared_tail(x: f64, df: usize) -> f64 {
    if x <= 0.0 { 1.0 } else { gamma_ur(df as f64 / 2.0, x / 2.0) }
}

/// Returns the quantile of the χ² distribution below which this share of it lies; NaN without degrees of freedom.
pub fn chi_squared_quantile(share: f64, df: f64) -> f64 {
    ChiSquared::new(df).map_or(f64::NAN, |distribution| distribution.inverse_cdf(share))
}

/// Corrects probabilities for multiple testing by Holm's method (1979). The results are in the order of
/// `probabilities`. A test without a probability does not count.
pub fn holm(probabilities: &[Option<f64>]) -> Vec<Option<f64>> {
    let mut order: Vec<(f64, usize)> =
        probabilities.iter().zip(0..).filter_map(|(p, index)| Some(((*p)?, index))).collect();
    order.sort_by(|l, r| l.0.total_cmp(&r.0));
    let mut corrected = vec![None; probabilities.len()];
    let mut most: f64 = 0.0;
    for (rank, (p, index)) in order.iter().enumerate() {
        most = most.max((order.len() - rank) as f64 * p).min(1.0);
        corrected[*index] = Some(most);
    }
    corrected
}

/// Puts `items` into a random order with the Fisher–Yates shuffle. It is implemented here so that no new version of a
/// library can change the orders that a seed gives.
pub fn shuffle<T>(items: &mut [T], rng: &mut ChaCha8Rng) {
    for i in (1..items.len()).rev() {
        items.swap(i, below(rng, i as u64 + 1) as usize);
    }
}

/// Returns a uniform random number in `0..bound`. Rejection makes every value equally likely. `bound` must be above 0.
fn below(rng: &mut ChaCha8Rng, bound: u64) -> u64 {
    let limit = u64::MAX - u64::MAX % bound;
    loop {
        let draw = rng.next_u64();
        if draw < limit {
            return draw % bound;
        }
    }
}
