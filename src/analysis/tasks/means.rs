//! Means over people.

use serde::Serialize;

use crate::statistics::{Interval, mean_and_sd, t_quantile, t_two_sided};

/// The mean of one value of each person.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Mean {
    /// The mean, in the unit of the values; NaN without people.
    pub mean: f64,
    /// Its 95 % t interval; `None` for fewer than two people, or if all values are the same.
    pub interval: Option<Interval>,
    /// Number of people.
    pub people: usize,
}

impl Mean {
    /// Returns the mean of one value of each person.
    pub fn new(values: &[f64]) -> Self {
        Self { mean: mean_and_sd(values).0, interval: Interval::of_mean(values), people: values.len() }
    }

    /// Returns the mean of one value of each person, none of which can be outside these ends, and neither can its interval.
    pub fn bounded(values: &[f64], ends: [f64; 2]) -> Self {
        let (mean, sd) = mean_and_sd(values);
        let interval = Interval::of_bounded_mean(values.len() as f64, mean, sd, ends);
        Self { interval, ..Self::new(values) }
    }

    /// Returns p of the t test of a mean of 0; `None` without an interval.
    pub fn p(&self) -> Option<f64> {
        let (Interval { low, high }, df) = (self.interval?, self.people as f64 - 1.0);
        Some(t_two_sided(self.mean / ((high - low) / 2.0 / t_quantile(df)), df))
    }

    /// Returns the mean difference of the same people's values in two conditions, the first minus the second. Each pair
    /// is one person.
    pub fn of_differences(pairs: &[(f64, f64)]) -> Self {
        Self::new(&pairs.iter().map(|(first, second)| first - second).collect::<Vec<_>>())
    }
}
