//! The refresh of the screen, and whether each frame kept up with it. This module has no clock: times are arguments.
//!
//! A frame is judged by the interval to the next one. Durations are rounded to whole refreshes, because an image can
//! change only at a refresh.

use std::time::Duration;

/// An interval above this many refreshes is a dropped frame.
pub const DROPPED_ABOVE: f64 = 1.5;
/// The minimum number of intervals for an estimate of the refresh.
pub const MIN_ESTIMATE_INTERVALS: usize = 30;
/// Longer intervals, in refreshes, are interruptions rather than dropped frames, and carry no information about the
/// refresh.
const MAX_INTERVAL_REFRESHES: f64 = 8.5;
/// The share of the intervals that must be one refresh long for an estimate.
const MIN_STEADY_SHARE: f64 = 0.7;
/// The maximum distance of an interval from a whole number of refreshes, in refreshes, at which it counts as
/// synchronized with the screen.
const HELD_WITHIN: f64 = 0.25;
/// The share of the intervals that may deviate more because of jitter when frames follow a refresh.
const HELD_JITTER: f64 = 0.1;
/// The share of the intervals that may deviate more and be longer than [`DROPPED_ABOVE`] refreshes.
const HELD_LONG: f64 = 0.01;
/// The longest refresh to which frames can be synchronized, in seconds: slower frames wait for something else.
const MAX_ESTIMATE_S: f64 = 0.1;
/// The longest refresh that is accepted, in seconds.
const MAX_REFRESH_S: f64 = 10.0;

/// The time from one refresh of a screen to the next.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub struct Refresh(f64);

/// A refresh, if it is known, and its source: `reported`, `measured` or `unknown`.
pub type KnownRefresh = (Option<Refresh>, &'static str);

impl Refresh {
    /// Makes a refresh from its interval in seconds; `None` unless the interval is above 0 and at most 10.
    pub fn new(seconds: f64) -> Option<Self> {
        (seconds > 0.0 && seconds <= MAX_REFRESH_S).then_some(Self(seconds))
    }

    /// Makes a refresh from its rate in Hz; `None` unless the rate is finite and at least 0.1.
    pub fn from_hz(hz: f64) -> Option<Self> {
        Self::new(1.0 / hz)
    }

    /// Returns the refresh to judge frames against, and where it is from: the one that the system reports, otherwise the
    /// one that frames with these durations follow; otherwise it is unknown.
    pub fn known(reported_hz: Option<f64>, intervals_us: &[u32]) -> KnownRefresh {
        let named = |source| move |refresh| (Some(refresh), source);
        let reported = reported_hz.and_then(Self::from_hz).map(named("reported"));
        let measured = || Self::estimate(intervals_us).filter(|refresh| refresh.is_followed_by(intervals_us));
        reported.or_else(|| measured().map(named("measured"))).unwrap_or((None, "unknown"))
    }

    /// Estimates the refresh of the screen from the intervals of its frames: their total time divided by the number of
    /// refreshes in it. Single late or dropped frames do not change the result, which is not rounded to a common rate.
    /// Returns `None` if there are fewer than [`MIN_ESTIMATE_INTERVALS`] intervals, if too few of them are one refresh
    /// long, or if the rate is below 10 Hz, because the frames are then not synchronized with the screen. If the frames
    /// are not synchronized but all take equally long, the result is that time, because only the window system could
    /// provide a better value.
    pub fn estimate(intervals_us: &[u32]) -> Option<Self> {
        if intervals_us.len() < MIN_ESTIMATE_INTERVALS {
            return None;
        }
        let mut refresh = f64::from(quantile(intervals_us, 0.5)?) * 1e-6;
        let mut ones = 0;
        // The median is only a rough start; each round counts the refreshes again. A few rounds are enough.
        for _ in 0..4 {
            let (mut time, mut refreshes) = (0.0, 0.0);
            ones = 0;
            for interval in intervals_us {
                let interval = f64::from(*interval) * 1e-6;
                let ratio = interval / refresh;
                if ratio < MAX_INTERVAL_REFRESHES {
                    // A late frame and the early frame after it count as 2 + 0 or 1 + 1 refreshes; the sum is right
                    // either way.
                    (time, refreshes) = (time + interval, refreshes + ratio.round());
                    ones += usize::from(ratio.round() == 1.0);
                }
            }
            refresh = time / refreshes;
        }
        let steady = ones as f64 >= MIN_STEADY_SHARE * intervals_us.len() as f64;
        Self::new(refresh).filter(|_| steady && refresh <= MAX_ESTIMATE_S)
    }

    /// True if frames shown for these times follow this refresh: nearly all of them were shown for close to a whole
    /// number of refreshes, and at most 1 % were longer than [`DROPPED_ABOVE`] refreshes without being close to a whole
    /// number, which dropped frames always are. Frames that last as long as their work takes fall in between; calling
    /// some of them dropped would be meaningless.
    pub fn is_followed_by(self, intervals_us: &[u32]) -> bool {
        let refreshes = intervals_us.iter().map(|us| f64::from(*us) * 1e-6 / self.0);
        let off = refreshes.filter(|taken| (taken - taken.round().max(1.0)).abs() > HELD_WITHIN);
        let (short, long): (Vec<f64>, Vec<f64>) = off.partition(|taken| *taken <= DROPPED_ABOVE);
        let share = |count: usize| count as f64 / intervals_us.len().max(1) as f64;
        share(long.len()) <= HELD_LONG && share(short.len() + long.len()) <= HELD_JITTER
    }

    pub fn seconds(self) -> f64 {
        self.0
    }

    /// Refreshes per second.
    pub fn hz(self) -> f64 {
        1.0 / self.0
    }

    /// True if a frame shown for `interval` means that a frame was dropped: `interval` is longer than [`DROPPED_ABOVE`]
    /// refreshes.
    pub fn is_dropped(self, interval: Duration) -> bool {
        interval.as_secs_f64() > DROPPED_ABOVE * self.0
    }

    /// Returns the number of refreshes within `interval` that showed no new frame: its number of refreshes minus one.
    pub fn missed(self, interval: Duration) -> u64 {
        ((interval.as_secs_f64() / self.0).round() as u64).saturating_sub(1)
    }

    /// Returns a duration as the nearest whole number of refreshes: at least 1, except that a duration of 0 gives 0.
    pub fn count(self, duration: Duration) -> u64 {
        let count = (duration.as_secs_f64() / self.0).round() as u64;
        count.max(u64::from(!duration.is_zero()))
    }

    /// True if a frame that begins `elapsed` after the start of something that should last `duration` should end it.
    /// That is the first frame that begins at most half a refresh before the planned refresh, so that jitter never adds
    /// or drops a frame.
    pub fn is_due(self, elapsed: Duration, duration: Duration) -> bool {
        elapsed.as_secs_f64() >= (self.count(duration) as f64 - 0.5) * self.0
    }

    /// True if such a frame begins more than half a refresh after the planned refresh.
    pub fn is_late(self, elapsed: Duration, duration: Duration) -> bool {
        elapsed.as_secs_f64() > (self.count(duration) as f64 + 0.5) * self.0
    }
}

/// One frame's interval to the next frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FrameInterval {
    /// The interval in microseconds. The times of the frames are rounded, not their differences, so the sum of the
    /// intervals is the total time to within a microsecond.
    pub us: u32,
    /// The refresh that the frame was judged against, if known.
    pub refresh: Option<Refresh>,
    /// True if a frame was dropped.
    pub dropped: bool,
}

/// All frame intervals of a run, and the counts derived from them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FrameTimes {
    last: Option<(Duration, Option<Refresh>)>,
    intervals_us: Vec<u32>,
    judged: u64,
    dropped: u64,
    missed: u64,
    late_onsets: u32,
}

impl FrameTimes {
    /// Records that a frame begins at `now` on a screen with this refresh, if known. Returns the interval of the
    /// previous frame.
    pub fn frame(&mut self, now: Duration, refresh: Option<Refresh>) -> Option<FrameInterval> {
        let before = self.end(now);
        self.begin(now, refresh);
        before
    }

    /// Records the beginning of a frame that does not follow another frame.
    pub fn begin(&mut self, now: Duration, refresh: Option<Refresh>) {
        self.last = Some((now, refresh));
    }

    /// Records that the frame that began last was shown until `now`. It is judged against the refresh it began with:
    /// after a change of screens, judging starts again with the first frame. Returns `None` if no frame has begun.
    pub fn end(&mut self, now: Duration) -> Option<FrameInterval> {
        let (last, refresh) = self.last.take()?;
        let interval = now.saturating_sub(last);
        let us = u32::try_from(micros(now).saturating_sub(micros(last))).unwrap_or(u32::MAX);
        self.intervals_us.push(us);
        let dropped = refresh.is_some_and(|refresh| refresh.is_dropped(interval));
        if let Some(refresh) = refresh {
            self.judged += 1;
            self.dropped += u64::from(dropped);
            self.missed += refresh.missed(interval);
        }
        Some(FrameInterval { us, refresh, dropped })
    }

    /// Records that the next frame does not follow the last one because a page that requests no frames was shown in
    /// between.
    pub fn interrupt(&mut self) {
        self.last = None;
    }

    /// Counts an onset that came later than its planned refresh.
    pub fn late_onset(&mut self) {
        self.late_onsets += 1;
    }

    /// All intervals in microseconds, in order.
    pub fn intervals_us(&self) -> &[u32] {
        &self.intervals_us
    }

    /// Dropped frames: intervals above [`DROPPED_ABOVE`] refreshes. `None` if no refresh was known.
    pub fn dropped(&self) -> Option<u64> {
        (self.judged > 0).then_some(self.dropped)
    }

    /// The number of refreshes without a new frame, Σ (round(interval / refresh) − 1): an interval of three refreshes
    /// counts as two. `None` if no refresh was known.
    pub fn missed_refreshes(&self) -> Option<u64> {
        (self.judged > 0).then_some(self.missed)
    }

    /// The number of onsets that came later than their planned refresh.
    pub fn late_onsets(&self) -> u32 {
        self.late_onsets
    }

    /// Returns the exact `p` quantile of the intervals, in seconds: a share `p`, 0…1, of them does not exceed it.
    /// `None` if there are no intervals.
    pub fn quantile(&self, p: f64) -> Option<f64> {
        quantile(&self.intervals_us, p).map(|us| f64::from(us) * 1e-6)
    }
}

/// Returns the smallest of the values that at least a share `p` of the values do not exceed.
fn quantile(values: &[u32], p: f64) -> Option<u32> {
    let rank = (p * values.len() as f64).ceil().max(1.0) as usize;
    let index = rank.min(values.len()).checked_sub(1)?;
    let mut values = values.to_vec();
    Some(*values.select_nth_unstable(index).1)
}

/// Rounds a time to the nearest microsecond.
fn micros(time: Duration) -> u64 {
    u64::try_from((time.as_nanos() + 500) / 1000).unwrap_or(u64::MAX)
}
