//! The bootstrap over subjects: what another sample of people would have given. Ratings of one person belong together,
//! so people are drawn, not ratings.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::Serialize;

/// How to resample. Equal settings give equal intervals on every machine (ChaCha8).
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Bootstrap {
    /// Samples drawn.
    pub replicates: usize,
    /// Seed of the generator.
    pub seed: u64,
    /// Coverage of the intervals, such as 0.95.
    pub level: f64,
}

impl Default for Bootstrap {
    fn default() -> Self {
        Self { replicates: 2000, seed: 1, level: 0.95 }
    }
}

/// A bootstrap interval.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Interval {
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

impl Bootstrap {
    /// For every replicate, how often each subject was drawn; none without subjects.
    pub(super) fn weights(&self, subjects: usize) -> impl Iterator<Item = Vec<u32>> {
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        let replicates = if subjects == 0 { 0 } else { self.replicates };
        (0..replicates).map(move |_| {
            let mut weights = vec![0; subjects];
            for _ in 0..subjects {
                weights[rng.random_range(0..subjects as u64) as usize] += 1;
            }
            weights
        })
    }

    /// The percentile interval of what a statistic was in the replicates; none from a single subject, or where fewer
    /// than half of the replicates have a value.
    pub(super) fn interval(&self, subjects: usize, mut values: Vec<f64>) -> Option<Interval> {
        values.retain(|value| value.is_finite());
        if subjects < 2 || values.is_empty() || 2 * values.len() < self.replicates {
            return None;
        }
        values.sort_unstable_by(f64::total_cmp);
        let tail = (1.0 - self.level) / 2.0;
        Some(Interval { low: quantile(&values, tail), high: quantile(&values, 1.0 - tail) })
    }
}

/// The quantile of sorted values by linear interpolation (type 7 of Hyndman & Fan 1996, the default of R and NumPy).
fn quantile(sorted: &[f64], p: f64) -> f64 {
    let position = p * (sorted.len() - 1) as f64;
    let below = position.floor() as usize;
    let above = (below + 1).min(sorted.len() - 1);
    sorted[below] + (position - below as f64) * (sorted[above] - sorted[below])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `numpy.quantile`, 2.4.6.
    #[test]
    fn quantiles_are_those_of_numpy() {
        let values = [1.0, 2.0, 4.0, 8.0, 16.0];
        assert!((quantile(&values, 0.025) - 1.1).abs() < 1e-12);
        assert!((quantile(&values, 0.9) - 12.8).abs() < 1e-12);
    }

    #[test]
    fn draws_are_repeatable_and_as_many_as_subjects() {
        let bootstrap = Bootstrap { replicates: 50, seed: 3, level: 0.9 };
        let weights: Vec<Vec<u32>> = bootstrap.weights(7).collect();
        assert!(bootstrap.weights(7).eq(weights.iter().cloned()));
        assert!(!Bootstrap { seed: 4, ..bootstrap }.weights(7).eq(weights.iter().cloned()));
        assert!(weights.iter().all(|weights| weights.iter().sum::<u32>() == 7));
        // The order for a seed, once and for all.
        assert_eq!(weights[0], [2, 1, 1, 0, 2, 1, 0]);
    }
}
