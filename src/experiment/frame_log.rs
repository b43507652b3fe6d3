//! Records every frame of a session and what it showed.

use std::time::Duration;

use crate::{
    display::frames::{FrameInterval, FrameTimes, Refresh},
    text::names::named,
};

named! {
    /// What a frame of a trial showed.
    Shown, ShownError {
        /// The uniform field before the stimulus.
        Recovery = "recovery",
        Stimulus = "stimulus",
        /// The uniform field between two intervals.
        Gap = "gap",
        /// The uniform field after a stimulus of fixed duration, until it is rated.
        Response = "response",
        /// The uniform field after the last trial.
        Closing = "closing",
    }
}

/// Consecutive frames that showed the same thing.
#[derive(Clone, Debug, PartialEq)]
pub struct FrameRun {
    /// Index into [`Schedule::trials`](super::Schedule::trials).
    pub trial: usize,
    /// 1, plus 1 for each correction of the rating.
    pub attempt: u32,
    /// What was on the screen.
    pub shown: Shown,
    /// The refresh interval against which the frames were judged, if known.
    pub refresh: Option<Refresh>,
    /// How long each frame was shown, microseconds.
    pub intervals_us: Vec<u32>,
}

/// The frames of a sitting. The time until the next frame begins counts for what the current frame shows.
#[derive(Clone, Debug, Default)]
pub(super) struct FrameLog {
    /// The intervals of all frames so far.
    pub times: FrameTimes,
    /// What the current frame shows, with its trial and attempt.
    shown: Option<(Shown, usize, u32)>,
    /// The runs that were not yet taken.
    pub runs: Vec<FrameRun>,
}

impl FrameLog {
    /// Begins a frame that shows `shown`, or a page if it is `None`.
    pub fn begin(&mut self, now: Duration, refresh: Option<Refresh>, shown: Option<(Shown, usize, u32)>) {
        self.shown = shown;
        match shown {
            Some(_) => self.times.begin(now, refresh),
            None => self.times.interrupt(),
        }
    }

    /// Ends the current frame, recording what it showed and for how long.
    pub fn end(&mut self, now: Duration) -> Option<(Shown, FrameInterval)> {
        let (shown, trial, attempt) = self.shown.take()?;
        let interval = self.times.end(now)?;
        let same = |last: &FrameRun| {
            (last.trial, last.attempt, last.shown, last.refresh) == (trial, attempt, shown, interval.refresh)
        };
        match self.runs.last_mut().filter(|last| same(last)) {
            Some(last) => last.intervals_us.push(interval.us),
            None => self.runs.push(FrameRun {
                trial,
                attempt,
                shown,
                refresh: interval.refresh,
                intervals_us: vec![interval.us],
            }),
        }
        Some((shown, interval))
    }

    /// Notes that the next frame does not directly follow the last one.
    pub fn interrupt(&mut self) {
        self.shown = None;
        self.times.interrupt();
    }
}
