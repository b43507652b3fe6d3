//! Response times of any number of trials in a memory of their own: a histogram whose bins grow with the time.

use serde::Serialize;

/// Upper end of a bin over its lower end: quantiles are right to 2.5 %.
const GROWTH: f64 = 1.05;
/// Lower end of bin 0, seconds.
const SHORTEST_S: f64 = 0.01;
/// Bins; the last begins at some three hours.
pub(super) const BINS: u16 = 280;

/// The bin that a time falls into.
pub(super) fn bin(seconds: f64) -> u16 {
    let bin = (seconds / SHORTEST_S).ln() / GROWTH.ln();
    // Times below the first bin, 0 s among them, are in it.
    bin.clamp(0.0, f64::from(BINS - 1)) as u16
}

/// The time in the (geometric) middle of a bin.
fn middle(bin: u16) -> f64 {
    SHORTEST_S * GROWTH.powf(f64::from(bin) + 0.5)
}

/// How long some answers took.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Times {
    counts: Vec<u64>,
}

/// Quartiles of response times, seconds; each within 2.5 % of that of the times themselves.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Quartiles {
    /// Times.
    pub n: u64,
    /// A quarter are shorter.
    pub lower: f64,
    /// Half are shorter.
    pub median: f64,
    /// Three quarters are shorter.
    pub upper: f64,
}

impl Times {
    /// Adds a number of times of one bin.
    pub(super) fn add(&mut self, bin: u16, count: u64) {
        self.counts.resize(usize::from(BINS), 0);
        self.counts[usize::from(bin)] += count;
    }

    /// Times in the histogram.
    pub fn n(&self) -> u64 {
        self.counts.iter().sum()
    }

    /// The time that a proportion of them do not exceed, seconds; none of none.
    pub fn quantile(&self, proportion: f64) -> Option<f64> {
        let wanted = (proportion * self.n() as f64).ceil().max(1.0) as u64;
        let mut below = 0;
        (self.counts.iter().zip(0_u16..)).find_map(|(&count, bin)| {
            below += count;
            (count > 0 && below >= wanted).then(|| middle(bin))
        })
    }

    /// The quartiles; none of none.
    pub fn quartiles(&self) -> Option<Quartiles> {
        let [lower, median, upper] = [0.25, 0.5, 0.75].map(|proportion| self.quantile(proportion));
        Some(Quartiles { n: self.n(), lower: lower?, median: median?, upper: upper? })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_are_near_those_of_the_times() {
        // 1 ms … 10 s, evenly on a logarithmic scale, in a scrambled order.
        let seconds: Vec<f64> =
            (0..10_000).map(|i| 10_f64.powf(-1.0 + f64::from(i * 7919 % 10_000) / 5000.0)).collect();
        let mut times = Times::default();
        assert_eq!(times.quartiles(), None);
        for &time in &seconds {
            times.add(bin(time), 1);
        }
        let mut sorted = seconds;
        sorted.sort_by(f64::total_cmp);
        for proportion in [0.01, 0.25, 0.5, 0.75, 0.99] {
            let exact = sorted[(proportion * 10_000.0) as usize];
            let ratio = times.quantile(proportion).unwrap() / exact;
            assert!((ratio - 1.0).abs() < 0.026, "{proportion}: {ratio}");
        }
        assert_eq!(times.n(), 10_000);
    }

    #[test]
    fn every_time_has_a_bin() {
        for seconds in [0.0, 1e-9, 1e9, f64::MIN_POSITIVE] {
            assert!(bin(seconds) < BINS, "{seconds}");
        }
    }
}
