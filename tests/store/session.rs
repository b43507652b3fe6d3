//! Sessions without files, a clock or a window: the order of the trials, the state machine and the simulated observer.

use std::{
    collections::{BTreeMap, BTreeSet},
    time::{Duration, Instant},
};

use machband::{
    experiment::{
        Course, Effect, Event, FrameCount, Identity, Observer, OrderedLogit, Phase, Protocol, Resumed, Schedule,
        ScheduleError, Session, SessionOptions, State, TrialResponse, UniformObserver,
    },
    stimulus::{MachBand, ParameterValue, Stimulus},
    store::definition,
};
use proptest::prelude::*;
use rand_chacha::{ChaCha8Rng, rand_core::SeedableRng as _};

fn identity(number: usize) -> Identity {
    Identity::new(&format!("S{number:03}"), "1").unwrap()
}

/// A definition with these `[factors]` and this `[design]`. The uniform field between stimuli lasts half a second.
fn protocol(factors: &str, design: &str) -> Protocol {
    let text = format!(
        "schema = 1\nname = \"test\"\n[stimulus]\nkind = \"mach-band\"\n[factors]\n{factors}\n[design]\n{design}\n[recovery]\nduration_s = 0.5\n"
    );
    definition::parse("test.toml", &text).unwrap()
}

fn conditions(schedule: &Schedule, phase: Phase) -> Vec<usize> {
    schedule.phase(phase).map(|trial| trial.condition).collect()
}

/// Returns the level of a factor in each main trial.
fn levels(schedule: &Schedule, factor: usize) -> Vec<usize> {
    schedule.phase(Phase::Main).map(|trial| schedule.conditions[trial.condition].levels[factor]).collect()
}

/// Returns the levels of a factor without consecutive repetitions, which is the order of the blocks if trials are
/// blocked.
fn blocks(schedule: &Schedule, factor: usize) -> Vec<usize> {
    let mut blocks = levels(schedule, factor);
    blocks.dedup();
    blocks
}

mod order {
    use super::*;

    /// The expected order was computed from the description in `GENERATOR` by an independent ChaCha8 implementation in
    /// Python.
    #[test]
    fn the_order_for_a_seed_never_changes() {
        let quick = definition::open("quick").unwrap();
        let schedule = Schedule::new(&quick, &identity(1), 42).unwrap();
        assert_eq!(conditions(&schedule, Phase::Practice), PINNED_PRACTICE);
        assert_eq!(conditions(&schedule, Phase::Main)[..6], PINNED_MAIN);
        // Participant and session must not be concatenated without a separator.
        for (subject, session, seed) in [("S002", "1", 42), ("S001", "2", 42), ("S00", "11", 42), ("S001", "1", 43)] {
            let other = Schedule::new(&quick, &Identity::new(subject, session).unwrap(), seed).unwrap();
            let order = conditions(&other, Phase::Main);
            assert_ne!(order, conditions(&schedule, Phase::Main), "{subject} {session} {seed}");
        }
    }
    const PINNED_PRACTICE: [usize; 4] = [19, 12, 22, 17];
    const PINNED_MAIN: [usize; 6] = [18, 11, 7, 21, 19, 22];

    #[test]
    fn every_condition_occurs_once_per_repetition_and_blocks_are_contiguous() {
        for order in ["random", "blocked:depth", "latin:depth"] {
            let protocol = protocol(
                "width = [0.1, 0.2]\ndepth = [1, 2, \"inf\"]\norientation_deg = [0, 90]",
                &format!("repetitions = 3\npractice = 29\norder = \"{order}\""),
            );
            for participant in 1..=12 {
                let schedule = Schedule::new(&protocol, &identity(participant), 7).unwrap();
                for phase in [Phase::Practice, Phase::Main] {
                    let mut count = [0_u32; 12];
                    for (trial, number) in schedule.phase(phase).zip(1..) {
                        count[trial.condition] += 1;
                        assert_eq!((trial.number, trial.repetition), (number, count[trial.condition]));
                    }
                    let (least, most) = (count.iter().min().unwrap(), count.iter().max().unwrap());
                    let expected = if phase == Phase::Main { (3, 3) } else { (2, 3) };
                    assert_eq!((*least, *most), expected, "{order} {phase}");
                }
                if order != "random" {
                    assert_eq!(blocks(&schedule, 1).len(), 3, "{order}");
                    let numbers: Vec<u32> = schedule.phase(Phase::Main).map(|trial| trial.block).collect();
                    assert_eq!(numbers, (0..36).map(|i| i / 12 + 1).collect::<Vec<_>>(), "{order}");
                }
            }
        }
    }

    #[test]
    fn latin_blocks_are_balanced_over_participants() {
        let widths = ["0.1", "0.2", "0.3", "0.4", "0.5"];
        for count in 2..=5 {
            let protocol = protocol(
                &format!("depth = [1, 2]\nwidth = [{}]", widths[..count].join(", ")),
                "order = \"latin:width\"",
            );
            // An odd number of levels needs two Latin squares.
            let participants = if count % 2 == 0 { count } else { 2 * count };
            let mut place = vec![vec![0; count]; count];
            let mut follows = vec![vec![0; count]; count];
            for participant in 1..=participants {
                let blocks = blocks(&Schedule::new(&protocol, &identity(participant), 3).unwrap(), 1);
                for (i, level) in blocks.iter().enumerate() {
                    place[i][*level] += 1;
                }
                for pair in blocks.windows(2) {
                    follows[pair[0]][pair[1]] += 1;
                }
            }
            assert!(place.iter().flatten().all(|n| *n == participants / count), "{count}: {place:?}");
            let balanced = |a: usize, b: usize| follows[a][b] == if a == b { 0 } else { participants / count };
            assert!((0..count).all(|a| (0..count).all(|b| balanced(a, b))), "{count}: {follows:?}");
        }
    }

    /// Returns the length of the longest run of equal values.
    fn longest_run(levels: &[usize]) -> usize {
        levels.chunk_by(|a, b| a == b).map(<[usize]>::len).max().unwrap_or(0)
    }

    proptest! {
        /// Blocks follow each other without a break, so the limit also applies across block boundaries.
        #[test]
        fn no_level_is_repeated_more_than_max_run_times(
            widths in 1..5_usize, depths in 1..4_usize, repetitions in 1..4_u32, max_run in 1..5_u32,
            order in prop::sample::select(vec!["random", "blocked:width", "latin:depth"]), seed: u64,
        ) {
            let list = |n: usize, scale: f64| (1..=n).map(|i| (i as f64 * scale).to_string()).collect::<Vec<_>>().join(", ");
            let protocol = protocol(
                &format!("width = [{}]\ndepth = [{}]", list(widths, 0.1), list(depths, 1.0)),
                &format!("repetitions = {repetitions}\norder = \"{order}\"\nmax_run = {max_run}"),
            );
            match Schedule::new(&protocol, &identity(1), seed) {
                Ok(schedule) => {
                    prop_assert_eq!(schedule.trials.len(), protocol.main_trials());
                    let mut cells = conditions(&schedule, Phase::Main);
                    cells.sort_unstable();
                    prop_assert!(cells.chunk_by(|a, b| a == b).all(|run| run.len() == repetitions as usize));
                    for (factor, (name, count)) in [("width", widths), ("depth", depths)].into_iter().enumerate() {
                        if count > 1 && !order.ends_with(name) {
                            let levels = levels(&schedule, factor);
                            prop_assert!(longest_run(&levels) <= max_run as usize, "{order} {name} {levels:?}");
                        }
                    }
                }
                // With two or more levels, each at most twice in a row, there is always a valid order.
                Err(error) => prop_assert!(max_run < 2, "{}", error),
            }
        }
    }

    #[test]
    fn an_impossible_max_run_is_rejected_quickly_with_a_message() {
        let started = Instant::now();
        for repetitions in [1, 10_000] {
            // Both factors would have to change with every trial, so half of the cells could not be reached.
            let protocol =
                protocol("width = [0.1, 0.2]\ndepth = [1, 2]", &format!("repetitions = {repetitions}\nmax_run = 1"));
            let error = Schedule::new(&protocol, &identity(1), 1).unwrap_err();
            assert_eq!(error, ScheduleError { max_run: 1 });
            assert!(error.to_string().contains("max_run = 1") && error.to_string().contains("expected"), "{error}");
        }
        assert!(started.elapsed() < Duration::from_secs(20), "{:?}", started.elapsed());
    }
}

/// A session with a simulated clock.
struct Driver {
    session: Session,
    now: Duration,
    records: Vec<TrialResponse>,
}

impl Driver {
    fn new(protocol: &Protocol, frames: FrameCount, done: &[usize]) -> Self {
        let course = Course::new(protocol, &identity(1), 5).unwrap();
        let resumed = Resumed { done: done.iter().copied().collect(), ..Resumed::default() };
        let session = Session::new(course, &resumed, SessionOptions { pages: 2, frames });
        Self { session, now: Duration::from_secs(3), records: Vec::new() }
    }

    fn step(&mut self, event: Event) -> bool {
        match self.session.step(event, self.now) {
            Effect::None => false,
            Effect::Record(response) => {
                self.records.push(*response);
                true
            }
        }
    }

    fn wait(&mut self, seconds: f64) {
        self.now += Duration::from_secs_f64(seconds);
        self.step(Event::Frame);
    }

    /// Continues until `wanted` accepts the state. Any stimulus in between is rated 1.
    fn until(&mut self, wanted: impl Fn(&State) -> bool) {
        for _ in 0..10_000 {
            if wanted(self.session.state()) {
                return;
            }
            match self.session.state() {
                State::Stimulus { .. } | State::Response { .. } => self.rate(1),
                State::Recovery { .. } | State::Gap { .. } | State::Closing { .. } => self.wait(0.5),
                State::Paused(_) => drop(self.step(Event::Resume)),
                State::Instructions(_) | State::PhaseStart(_) | State::Break => drop(self.step(Event::Continue)),
                State::Done | State::Left => break,
            }
        }
        panic!("ended in {:?}", self.session.state());
    }

    /// Rates the stimulus on the screen; the row is stored immediately.
    fn rate(&mut self, rating: u8) {
        self.now += Duration::from_millis(700);
        assert!(self.step(Event::Rate(rating)), "no stimulus in {:?}", self.session.state());
        self.step(Event::Stored);
    }

    fn rated(&self) -> Vec<(usize, u32)> {
        self.records.iter().map(|record| (record.trial, record.attempt)).collect()
    }
}

const PRACTICE_AND_MAIN: &str = "practice = 2\nrepetitions = 2\nbreak_every = 3";

/// A definition with two practice and eight main trials, and breaks after the third and the sixth main trial.
fn ten() -> Protocol {
    protocol("width = [0.1, 0.2]\ndepth = [1, 2]", PRACTICE_AND_MAIN)
}

fn is_stimulus(state: &State) -> bool {
    matches!(state, State::Stimulus { .. })
}

fn is_recovery(state: &State) -> bool {
    matches!(state, State::Recovery { .. })
}

mod machine {
    use super::*;

    #[test]
    fn a_session_follows_its_plan() {
        let mut driver = Driver::new(&ten(), FrameCount::Off, &[]);
        let mut seen = Vec::new();
        let mut remaining = Vec::new();
        while *driver.session.state() != State::Done {
            let before = driver.session.state().clone();
            let name = match &before {
                State::Instructions(page) => format!("page {page}"),
                State::PhaseStart(phase) => phase.to_string(),
                State::Break => format!("break {}", driver.session.progress().done),
                State::Closing { .. } => "closing".to_owned(),
                _ => "trial".to_owned(),
            };
            driver.until(|state| *state != before);
            if seen.last() != Some(&name) {
                seen.push(name);
            }
            let progress = driver.session.progress();
            assert_eq!((progress.done, progress.total), (driver.records.len(), 10));
            remaining.extend((progress.done > 0).then_some(progress.remaining));
        }
        let expected = "page 0,page 1,practice,trial,main,trial,break 5,trial,break 8,trial,closing";
        assert_eq!(seen.join(","), expected);
        assert_eq!(driver.rated(), (0..10).map(|trial| (trial, 1)).collect::<Vec<_>>());
        // Every trial took 0.5 s + 0.7 s.
        assert_eq!(remaining.first(), Some(&Duration::from_millis(1200 * 9)));
        assert_eq!(remaining.last(), Some(&Duration::ZERO));
        for record in &driver.records {
            assert_eq!((record.recovery.as_millis(), record.response_time.as_millis()), (500, 700));
            assert_eq!((record.frames, record.dropped_frames), (None, None));
        }
        // The pages before the first rating lead back; those after it do not.
        let mut driver = Driver::new(&ten(), FrameCount::Off, &[]);
        driver.until(|state| matches!(state, State::PhaseStart(_)));
        for expected in [State::Instructions(1), State::Instructions(0), State::Instructions(0)] {
            driver.session.step(Event::Back, driver.now);
            assert_eq!(driver.session.state(), &expected);
        }
        driver.until(|state| *state == State::PhaseStart(Phase::Main));
        driver.session.step(Event::Back, driver.now);
        assert_eq!(driver.session.state(), &State::PhaseStart(Phase::Main));
        // There is no break after the last trial.
        let mut driver =
            Driver::new(&protocol("width = [0.1, 0.2]", "repetitions = 2\nbreak_every = 2"), FrameCount::Off, &[]);
        driver.until(|state| *state == State::Break);
        driver.until(|state| matches!(state, State::Closing { .. }));
        assert_eq!(driver.records.len(), 4);
    }

    #[test]
    fn the_last_rating_can_be_undone_once_from_any_screen_after_it() {
        type There = fn(&State) -> bool;
        let is_break: There = |state| *state == State::Break;
        let is_page: There = |state| *state == State::PhaseStart(Phase::Main);
        let is_closing: There = |state| matches!(state, State::Closing { .. });
        // The state that is reached first, and the state in which the rating is undone. After a break, undoing does not
        // repeat the break.
        let places: [(&str, There, There); 5] = [
            ("recovery", is_recovery, is_recovery),
            ("the next phase's page", is_page, is_page),
            ("break", is_break, is_break),
            ("after a break", is_break, is_recovery),
            ("closing", is_closing, is_closing),
        ];
        for (place, first, there) in places {
            let mut driver = Driver::new(&ten(), FrameCount::Off, &[]);
            driver.until(is_stimulus);
            driver.rate(1);
            driver.until(first);
            if !there(driver.session.state()) {
                driver.step(Event::Continue);
            }
            let last = *driver.rated().last().unwrap();
            let next = driver.session.current();
            assert!(driver.session.can_undo(), "{place}");
            driver.step(Event::Undo);
            assert_eq!((driver.session.current(), driver.session.can_undo()), (Some(last.0), false), "{place}");
            // It cannot be undone a second time, nor can the rating before it.
            driver.step(Event::Undo);
            driver.until(is_stimulus);
            driver.step(Event::Undo);
            driver.rate(2);
            assert_eq!(*driver.rated().last().unwrap(), (last.0, 2), "{place}");
            assert!(there(driver.session.state()), "{place}: {:?}", driver.session.state());
            assert_eq!(driver.session.current(), next, "{place}");
            // A third attempt is possible after the second.
            driver.step(Event::Undo);
            driver.until(is_stimulus);
            driver.rate(3);
            assert_eq!(*driver.rated().last().unwrap(), (last.0, 3), "{place}");
            driver.until(|state| *state == State::Done);
            let firsts: Vec<usize> = driver.rated().into_iter().filter(|r| r.1 == 1).map(|r| r.0).collect();
            assert_eq!(firsts, (0..10).collect::<Vec<_>>(), "{place}");
            assert_eq!(driver.records.len(), 12, "{place}");
        }
    }

    fn any_event() -> impl Strategy<Value = Event> {
        // Common events are generated more often, so that a sequence makes progress.
        prop_oneof![
            8 => Just(Event::Frame),
            3 => Just(Event::Stored),
            3 => Just(Event::Continue),
            4 => (0..6_u8).prop_map(Event::Rate),
            2 => Just(Event::Undo),
            1 => Just(Event::Pause),
            2 => Just(Event::Resume),
            1 => Just(Event::Leave),
        ]
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(400))]

        /// For any sequence of events, rows are valid and unique, no stimulus appears too early or while a row is not
        /// stored yet, and in the end every trial is rated in the planned order.
        #[test]
        fn no_sequence_of_events_loses_data(events in prop::collection::vec((any_event(), 0..1500_u64), 0..400)) {
            let mut driver = Driver::new(&ten(), FrameCount::Against(1.0 / 60.0), &[]);
            let mut stored = true;
            let mut done = 0;
            for (event, after) in events {
                driver.now += Duration::from_millis(after);
                let before = driver.session.state().clone();
                let could = driver.session.can_undo();
                let recorded = driver.step(event);
                let state = driver.session.state();
                if recorded {
                    prop_assert!(is_stimulus(&before) && stored && matches!(event, Event::Rate(0..=3)));
                    stored = false;
                } else if event == Event::Stored {
                    stored = true;
                }
                prop_assert_eq!(driver.session.is_storing(), !stored);
                prop_assert!(stored || !driver.session.can_undo() && *state != State::Done);
                // A session can be left only from the pause, and leaving is final.
                let left = before == State::Left || event == Event::Leave && matches!(before, State::Paused(_));
                prop_assert_eq!(*state == State::Left, left);
                if event == Event::Undo {
                    // A field that began at this very moment starts over at the same time, so the state looks
                    // unchanged; only the session knows the difference.
                    let taken = could && !driver.session.can_undo();
                    prop_assert!(taken || !could && *state == before);
                }
                if let (State::Stimulus { onset, .. }, State::Recovery { since }) = (state, &before) {
                    // Durations are rounded to whole refreshes, so an onset is at most half a refresh early.
                    prop_assert!(stored && *onset == driver.now && (*onset - *since).as_micros() >= 500_000 - 8_334);
                }
                let progress = driver.session.progress();
                prop_assert!(progress.done >= done && progress.done <= 10);
                done = progress.done;
            }
            driver.step(Event::Stored);
            let mut rated = driver.rated();
            if *driver.session.state() == State::Left {
                let done: BTreeSet<_> = rated.iter().map(|r| r.0).collect();
                driver = Driver::new(&ten(), FrameCount::Off, &done.into_iter().collect::<Vec<_>>());
            } else {
                rated.clear();
            }
            driver.until(|state| *state == State::Done);
            rated.extend(driver.rated());
            let firsts: Vec<_> = rated.iter().filter(|r| r.1 == 1).map(|r| r.0).collect();
            prop_assert_eq!(firsts, (0..10).collect::<Vec<_>>());
            let mut attempts = BTreeMap::new();
            for (trial, attempt) in rated {
                let last = attempts.insert(trial, attempt).unwrap_or(0);
                prop_assert_eq!(attempt, last + 1);
            }
        }
    }
}

mod observer {
    use super::*;

    fn band(settings: &[(&str, f64)]) -> Stimulus {
        let mut stimulus = Stimulus::MachBand(MachBand::default());
        for (name, value) in settings {
            let value = if value.is_infinite() { ParameterValue::from("inf") } else { ParameterValue::from(*value) };
            stimulus.set(name, &value).unwrap();
        }
        stimulus
    }

    fn frequencies(observer: &dyn Observer, stimulus: &Stimulus, subject: f64, draws: u32) -> [f64; 4] {
        let mut rng = ChaCha8Rng::seed_from_u64(11);
        let mut count = [0_u32; 4];
        for _ in 0..draws {
            count[usize::from(observer.rate(stimulus, 4, subject, &mut rng))] += 1;
        }
        count.map(|n| f64::from(n) / f64::from(draws))
    }

    /// Compares with the probabilities from the doc comment, computed by hand for each stimulus.
    #[test]
    fn ratings_have_the_documented_probabilities() {
        let observer = OrderedLogit { oblique: 0.8, contrast: 0.5, lapse: 0.1, ..OrderedLogit::default() };
        // Parameters of the stimulus, the participant's standard normal deviate, and η.
        type Case<'a> = (&'a [(&'a str, f64)], f64, f64);
        let cases: [Case; 7] = [
            (&[("width", 0.05), ("depth", 1.0)], 0.0, 6.0),
            (&[("width", 0.2), ("depth", 2.0)], 0.0, 3.0 - 2.0 * 0.7),
            (&[("width", 0.0125), ("depth", 3.0)], 0.0, 2.0 - 2.0 * 0.9),
            (&[("width", 0.1), ("depth", f64::INFINITY)], 1.5, 6.0 / 5.0 - 0.7 + 0.6 * 1.5),
            (&[("width", 0.05), ("depth", 4.0), ("orientation_deg", 135.0)], -1.0, 1.5 + 0.8 - 0.6),
            (&[("width", 0.4), ("depth", 1.0), ("orientation_deg", 15.0)], 0.0, 6.0 - 2.1 + 0.4),
            // The Michelson contrast is (0.6 − 0.2)/0.8 = ½, and it is 1 for a black plateau.
            (&[("width", 0.05), ("depth", 4.0), ("low", 0.0), ("high", 0.6)], 0.0, 1.5 + 0.5),
        ];
        let draws = 60_000;
        for (settings, subject, eta) in cases {
            let stimulus = band(settings);
            assert!((observer.predictor(&stimulus, subject) - eta).abs() < 1e-12, "{settings:?}");
            let below = [0.0, 1.5, 3.5].map(|threshold: f64| 1.0 / (1.0 + (eta - threshold).exp()));
            let exact = [below[0], below[1] - below[0], below[2] - below[1], 1.0 - below[2]];
            for (found, exact) in frequencies(&observer, &stimulus, subject, draws).into_iter().zip(exact) {
                let expected = 0.9 * exact + 0.1 / 4.0;
                let error = (expected * (1.0 - expected) / f64::from(draws)).sqrt();
                assert!((found - expected).abs() < 4.0 * error, "{settings:?}: {found} is not {expected} ± {error}");
            }
        }
        for found in frequencies(&UniformObserver, &band(&[]), 0.0, draws) {
            assert!((found - 0.25).abs() < 4.0 * (0.25 * 0.75 / f64::from(draws)).sqrt(), "{found}");
        }
    }
}
