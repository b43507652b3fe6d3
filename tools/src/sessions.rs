//! Sessions that `machband simulate` does not produce: a very long one, and one that was interrupted.

use std::{
    fs::OpenOptions,
    io::Write as _,
    path::Path,
    time::{Duration, Instant},
};

use jiff::Timestamp;
use machband::{
    experiment::{
        Course, Effect, Event, FrameCount, Identity, OrderedLogit, Resumed, RowContext, Schedule, Session,
        SessionOptions, State, TrialRecord, simulate,
    },
    store::{
        definition, observer,
        session::SessionStore,
        sidecar::{Pictures, SimulatedObserver, Sitting},
    },
};

/// 200 conditions, each rated 100 times.
const DEFINITION: &str = r#"
schema = 1
name = "long"
title = "Twenty thousand trials"
[stimulus]
kind = "mach-band"
[factors]
width = [0.02, 0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8]
depth = [1, 2, 3, 4]
orientation_deg = [0, 45, 90, 135, 180]
[design]
repetitions = 100
practice = 0
"#;
/// Trials per row of the printed table.
const EACH: usize = 1000;

/// Runs a session of 20,000 trials through the real session and the real store to see whether memory or the time per
/// trial grows.
///
/// Prints a table with one row per thousand trials: milliseconds per trial (median and 99th percentile; the disk takes
/// nearly all of it) and resident memory. The session is written to FOLDER or to a temporary folder. Use a RAM disk
/// (`/dev/shm`) to exclude the time of the disk.
pub fn long(folder: &Path) -> Result<(), Box<dyn std::error::Error>> {
    let results = folder.join(format!("machband-long-{}", std::process::id()));
    let protocol = definition::parse("long.toml", DEFINITION)?;
    let identity = Identity::new("S001", "1")?;
    let course = Course::new(&protocol, &identity, 1)?;
    let schedule = course.schedule().clone();
    let options = SessionOptions { pages: 0, frames: FrameCount::Off };
    let mut session = Session::new(course, &Resumed::default(), options);
    let observer: OrderedLogit = observer::parse("paper.toml", observer::PAPER)?;
    let (mut store, _) = SessionStore::create(&results, &protocol, &identity, 1, Sitting::default())?;
    let context = RowContext { protocol: &protocol, schedule: &schedule, identity: &identity, sitting: 1 };
    println!("{:>6}  {:>9}  {:>9}  {:>8}", "trials", "median ms", "99 % ms", "MiB");
    let (mut times, mut trials, mut last) = (Vec::with_capacity(EACH), 0, Instant::now());
    simulate(&mut session, &observer, &identity, Duration::ZERO, |response| {
        store.append(&TrialRecord::new(&context, response, Timestamp::UNIX_EPOCH + response.onset))?;
        trials += 1;
        times.push(last.elapsed());
        last = Instant::now();
        if times.len() == EACH {
            times.sort_unstable();
            let ms = |at: usize| times[at].as_secs_f64() * 1e3;
            println!("{trials:>6}  {:>9.3}  {:>9.3}  {:>8.1}", ms(EACH / 2), ms(EACH * 99 / 100), resident_mib());
            times.clear();
        }
        Ok::<_, machband::store::StoreError>(())
    })?;
    store.finish(true, Timestamp::UNIX_EPOCH.to_string(), None)?;
    std::fs::remove_dir_all(&results)?;
    Ok(())
}

/// Resident memory of this process if Linux reports it, and otherwise 0.
fn resident_mib() -> f64 {
    let pages = std::fs::read_to_string("/proc/self/statm").unwrap_or_default();
    pages.split(' ').nth(1).and_then(|pages| pages.parse::<f64>().ok()).unwrap_or_default() * 4096.0
        / f64::from(1 << 20)
}

/// Ratings before the program is killed; the middle one is corrected.
const RATED: usize = 11;
/// The default seed of `machband simulate`, so that it can resume the session.
const SEED: u64 = 1;

/// Writes the first half of an interrupted session that contains a corrected response.
///
/// Participant S001 of `quick` rates a few trials and corrects one rating; then the program is killed while it writes a
/// row. `machband simulate quick --results RESULTS --resume` continues the session. Participant S001 of
/// `examples/quick-ja.toml` has answered its questions and can be resumed in the same way. A simulated observer never corrects
/// a rating, is never interrupted and answers no questions, so these sessions are needed to test how exports handle
/// that.
pub fn sample(results: &Path) -> Result<(), Box<dyn std::error::Error>> {
    let protocol = definition::open("quick")?;
    let identity = Identity::new("S001", "1")?;
    let schedule = Schedule::new(&protocol, &identity, SEED)?;
    // An hour ago, so that the simulated rest of the session does not start earlier.
    let now = Timestamp::now() - Duration::from_secs(3600);
    let sitting = Sitting {
        started_at: now.to_string(),
        observer: Some(SimulatedObserver::Program { name: "tools sample-study".to_owned() }),
        pictures: Some(Pictures::without_screen(&protocol)),
        ..Sitting::default()
    };
    // A participant who has answered the questions of a definition, and has yet to see a trial.
    let asking = definition::open(concat!(env!("CARGO_MANIFEST_DIR"), "/../examples/quick-ja.toml"))?;
    let asked = Sitting { pictures: Some(Pictures::without_screen(&asking)), ..sitting.clone() };
    let answers = serde_json::json!({ "age": 27, "sex": "other", "vision": "with glasses", "consent": "2026-01-31" });
    SessionStore::create(results, &asking, &identity, SEED, asked)?
        .0
        .keep_participant(serde_json::from_value(answers)?);
    let (mut store, _) = SessionStore::create(results, &protocol, &identity, SEED, sitting)?;
    let context = RowContext { protocol: &protocol, schedule: &schedule, identity: &identity, sitting: 1 };
    let options = SessionOptions { pages: 0, frames: FrameCount::Off };
    let mut session = Session::new(Course::new(&protocol, &identity, SEED)?, &Resumed::default(), options);
    let mut at = Duration::ZERO;
    let (mut rows, mut undone) = (Vec::new(), false);
    while rows.len() < RATED {
        at += Duration::from_millis(700);
        if rows.len() == RATED / 2 && !undone && session.can_undo() {
            undone = true;
            session.step(Event::Undo, at);
        }
        let event = match session.state() {
            State::PhaseStart(_) | State::Break => Event::Continue,
            State::Stimulus { .. } => Event::Rate((rows.len() % 4) as u8),
            _ => Event::Frame,
        };
        if let Effect::Record(response) = session.step(event, at) {
            let row = TrialRecord::new(&context, &response, now + response.onset);
            store.append(&row)?;
            session.step(Event::Stored, at);
            rows.push(row);
        }
    }
    let csv = store.csv().to_owned();
    drop(store);
    // The power fails while the next row is written.
    OpenOptions::new().append(true).open(&csv)?.write_all(b"S001_1_main_00")?;
    println!("{}: {} rows, one of them corrected, and half a row", csv.display(), rows.len());
    Ok(())
}
