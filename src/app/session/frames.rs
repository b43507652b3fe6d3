//! The refresh of the screen, and whether the frames of a sitting kept up with it.

use crate::{
    app::ui::Monitor,
    display::frames::{FrameTimes, KnownRefresh, Refresh},
    experiment::FrameCount,
    report::document::numbers::count,
    store::sidecar::FrameSummary,
};

/// The refresh of the screen, updated if the window moves to another screen.
pub struct ScreenRefresh {
    /// The preflight's finding, and the name and rate of the monitor at that time, which identify it.
    first: (Option<String>, Option<f64>, KnownRefresh),
    now: KnownRefresh,
}

impl ScreenRefresh {
    /// Starts with the preflight's finding about the monitor.
    pub fn new(monitor: &Monitor, found: KnownRefresh) -> Self {
        Self { first: (monitor.name.clone(), monitor.refresh_hz, found), now: found }
    }

    /// Updates the refresh for the monitor that shows the window; returns a note if it has changed.
    pub fn update(&mut self, monitor: &Monitor) -> Option<String> {
        let before = self.now.0;
        let (name, hz, found) = &self.first;
        let same = (name, *hz) == (&monitor.name, monitor.refresh_hz);
        self.now = if same { *found } else { Refresh::known(monitor.refresh_hz, &[]) };
        let (refresh, source) = self.now;
        (refresh != before).then(|| {
            let hz = refresh.map(|refresh| format!("{:.3} Hz, ", refresh.hz())).unwrap_or_default();
            format!("the screen's refresh rate changed: {} {hz}{source}", monitor.title())
        })
    }

    /// Returns how the session counts frames.
    pub fn frames(&self) -> FrameCount {
        self.now.0.map_or(FrameCount::Frames, |refresh| FrameCount::Against(refresh.seconds()))
    }

    /// Returns the frames of a sitting in one sentence, for the experimenter; `None` if none were counted.
    pub fn sentence(&self, times: &FrameTimes) -> Option<String> {
        let ms = |seconds: f64| format!("{:.1} ms", seconds * 1e3);
        let (median, p99) = (ms(times.quantile(0.5)?), ms(times.quantile(0.99)?));
        let counted = count(times.intervals_us().len() as u64, "frame");
        let verdict = match (times.dropped(), self.now.0) {
            (Some(dropped), Some(refresh)) => {
                let late = times.late_onsets();
                let onsets = if late == 1 { "onset" } else { "onsets" };
                format!("{dropped} dropped at {:.2} Hz, {late} {onsets} late", refresh.hz())
            }
            (Some(dropped), None) => format!("{dropped} dropped"),
            (None, _) => "none could be judged, because the screen's refresh rate is unknown".to_owned(),
        };
        Some(format!("{counted}, half of them within {median} and 99 % within {p99}: {verdict}."))
    }

    /// Returns the summary of a sitting's frames for the sidecar; `None` if none were counted. `file` is the name of
    /// the file with every interval.
    pub fn summary(&self, times: &FrameTimes, file: Option<String>) -> Option<FrameSummary> {
        let round = |seconds: f64| (seconds * 1e6).round() / 1e6;
        let (refresh, source) = self.now;
        Some(FrameSummary {
            intervals: times.intervals_us().len(),
            median_s: round(times.quantile(0.5)?),
            p01_s: round(times.quantile(0.01)?),
            p99_s: round(times.quantile(0.99)?),
            refresh_s: refresh.map(|refresh| (refresh.seconds() * 1e9).round() / 1e9),
            refresh_source: source.to_owned(),
            dropped: times.dropped(),
            missed_refreshes: times.missed_refreshes(),
            late_onsets: times.dropped().map(|_| times.late_onsets()),
            file,
        })
    }
}
