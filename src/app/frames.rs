//! Frame intervals, counted in constant memory however long a session is.

/// Width of a bin, seconds.
const BIN_S: f64 = 0.0001;
/// Bins; longer intervals fall into the last.
const BINS: usize = 5000;

/// A histogram of frame intervals.
#[derive(Clone, Debug)]
pub struct FrameStatistics {
    bins: Vec<u32>,
    count: u64,
    last: Option<f64>,
}

impl Default for FrameStatistics {
    fn default() -> Self {
        Self { bins: vec![0; BINS], count: 0, last: None }
    }
}

impl FrameStatistics {
    /// A frame begins at `now`, in seconds.
    pub fn frame(&mut self, now: f64) {
        if let Some(last) = self.last {
            let bin = ((now - last) / BIN_S).clamp(0.0, (BINS - 1) as f64) as usize;
            self.bins[bin] += 1;
            self.count += 1;
        }
        self.last = Some(now);
    }

    /// The next frame does not follow the last: a page was shown between.
    pub fn interrupt(&mut self) {
        self.last = None;
    }

    /// Intervals counted.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// The interval below which a share `p` of them lies, seconds, to a tenth of a millisecond.
    pub fn quantile(&self, p: f64) -> Option<f64> {
        let rank = (p * self.count as f64).ceil().max(1.0) as u64;
        let mut seen = 0;
        let bin = self.bins.iter().position(|n| {
            seen += u64::from(*n);
            seen >= rank
        })?;
        Some((bin as f64 + 0.5) * BIN_S)
    }

    /// For the sidecar; `None` where nothing was counted.
    pub fn summary(&self) -> Option<serde_json::Value> {
        Some(serde_json::json!({
            "intervals": self.count,
            "median_s": round(self.quantile(0.5)?),
            "p01_s": round(self.quantile(0.01)?),
            "p99_s": round(self.quantile(0.99)?),
        }))
    }
}

fn round(seconds: f64) -> f64 {
    (seconds * 1e5).round() / 1e5
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_of_a_steady_screen_with_one_stall() {
        let mut frames = FrameStatistics::default();
        assert_eq!(frames.quantile(0.5), None);
        let mut now = 0.0;
        for i in 0..1000 {
            frames.frame(now);
            now += if i == 500 { 0.1 } else { 1.0 / 60.0 };
        }
        assert_eq!(frames.count(), 999);
        assert!((frames.quantile(0.5).unwrap() - 1.0 / 60.0).abs() < BIN_S);
        assert!((frames.quantile(0.99).unwrap() - 1.0 / 60.0).abs() < BIN_S);
        assert!((frames.quantile(1.0).unwrap() - 0.1).abs() < BIN_S);
    }
}
