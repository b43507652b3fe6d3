//! Every frame of a session and its content.

use std::time::Duration;

use crate::{
    display::frames::{FrameInterval, FrameTimes, Refresh},
    light::names::named,
};

named! {
    /// What the frames of a trial showed.
    Shown, ShownError {
        /// The uniform field before the stimulus.
        Recovery = "recovery",
        Stimulus = "stimulus",
        /// The uniform field after a stimulus of fixed duration, until it is rated.
        Response = "response",
        /// The uniform field after the last trial.
        Closing = "closing",
    }
}

/// Frames that followed each other and showed one thing.
#[derive(Clone, Debug, PartialEq)]
pub struct Stretch {
    /// Index into [`Schedule::trials`](super::Schedule::trials).
    pub trial: usize,
    /// 1, plus 1 for each correction of the rating.
    pub attempt: u32,
    /// What was on the screen.
    pub shown: Shown,
    /// The refresh interval that they were compared with, if known.
    pub refresh: Option<Refresh>,
    /// How long each of them was shown, microseconds.
    pub intervals_us: Vec<u32>,
}

/// The frames of a sitting. A frame belongs to what it showed, until the next frame begins.
#[derive(Clone, Debug, Default)]
pub(super) struct FrameLog {
    times: FrameTimes,
    /// What the present frame shows, in which trial and attempt.
    shown: Option<(Shown, usize, u32)>,
    /// Not returned yet.
    stretches: Vec<Stretch>,
}

impl FrameLog {
    /// Intervals of all frames so far.
    pub fn times(&self) -> &FrameTimes {
        &self.times
    }

    /// A frame begins that shows this; `None` for a page.
    pub fn begin(&mut self, now: Duration, refresh: Option<Refresh>, shown: Option<(Shown, usize, u32)>) {
        self.shown = shown;
        match shown {
            Some(_) => self.times.begin(now, refresh),
            None => self.times.interrupt(),
        }
    }

    /// The current frame lasted until now: records what it showed and for how long.
    pub fn end(&mut self, now: Duration) -> Option<(Shown, FrameInterval)> {
        let (shown, trial, attempt) = self.shown.take()?;
        let interval = self.times.end(now)?;
        let same = |last: &Stretch| {
            (last.trial, last.attempt, last.shown, last.refresh) == (trial, attempt, shown, interval.refresh)
        };
        match self.stretches.last_mut().filter(|last| same(last)) {
            Some(last) => last.intervals_us.push(interval.us),
            None => self.stretches.push(Stretch {
                trial,
                attempt,
                shown,
                refresh: interval.refresh,
                intervals_us: vec![interval.us],
            }),
        }
        Some((shown, interval))
    }

    /// The next frame follows no other.
    pub fn interrupt(&mut self) {
        self.shown = None;
        self.times.interrupt();
    }

    /// An onset was late.
    pub fn late_onset(&mut self) {
        self.times.late_onset();
    }

    /// The stretches since the last call.
    pub fn take(&mut self) -> Vec<Stretch> {
        std::mem::take(&mut self.stretches)
    }
}
