//! Frame intervals as the window measures them.

use std::time::Duration;

use crate::display::frames::{FrameTimes, Refresh};

/// Frame intervals of a page, without a screen to judge them against.
#[derive(Clone, Debug, Default)]
pub struct FrameStatistics(FrameTimes);

impl FrameStatistics {
    /// A frame begins at `now`, in seconds.
    pub fn frame(&mut self, now: f64) {
        self.0.frame(Duration::try_from_secs_f64(now).unwrap_or_default(), None);
    }

    /// Intervals counted.
    pub fn count(&self) -> u64 {
        self.0.intervals_us().len() as u64
    }

    /// The interval that a share `p` of them does not exceed, seconds.
    pub fn quantile(&self, p: f64) -> Option<f64> {
        self.0.quantile(p)
    }

    /// The screen's refresh, if the frames are held to one.
    pub fn refresh(&self) -> Option<Refresh> {
        let intervals = self.0.intervals_us();
        Refresh::estimate(intervals).filter(|refresh| refresh.is_followed_by(intervals))
    }
}

/// The frames of a sitting in one sentence, for the experimenter; `None` where nothing was counted.
pub fn sentence(times: &FrameTimes, refresh: Option<Refresh>) -> Option<String> {
    let ms = |seconds: f64| format!("{:.1} ms", seconds * 1e3);
    let (median, p99) = (ms(times.quantile(0.5)?), ms(times.quantile(0.99)?));
    let counted = times.intervals_us().len();
    let verdict = match (times.dropped(), refresh) {
        (Some(dropped), Some(refresh)) => {
            let late = times.late_onsets();
            format!(
                "{dropped} dropped at {:.2} Hz, {late} {} late",
                refresh.hz(),
                if late == 1 { "onset" } else { "onsets" }
            )
        }
        (Some(dropped), None) => format!("{dropped} dropped"),
        (None, _) => "none could be judged, because the screen's refresh rate is unknown".to_owned(),
    };
    Some(format!("{counted} frames, half of them within {median} and 99 % within {p99}: {verdict}."))
}

/// The frames of a sitting for its sidecar; `None` where nothing was counted. `source`: who knows the refresh: reported,
/// measured or unknown. `file`: the name of the file with every interval.
pub fn summary(
    times: &FrameTimes,
    refresh: Option<Refresh>,
    source: &str,
    file: Option<String>,
) -> Option<serde_json::Value> {
    let round = |seconds: f64| (seconds * 1e6).round() / 1e6;
    Some(serde_json::json!({
        "intervals": times.intervals_us().len(),
        "median_s": round(times.quantile(0.5)?),
        "p01_s": round(times.quantile(0.01)?),
        "p99_s": round(times.quantile(0.99)?),
        "refresh_s": refresh.map(|refresh| (refresh.seconds() * 1e9).round() / 1e9),
        "refresh_source": source,
        "dropped": times.dropped(),
        "missed_refreshes": times.missed_refreshes(),
        "late_onsets": times.dropped().map(|_| times.late_onsets()),
        "file": file,
    }))
}
