//! Keys and clicks, timestamped when the window system delivers them rather than in the frame that responds to them.
//!
//! The event loop records timestamps ([`Stamps::press`]), and the session looks up the timestamp of a key that egui
//! reports ([`Input::key`]). Without our own event loop, as in tests, there are no timestamps, and the session uses the
//! time of the frame.

use std::{
    sync::{Arc, Mutex, PoisonError},
    time::{Duration, Instant},
};

use eframe::egui::Key;

/// A key or a mouse button.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pressed {
    /// A key, by its position on the keyboard.
    Key(Key),
    /// A mouse button; the time is that of its release, which completes the click.
    Click,
}

#[derive(Clone, Copy, Debug)]
struct Press {
    what: Pressed,
    /// When the event was delivered.
    at: Instant,
    /// Time since the program had last read events.
    unseen: Duration,
}

/// Presses since the last frame. The event loop adds them, and the window takes them.
#[derive(Clone, Debug, Default)]
pub struct Stamps(Arc<Mutex<Vec<Press>>>);

impl Stamps {
    /// Records a press; events were last read `unseen` earlier.
    pub fn press(&self, what: Pressed, at: Instant, unseen: Duration) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).push(Press { what, at, unseen });
    }

    fn take(&self) -> Vec<Press> {
        std::mem::take(&mut *self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

/// When a key or button was pressed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PressTime {
    /// Time of the press in the window's time, seconds.
    pub at_s: f64,
    /// The maximum time that the event may have waited before it was delivered, if known.
    pub uncertainty: Option<Duration>,
}

/// The presses of a frame, with their timestamps.
#[derive(Debug, Default)]
pub struct Input {
    /// Timestamps from the event loop; none without our own event loop.
    stamps: Stamps,
    /// The clock's time when the window's time was 0.
    zero: Option<Instant>,
    fresh: Vec<Press>,
}

impl Input {
    /// Creates input with the timestamps of an event loop.
    pub fn stamped(stamps: Stamps) -> Self {
        Self { stamps, ..Self::default() }
    }

    /// Begins a frame. `now` is the window's time in seconds, taken a moment before `clock`.
    pub fn frame(&mut self, now: f64, clock: Instant) {
        // `clock` is never taken before `now`, so the earliest zero is the most accurate.
        if let Some(zero) = Duration::try_from_secs_f64(now).ok().and_then(|now| clock.checked_sub(now)) {
            self.zero = Some(self.zero.map_or(zero, |before| before.min(zero)));
        }
        self.fresh = self.stamps.take();
    }

    /// Returns the timestamp of a key that was pressed before this frame, by position. Each is returned once, in order.
    pub fn key(&mut self, place: Key) -> Option<PressTime> {
        self.find(Pressed::Key(place))
    }

    /// Returns the timestamp of the last click before this frame.
    pub fn click(&mut self) -> Option<PressTime> {
        let mut last = None;
        while let Some(pressed_at) = self.find(Pressed::Click) {
            last = Some(pressed_at);
        }
        last
    }

    fn find(&mut self, what: Pressed) -> Option<PressTime> {
        let zero = self.zero?;
        let index = self.fresh.iter().position(|press| press.what == what)?;
        let Press { at, unseen, .. } = self.fresh.remove(index);
        Some(PressTime { at_s: at.saturating_duration_since(zero).as_secs_f64(), uncertainty: Some(unseen) })
    }
}
