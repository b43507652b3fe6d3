//! Frames under a clock that the test turns: every count is known beforehand.

use std::time::Duration;

use machband::display::frames::{FrameTimes, Refresh};
use proptest::prelude::*;

/// A screen that refreshes at exact times, and a program that misses some refreshes.
struct Screen {
    now_s: f64,
    refresh: Refresh,
    times: FrameTimes,
    frames: u64,
}

impl Screen {
    fn new(hz: f64) -> Self {
        let refresh = Refresh::from_hz(hz).unwrap();
        Self { now_s: 0.123_456_7, refresh, times: FrameTimes::default(), frames: 0 }
    }

    /// The next frame, `refreshes` after the last, seen `early` refreshes too early.
    fn frame(&mut self, refreshes: u32, early: f64) {
        self.now_s += f64::from(refreshes) * self.refresh.seconds();
        let seen = Duration::from_secs_f64(self.now_s - early * self.refresh.seconds());
        self.times.frame(seen, Some(self.refresh));
        self.frames += 1;
    }

    fn counted(&self) -> (usize, u64, u64) {
        (self.times.intervals_us().len(), self.times.dropped().unwrap(), self.times.missed_refreshes().unwrap())
    }
}

/// Numbers in −1…1 that look random and are the same everywhere.
fn noise(seed: u64) -> impl Iterator<Item = f64> {
    (1..).map(move |i: u64| {
        let mixed = (i + seed).wrapping_mul(0x9e37_79b9_7f4a_7c15).rotate_left(31).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        (mixed >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    })
}

#[test]
fn a_steady_screen_drops_nothing_however_long() {
    for hz in [59.94, 60.0, 75.0, 119.88, 120.0, 144.0, 240.0] {
        let mut screen = Screen::new(hz);
        // An hour and a half at 60 Hz.
        for _ in 0..324_001 {
            screen.frame(1, 0.0);
        }
        assert_eq!(screen.counted(), (324_000, 0, 0), "{hz}");
        let sum: u64 = screen.times.intervals_us().iter().map(|us| u64::from(*us)).sum();
        let truth = 324_000.0 * 1e6 / hz;
        assert!((sum as f64 - truth).abs() <= 1.0, "{hz}: rounding adds up to {} µs", sum as f64 - truth);
        for p in [0.01, 0.5, 0.99] {
            assert!((screen.times.quantile(p).unwrap() - 1.0 / hz).abs() <= 1e-6, "{hz}");
        }
        let estimate = Refresh::estimate(screen.times.intervals_us()).unwrap();
        assert!((estimate.hz() - hz).abs() < 1e-6 * hz, "{hz}: {}", estimate.hz());
    }
}

#[test]
fn jitter_of_a_fifth_drops_nothing_and_a_drop_among_it_is_one() {
    for hz in [59.94, 60.0, 120.0] {
        let mut screen = Screen::new(hz);
        for (i, jitter) in noise(7).take(100_001).enumerate() {
            screen.frame(if i % 1000 == 500 { 2 } else { 1 }, 0.2 * jitter);
        }
        assert_eq!(screen.counted(), (100_000, 100, 100), "{hz}");
    }
}

#[test]
fn stalls_are_dropped_frames_once_and_missed_refreshes_as_often_as_they_last() {
    let mut screen = Screen::new(60.0);
    let stalls = [(100, 2), (200, 3), (201, 3), (500, 61), (999, 10)];
    for i in 0..1001 {
        screen.frame(stalls.iter().find(|(at, _)| *at == i).map_or(1, |(_, refreshes)| *refreshes), 0.0);
    }
    assert_eq!(screen.counted(), (1000, 5, 1 + 2 + 2 + 60 + 9));
    assert_eq!(screen.times.quantile(1.0), Some(1.016_667));

    // A page without frames between is no stall, and no interval at all.
    let before = screen.counted();
    screen.times.interrupt();
    screen.frame(600, 0.0);
    assert_eq!(screen.counted(), before);
    screen.frame(1, 0.0);
    assert_eq!(screen.counted(), (1001, before.1, before.2));
}

#[test]
fn a_screen_that_changes_is_judged_anew_from_its_first_frame_on() {
    for (first, second) in [(60.0, 120.0), (120.0, 60.0), (60.0, 59.94), (144.0, 24.0)] {
        let mut screen = Screen::new(first);
        for _ in 0..500 {
            screen.frame(1, 0.0);
        }
        // The frame that comes a refresh of the old screen after the last, and is shown by the new one.
        screen.now_s += screen.refresh.seconds();
        screen.refresh = Refresh::from_hz(second).unwrap();
        screen.frame(0, 0.0);
        for i in 0..500 {
            screen.frame(if i == 250 { 2 } else { 1 }, 0.0);
        }
        assert_eq!(screen.counted(), (1000, 1, 1), "{first} → {second}");
    }
}

#[test]
fn what_is_judged_against_no_refresh_is_measured_and_not_judged() {
    let mut times = FrameTimes::default();
    assert_eq!((times.quantile(0.5), times.dropped()), (None, None));
    for i in 0..100 {
        times.frame(Duration::from_millis(16 * i), None);
    }
    assert_eq!((times.intervals_us().len(), times.quantile(0.5)), (99, Some(0.016)));
    assert_eq!((times.dropped(), times.missed_refreshes()), (None, None));
    for seconds in [0.0, -0.016, f64::NAN, f64::INFINITY, 11.0] {
        assert!(Refresh::new(seconds).is_err(), "{seconds}");
    }
}

/// Against a sorted list.
#[test]
fn quantiles_are_exact() {
    let mut times = FrameTimes::default();
    let mut now = Duration::ZERO;
    times.frame(now, None);
    let mut sorted: Vec<u32> = noise(3).take(1037).map(|x| (16_000.0 + 5_000.0 * x) as u32).collect();
    for us in &sorted {
        now += Duration::from_micros(u64::from(*us));
        times.frame(now, None);
    }
    sorted.sort_unstable();
    for (p, rank) in [(0.0, 1), (0.01, 11), (0.5, 519), (0.99, 1027), (1.0, 1037)] {
        assert_eq!(times.quantile(p), Some(f64::from(sorted[rank - 1]) * 1e-6), "{p}");
    }
}

proptest! {
    /// The refresh comes out of jitter and drops as it is, nowhere moved to what is usual. Jitter of the first and the
    /// last frame is all that remains of it.
    #[test]
    fn the_refresh_is_estimated_from_frames_that_jitter_and_drop(
        hz in 24.0..250.0_f64, jitter in 0.0..0.2_f64, drops in 0.0..0.15_f64, frames in 200..2000_usize, seed: u32,
    ) {
        let mut screen = Screen::new(hz);
        let chance: Vec<f64> = noise(u64::from(seed) + 99).take(frames).collect();
        for (early, chance) in noise(u64::from(seed)).take(frames).zip(chance) {
            // Uniform in −1…1, so that a share `drops` lies below.
            screen.frame(if chance < 2.0 * drops - 1.0 { 2 } else { 1 }, jitter * early);
        }
        let estimate = Refresh::estimate(screen.times.intervals_us()).expect("steady enough");
        let bound = (2.0 * jitter + 0.001) / (frames - 1) as f64;
        prop_assert!((estimate.hz() / hz - 1.0).abs() < bound + 1e-4 / frames as f64 * hz, "{} {hz}", estimate.hz());
    }

    /// Held to whole refreshes: one frame and only one is the first that is due, and it is the Nth whatever the jitter.
    #[test]
    fn jitter_adds_and_drops_no_frame_of_a_duration(
        hz in 24.0..250.0_f64, duration_s in 0.0..5.0_f64, jitter in 0.0..0.24_f64, seed: u32,
    ) {
        let refresh = Refresh::from_hz(hz).unwrap();
        let duration = Duration::from_secs_f64(duration_s);
        let planned = refresh.count(duration);
        let mut noise = noise(u64::from(seed)).map(|x| jitter * x);
        let start = noise.next().unwrap();
        let elapsed = |n: u64, early: f64| Duration::from_secs_f64(((n as f64 - early + start) * refresh.seconds()).max(0.0));
        let found = (1..).zip(&mut noise).map(|(n, early)| (n, elapsed(n, early))).find(|(_, t)| refresh.is_due(*t, duration));
        let (n, at) = found.unwrap();
        prop_assert_eq!(n, planned.max(1));
        prop_assert!(planned == 0 || !refresh.is_late(at, duration));
        prop_assert!(refresh.is_late(elapsed(planned + 1, 0.0), duration));
        prop_assert!((n as f64 / hz - duration_s).abs() <= 1.0 / hz);
    }
}

#[test]
fn a_refresh_is_not_made_up() {
    let run = |interval: &dyn Fn(usize) -> f64, n: usize| {
        let mut times = FrameTimes::default();
        let mut now_s = 0.0;
        for i in 0..=n {
            times.frame(Duration::from_secs_f64(now_s), None);
            now_s += interval(i.min(n - 1));
        }
        Refresh::estimate(times.intervals_us())
    };
    assert!(run(&|_| 1.0 / 60.0, 29).is_none(), "too few");
    // Frames that no screen holds: as long as the work takes.
    let work: Vec<f64> = noise(5).take(500).map(|x| (2.0 * x).exp() * 0.008).collect();
    assert!(run(&|i| work[i], 500).is_none());
    // 59.94 and 60 Hz are two screens, told apart within four seconds.
    for hz in [59.94, 60.0, 60.0 / 1.001, 119.88] {
        let estimate = run(&|_| 1.0 / hz, 240).unwrap();
        assert!((estimate.hz() - hz).abs() < 0.005, "{hz}: {}", estimate.hz());
    }
    // An interruption of seconds among them is none of the screen's.
    let estimate = run(&|i| if i == 50 { 3.21 } else { 1.0 / 60.0 }, 240).unwrap();
    assert!((estimate.hz() - 60.0).abs() < 0.005);
}

#[test]
fn two_seconds_at_59_94_hz_are_120_refreshes() {
    let refresh = Refresh::from_hz(59.94).unwrap();
    assert_eq!(refresh.count(Duration::from_secs(2)), 120);
    assert_eq!(Refresh::from_hz(60.0).unwrap().count(Duration::from_secs(2)), 120);
    assert_eq!(Refresh::from_hz(119.88).unwrap().count(Duration::from_millis(500)), 60);
    assert_eq!((refresh.count(Duration::ZERO), refresh.count(Duration::from_millis(1))), (0, 1));
}
