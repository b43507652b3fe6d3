//! The result of a frame measurement.

use std::{fmt::Write as _, time::Duration};

use crate::{
    app::ui::Monitor,
    display::frames::{FrameTimes, MIN_ESTIMATE_INTERVALS, Refresh},
};

/// Frame intervals and the refresh against which they are judged.
#[derive(Clone, Debug, PartialEq)]
pub struct TimingReport {
    /// The intervals, judged against the refresh if it is known.
    times: FrameTimes,
    /// The refresh of the screen, if known.
    pub refresh: Option<Refresh>,
    /// The source of the refresh: `reported`, `measured` or `unknown`.
    pub source: &'static str,
}

impl TimingReport {
    /// Judges intervals in microseconds. The refresh is the one that the monitor reports, or otherwise the one that the
    /// frames follow. If the intervals scatter, the refresh is unknown, and no frame is judged.
    pub fn new(intervals_us: &[u32], monitor: &Monitor) -> Self {
        let (refresh, source) = Refresh::known(monitor.refresh_hz, intervals_us);
        let mut times = FrameTimes::default();
        let mut now = Duration::ZERO;
        times.frame(now, refresh);
        for interval in intervals_us {
            now += Duration::from_micros(u64::from(*interval));
            times.frame(now, refresh);
        }
        Self { times, refresh, source }
    }

    /// Returns how long each frame was shown, in microseconds.
    pub fn intervals_us(&self) -> &[u32] {
        self.times.intervals_us()
    }

    /// Returns the findings as rows of a name and a value.
    pub fn rows(&self) -> Vec<(&'static str, String)> {
        let ms = |p: f64| self.times.quantile(p).map_or_else(String::new, |s| format!("{:.3} ms", s * 1e3));
        let count = |number: Option<u64>| number.map_or_else(|| "unknown".to_owned(), |number| number.to_string());
        vec![
            ("intervals", self.intervals_us().len().to_string()),
            (
                "refresh",
                self.refresh.map_or_else(
                    || "unknown".to_owned(),
                    |refresh| format!("{:.3} Hz, {:.3} ms, {}", refresh.hz(), refresh.seconds() * 1e3, self.source),
                ),
            ),
            ("shortest", ms(0.0)),
            ("1 %", ms(0.01)),
            ("median", ms(0.5)),
            ("99 %", ms(0.99)),
            ("longest", ms(1.0)),
            ("dropped frames", count(self.times.dropped())),
            ("missed refreshes", count(self.times.missed_refreshes())),
        ]
    }

    /// Returns whether there is one frame per refresh; `None` if there are too few frames to judge.
    pub fn is_one_by_one(&self) -> Option<bool> {
        let enough = self.intervals_us().len() >= MIN_ESTIMATE_INTERVALS;
        let followed = self.refresh.is_some_and(|refresh| refresh.is_followed_by(self.intervals_us()));
        enough.then_some(followed && self.times.dropped() == Some(0))
    }

    /// Returns the result in one or two sentences.
    pub fn verdict(&self) -> String {
        let count = self.intervals_us().len();
        if count < MIN_ESTIMATE_INTERVALS {
            return format!("{count} frames are too few to judge; expected {MIN_ESTIMATE_INTERVALS} or more.");
        }
        let Some(refresh) = self.refresh.filter(|refresh| refresh.is_followed_by(self.intervals_us())) else {
            return self.scatter();
        };
        let (hz, dropped) = (refresh.hz(), self.times.dropped().unwrap_or_default());
        let percent = 100.0 * dropped as f64 / count as f64;
        if dropped == 0 {
            format!("Every refresh at {hz:.2} Hz showed a new frame: none of {count} was dropped.")
        } else {
            format!(
                "The frames follow the refresh rate of {hz:.2} Hz; dropped frames: {dropped} of {count} ({percent:.1} %). Close other programs."
            )
        }
    }

    /// Says that the frames do not follow a steady refresh, and describes their intervals.
    fn scatter(&self) -> String {
        let ms = |p: f64| self.times.quantile(p).unwrap_or_default() * 1e3;
        let judged = match self.refresh {
            Some(refresh) => format!("not even the {:.2} Hz that the system reports", refresh.hz()),
            None => "so no frame can be judged as dropped".to_owned(),
        };
        format!(
            "The frames do not follow a steady refresh, {judged}: 98 % of their intervals are between {:.1} and {:.1} \
                ms. Close other programs and measure in full screen.",
            ms(0.01),
            ms(0.99)
        )
    }

    /// Returns every interval as CSV: `frame` counts from 1; `dropped` is 0 or 1, or empty if unknown.
    pub fn csv(&self) -> String {
        let mut text = "frame,interval_us,dropped\n".to_owned();
        for (frame, us) in (1..).zip(self.intervals_us()) {
            let dropped = self.refresh.map(|refresh| refresh.is_dropped(Duration::from_micros(u64::from(*us))));
            let dropped = dropped.map_or("", |dropped| if dropped { "1" } else { "0" });
            // Writing to memory does not fail.
            let _ = writeln!(text, "{frame},{us},{dropped}");
        }
        text
    }
}
