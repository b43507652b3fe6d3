//! The interval of a proportion.

use statrs::function::beta::beta_reg;

use crate::analysis::bootstrap::Interval;

/// The exact interval of Clopper & Pearson (1934), Biometrika 26, 404, for `found` out of `all`: it covers the true
/// proportion with probability `level` or more.
pub fn clopper_pearson(found: usize, all: usize, level: f64) -> Interval {
    let tail = (1.0 - level) / 2.0;
    let (k, n) = (found as f64, all as f64);
    // P(X ≥ k) rises with the proportion and P(X ≤ k) falls: both are incomplete beta functions.
    let low = if found == 0 { 0.0 } else { crossing(|p| beta_reg(k, n - k + 1.0, p) - tail) };
    let high = if found >= all { 1.0 } else { crossing(|p| beta_reg(k + 1.0, n - k, p) - (1.0 - tail)) };
    Interval { low, high }
}

/// Where a function that rises on 0…1 is 0, by halving.
fn crossing(rising: impl Fn(f64) -> f64) -> f64 {
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..60 {
        let middle = (low + high) / 2.0;
        *if rising(middle) < 0.0 { &mut low } else { &mut high } = middle;
    }
    (low + high) / 2.0
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `binom.test(found, all)$conf.int`, R 4.2.2.
    #[test]
    fn the_interval_is_that_of_r() {
        for (found, all, low, high) in [
            (0, 200, 0.0, 0.0182753403551),
            (10, 200, 0.0242341654721, 0.0900275377014),
            (166, 200, 0.770628399606, 0.879304376764),
            (200, 200, 0.981724659645, 1.0),
            (1, 1, 0.025, 1.0),
            (50, 1000, 0.0373353976047, 0.0653904879155),
        ] {
            let interval = clopper_pearson(found, all, 0.95);
            assert!((interval.low - low).abs() < 1e-11, "{found}/{all}: {interval:?}");
            assert!((interval.high - high).abs() < 1e-11, "{found}/{all}: {interval:?}");
        }
    }
}
