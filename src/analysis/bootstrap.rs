//! The bootstrap over participants: how results would vary between samples of people. Ratings by the same person are
//! related, so people are resampled instead of ratings.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::Serialize;

use crate::light::random::Z_95;

/// The settings for resampling. The same settings give the same intervals on every machine (ChaCha8).
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Bootstrap {
    /// Number of samples to draw.
    pub replicates: usize,
    /// Seed of the random number generator.
    pub seed: u64,
    /// Coverage of the intervals, such as 0.95.
    pub level: f64,
}

impl Default for Bootstrap {
    fn default() -> Self {
        Self { replicates: 2000, seed: 1, level: 0.95 }
    }
}

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
        let reach = Z_95 * se.filter(|se| se.is_finite() && estimate.is_finite())?;
        Some(Self { low: estimate - reach, high: estimate + reach })
    }
}

impl Bootstrap {
    /// Draws the samples of a number of participants; no samples if there are no participants.
    pub fn draw(self, subjects: usize) -> Resamples {
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        let replicates = if subjects == 0 { 0 } else { self.replicates };
        let mut draw = || {
            let mut weights = vec![0_u8; subjects];
            for _ in 0..subjects {
                let weight = &mut weights[rng.random_range(0..subjects as u64) as usize];
                *weight = weight.saturating_add(1);
            }
            weights
        };
        Resamples { settings: self, weights: (0..replicates).map(|_| draw()).collect() }
    }
}

/// The samples of a bootstrap. Every statistic of the same participants uses the same samples.
#[derive(Clone, Debug)]
pub struct Resamples {
    settings: Bootstrap,
    /// How often each participant was drawn, for each replicate. Bytes save memory if there are many participants, and
    /// nobody is drawn 256 times.
    pub(super) weights: Vec<Vec<u8>>,
}

impl Resamples {
    /// Returns the percentile interval of a statistic of `subjects` participants from its values in the replicates.
    /// Returns `None` if there is only one participant or if fewer than half of the replicates have a value.
    pub(super) fn interval(&self, subjects: usize, mut values: Vec<f64>) -> Option<Interval> {
        values.retain(|value| value.is_finite());
        if subjects < 2 || values.is_empty() || 2 * values.len() < self.settings.replicates {
            return None;
        }
        values.sort_unstable_by(f64::total_cmp);
        let tail = (1.0 - self.settings.level) / 2.0;
        Some(Interval { low: quantile(&values, tail), high: quantile(&values, 1.0 - tail) })
    }
}

/// Returns a quantile of sorted values by linear interpolation (type 7 of Hyndman & Fan 1996, the default in R and
/// NumPy).
fn quantile(sorted: &[f64], p: f64) -> f64 {
    let position = p * (sorted.len() - 1) as f64;
    let below = position.floor() as usize;
    let above = (below + 1).min(sorted.len() - 1);
    sorted[below] + (position - below as f64) * (sorted[above] - sorted[below])
}
