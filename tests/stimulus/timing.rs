//! Frames under a simulated clock, so that every count is known in advance.

use std::time::Duration;

use machband::{
    app::{Monitor, judged_frames},
    display::frames::{FrameTimes, Refresh},
    experiment::{
        Course, Effect, Event, FrameCount, Identity, Resumed, Session, SessionOptions, Shown, State, TrialResponse,
    },
    store::definition,
};
use proptest::prelude::*;

/// A screen that refreshes at exact times, with a program that misses some refreshes.
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

    /// Shows the next frame `refreshes` refreshes after the last, observed `early` refreshes too early.
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

/// Returns numbers in −1…1 that look random but are the same on every machine.
fn noise(seed: u64) -> impl Iterator<Item = f64> {
    (1..).map(move |i: u64| {
        let mixed = (i + seed).wrapping_mul(0x9e37_79b9_7f4a_7c15).rotate_left(31).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        (mixed >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    })
}

#[test]
fn a_steady_screen_never_drops_a_frame() {
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
fn a_stall_is_one_dropped_frame_but_several_missed_refreshes() {
    let mut screen = Screen::new(60.0);
    let stalls = [(100, 2), (200, 3), (201, 3), (500, 61), (999, 10)];
    // A jitter of a fifth neither adds nor hides drops; the longest interval is exact.
    for (i, jitter) in noise(7).take(1001).enumerate() {
        let refreshes = stalls.iter().find(|(at, _)| *at == i).map_or(1, |(_, refreshes)| *refreshes);
        screen.frame(refreshes, if (499..501).contains(&i) { 0.0 } else { 0.2 * jitter });
    }
    assert_eq!(screen.counted(), (1000, 5, 1 + 2 + 2 + 60 + 9));
    assert_eq!(screen.times.quantile(1.0), Some(1.016_667));

    // A page without frames in between is neither a stall nor an interval.
    let before = screen.counted();
    screen.times.interrupt();
    screen.frame(600, 0.0);
    assert_eq!(screen.counted(), before);
    screen.frame(1, 0.0);
    assert_eq!(screen.counted(), (1001, before.1, before.2));
}

proptest! {
    /// The refresh is estimated correctly in spite of jitter and drops, and is not rounded to a common rate. Only the
    /// jitter of the first and the last frame affects it.
    #[test]
    fn the_refresh_is_estimated_from_frames_that_jitter_and_drop(
        hz in 24.0..250.0_f64, jitter in 0.0..0.2_f64, drops in 0.0..0.15_f64, frames in 200..2000_usize, seed: u32,
    ) {
        let mut screen = Screen::new(hz);
        let chance: Vec<f64> = noise(u64::from(seed) + 99).take(frames).collect();
        for (early, chance) in noise(u64::from(seed)).take(frames).zip(chance) {
            // Uniform in −1…1, so that a share of `drops` lies below this.
            screen.frame(if chance < 2.0 * drops - 1.0 { 2 } else { 1 }, jitter * early);
        }
        let estimate = Refresh::estimate(screen.times.intervals_us()).expect("steady enough");
        let bound = (2.0 * jitter + 0.001) / (frames - 1) as f64;
        prop_assert!((estimate.hz() / hz - 1.0).abs() < bound + 1e-4 / frames as f64 * hz, "{} {hz}", estimate.hz());
    }

    /// Durations are whole numbers of refreshes: the first frame that is due is always the Nth, regardless of the
    /// jitter.
    #[test]
    fn jitter_does_not_change_the_frames_of_a_duration(
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
fn a_refresh_is_not_invented() {
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
    assert!(run(&|_| 0.15, 240).is_none(), "too slow");
    // Frames that are not synchronized with a screen take as long as the work takes.
    let work: Vec<f64> = noise(5).take(500).map(|x| (2.0 * x).exp() * 0.008).collect();
    assert!(run(&|i| work[i], 500).is_none());
    // An interruption of several seconds does not count as a screen interval.
    let estimate = run(&|i| if i == 50 { 3.21 } else { 1.0 / 60.0 }, 240).unwrap();
    assert!((estimate.hz() - 60.0).abs() < 0.005);
}

// What the page *Timing* says about frames.

/// Returns intervals of frames that are not synchronized with a screen: a median of 8 ms, ranging from 4 to 20 ms.
fn scattered() -> Vec<u32> {
    noise(11).take(600).map(|x| (8000.0 * (0.4 * x).exp() + if x > 0.9 { 9000.0 } else { 0.0 }) as u32).collect()
}

#[test]
fn only_a_steady_refresh_is_reported_with_the_drops() {
    assert!(Refresh::estimate(&scattered()).is_some(), "otherwise this proves nothing");
    let steady = vec![16_667; 600];
    let mut dropping = steady.clone();
    dropping.iter_mut().step_by(50).for_each(|us| *us = 33_333);
    let unsteady = "The frames do not follow a steady refresh, so no frame can be judged as dropped";
    let not_the_reported = "a steady refresh, not even the 60.00 Hz that the system reports";
    let every = "Every refresh at 60.00 Hz showed a new frame: none of 600 was dropped.";
    let with_drops = "of 60.00 Hz; dropped frames: 12 of 600 (2.0 %)";
    for (intervals_us, refresh_hz, source, is_one_by_one, verdict) in [
        (scattered(), None, "unknown", false, unsteady),
        (scattered(), Some(60.0), "reported", false, not_the_reported),
        (steady, None, "measured", true, every),
        (dropping, Some(60.0), "reported", false, with_drops),
    ] {
        let monitor = Monitor { name: None, width_px: 1920, height_px: 1080, refresh_hz, scale: 1.0 };
        let (told, refresh) = judged_frames(&intervals_us, &monitor);
        let says = |text: &str| told.iter().any(|(line, _)| line.contains(text));
        assert!(told[0].0.contains(verdict) && told[0].1 != is_one_by_one && says(source), "{told:?}");
        assert!(verdict != with_drops || says("Dropped frames: 12"), "{told:?}");
        if source == "unknown" {
            assert_eq!(refresh, None);
            let unknown =
                ["Refresh", "Dropped frames", "Missed refreshes"].map(|name| says(&format!("{name}: unknown")));
            assert_eq!(unknown, [true; 3]);
        }
    }
}

// The state machine of a session on a simulated screen.

/// A session on a simulated screen, and the rows that it recorded.
struct Sitting {
    session: Session,
    now_s: f64,
    refresh_s: f64,
    rows: Vec<TrialResponse>,
}

impl Sitting {
    fn new(tables: &str, hz: f64) -> Self {
        let text = format!(
            "schema = 1\nname = \"t\"\n[stimulus]\nkind = \"mach-band\"\n[factors]\nwidth = [0.1, 0.2, 0.3, 0.4]\n{tables}"
        );
        let protocol = definition::parse("t.toml", &text).unwrap();
        let course = Course::new(&protocol, &Identity::new("S001", "1").unwrap(), 5).unwrap();
        let options = SessionOptions { pages: 0, frames: FrameCount::Against(1.0 / hz) };
        let mut session = Session::new(course, &Resumed::default(), options);
        session.step(Event::Continue, Duration::from_secs(1));
        let mut sitting = Self { session, now_s: 1.0, refresh_s: 1.0 / hz, rows: Vec::new() };
        sitting.frame(0, 0.0, None);
        sitting
    }

    /// Shows the next frame, as in [`Screen::frame`]. `event` came before it.
    fn frame(&mut self, refreshes: u32, early: f64, event: Option<Event>) -> &State {
        self.now_s += f64::from(refreshes) * self.refresh_s;
        let now = Duration::from_secs_f64(self.now_s - early * self.refresh_s);
        if let Some(event) = event
            && let Effect::Record(row) = self.session.step(event, now)
        {
            self.rows.push(*row);
            self.session.step(Event::Stored, now);
        }
        self.session.step(Event::Frame, now);
        self.session.state()
    }

    /// Shows frames of one refresh each until `wanted` accepts the state. Returns their number.
    fn until(&mut self, wanted: fn(&State) -> bool) -> u32 {
        (1..10_000).find(|_| wanted(self.frame(1, 0.0, None))).expect("a state that comes")
    }
}

fn is_stimulus(state: &State) -> bool {
    matches!(state, State::Stimulus { .. })
}

fn is_recovery(state: &State) -> bool {
    matches!(state, State::Recovery { .. })
}

#[test]
fn jitter_does_not_change_the_refreshes_of_a_recovery() {
    for (hz, planned) in [(59.94, 120), (60.0, 120), (120.0, 240), (75.0, 150)] {
        let mut sitting = Sitting::new("[design]\nrepetitions = 5\n", hz);
        let mut noise = noise(11);
        while *sitting.session.state() != State::Done {
            let event = match sitting.session.state() {
                State::PhaseStart(_) | State::Break => Some(Event::Continue),
                State::Stimulus { .. } => Some(Event::Rate(2)),
                _ => None,
            };
            sitting.frame(1, 0.2 * noise.next().unwrap(), event);
        }
        let runs = sitting.session.take_frame_runs();
        let counts = |shown: Shown| -> Vec<usize> {
            runs.iter().filter(|s| s.shown == shown).map(|s| s.intervals_us.len()).collect()
        };
        assert_eq!(counts(Shown::Recovery), [planned; 20], "{hz}");
        assert_eq!((counts(Shown::Stimulus), counts(Shown::Closing)), (vec![1; 20], vec![planned]), "{hz}");
        // The intervals that were kept are exactly those that were counted.
        let kept: Vec<u32> = runs.iter().flat_map(|s| s.intervals_us.clone()).collect();
        let times = sitting.session.frame_times();
        assert_eq!(kept, times.intervals_us());
        assert_eq!((times.dropped(), times.missed_refreshes(), times.late_onsets()), (Some(0), Some(0), 0));
        for row in &sitting.rows {
            assert_eq!((row.frames, row.dropped_frames, row.late_onset), (Some(1), Some(0), Some(false)));
            let achieved = row.recovery.as_secs_f64() * hz;
            assert!((achieved - planned as f64).abs() < 0.41, "{achieved} of {planned}");
        }
    }
}

#[test]
fn a_rating_is_timed_by_its_timestamp_and_the_stimulus_by_its_frames() {
    let mut sitting = Sitting::new("", 60.0);
    let ms = Duration::from_millis;
    let frame = Duration::from_secs_f64(1.0 / 60.0);
    for (before_frame_ms, expected) in
        // Received 4 ms before the frame, before the onset, and after the frame that handles it.
        [(4, 30 * frame - ms(4)), (9_000, Duration::ZERO), (0, 30 * frame)]
    {
        sitting.until(is_stimulus);
        (0..29).for_each(|_| _ = sitting.frame(1, 0.0, None));
        let at = match before_frame_ms {
            0 => Duration::from_secs(9_999),
            early => Duration::from_secs_f64(sitting.now_s + 1.0 / 60.0).saturating_sub(ms(early)),
        };
        sitting.frame(1, 0.0, Some(Event::RateAt { rating: 1, at, uncertainty: Some(ms(3)) }));
        let row = sitting.rows.last().unwrap();
        assert!(row.response_time.abs_diff(expected) < Duration::from_micros(1), "{row:?}");
        assert!(row.stimulus.unwrap().abs_diff(30 * frame) < Duration::from_micros(1), "{row:?}");
        assert_eq!((row.frames, row.uncertainty), (Some(30), Some(ms(3))));
    }
}

#[test]
fn a_fixed_presentation_lasts_its_refreshes_and_waits_for_the_rating() {
    for (hz, planned) in [(59.94, 30), (60.0, 30), (144.0, 72)] {
        let mut sitting = Sitting::new("[presentation]\nduration_s = 0.5\n", hz);
        sitting.until(is_stimulus);
        assert_eq!(sitting.until(|state| matches!(state, State::Response { .. })), planned, "{hz}");
        (0..40).for_each(|_| _ = sitting.frame(1, 0.0, None));
        sitting.frame(2, 0.0, Some(Event::Rate(3)));
        let row = &sitting.rows[0];
        let elapsed = |refreshes: u32| Duration::from_secs_f64(f64::from(refreshes) / hz);
        assert_eq!(row.frames, Some(planned));
        // A frame dropped after the stimulus does not count for the stimulus.
        assert_eq!(row.dropped_frames, Some(0));
        assert!(row.stimulus.unwrap().abs_diff(elapsed(planned)) < Duration::from_micros(1));
        assert!(row.response_time.abs_diff(elapsed(planned + 42)) < Duration::from_micros(1));
        // If the session is paused while waiting for the answer, the trial starts over.
        sitting.until(|state| matches!(state, State::Response { .. }));
        sitting.frame(1, 0.0, Some(Event::Pause));
        assert!(is_recovery(sitting.frame(60, 0.0, Some(Event::Resume))));
        // An early rating ends the stimulus.
        sitting.until(is_stimulus);
        assert!(is_recovery(sitting.frame(1, 0.0, Some(Event::Rate(0)))));
        assert_eq!((sitting.rows[1].frames, sitting.rows[1].attempt), (Some(1), 1));
        let pages = sitting.session.frame_times().missed_refreshes();
        assert_eq!(pages, Some(1), "one refresh was missed above, and the time on the pause page does not count");
    }
}

#[test]
fn an_onset_is_late_if_it_misses_its_refresh() {
    for (last, late) in [(1, false), (2, true), (30, true)] {
        let mut sitting = Sitting::new("", 60.0);
        (0..119).for_each(|_| assert!(is_recovery(sitting.frame(1, 0.0, None))));
        assert!(is_stimulus(sitting.frame(last, 0.0, None)));
        sitting.frame(1, 0.0, Some(Event::Rate(1)));
        let (row, times) = (&sitting.rows[0], sitting.session.frame_times());
        assert_eq!((row.late_onset, times.late_onsets()), (Some(late), u32::from(late)));
        assert_eq!(row.dropped_frames, Some(u32::from(late)));
        assert_eq!(times.missed_refreshes(), Some(u64::from(last) - 1));
    }
    // If the disk is slow, no frames are dropped, but the onset is still late.
    let mut sitting = Sitting::new("", 60.0);
    sitting.until(is_stimulus);
    let now = Duration::from_secs_f64(sitting.now_s);
    assert!(matches!(sitting.session.step(Event::Rate(1), now), Effect::Record(_)));
    (0..125).for_each(|_| assert!(is_recovery(sitting.frame(1, 0.0, None))));
    sitting.session.step(Event::Stored, Duration::from_secs_f64(sitting.now_s));
    assert!(is_stimulus(sitting.frame(1, 0.0, None)));
    sitting.frame(1, 0.0, Some(Event::Rate(1)));
    assert_eq!((sitting.rows[0].late_onset, sitting.rows[0].dropped_frames), (Some(true), Some(0)));
}

#[test]
fn a_frame_belongs_to_the_trial_whose_picture_it_shows() {
    let mut sitting = Sitting::new("", 60.0);
    sitting.until(is_stimulus);
    sitting.frame(3, 0.0, Some(Event::Rate(1)));
    // The rating is undone after two frames of the next recovery; the third frame takes four refreshes.
    sitting.frame(1, 0.0, None);
    sitting.frame(1, 0.0, None);
    sitting.frame(4, 0.0, Some(Event::Undo));
    sitting.until(is_stimulus);
    sitting.frame(1, 0.0, Some(Event::Rate(2)));
    assert_eq!(sitting.rows[0].dropped_frames, Some(1), "the last frame of the stimulus");
    assert_eq!(sitting.rows[1].dropped_frames, Some(0), "the frame before the rating was undone does not count");
    let trials: Vec<_> = (sitting.session.take_frame_runs().iter())
        .map(|s| (s.trial, s.attempt, s.shown, s.intervals_us.len()))
        .collect();
    let expected = [
        (0, 1, Shown::Recovery, 120),
        (0, 1, Shown::Stimulus, 1),
        (1, 1, Shown::Recovery, 3),
        (0, 2, Shown::Recovery, 120),
        (0, 2, Shown::Stimulus, 1),
    ];
    assert_eq!(trials, expected);
    assert_eq!(sitting.session.take_frame_runs(), [], "each run is returned only once");
}
