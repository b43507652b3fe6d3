//! Writes the first half of an interrupted session that contains a corrected response.
//!
//! Participant S001 of `quick` rates a few trials and corrects one rating; then the program is killed while it writes a row.
//! `machband simulate quick --results RESULTS --resume` continues the session. A simulated observer never corrects a rating
//! and is never interrupted, so this session is needed to test how exports handle both.

use std::{fs::OpenOptions, io::Write as _, path::Path, time::Duration};

use jiff::Timestamp;
use machband::{
    experiment::{
        Effect, Event, FrameCount, Identity, Resumed, RowContext, Schedule, Session, SessionOptions, State, TrialRecord,
    },
    store::{
        definition,
        session::SessionStore,
        sidecar::{Pictures, Sitting},
    },
};

/// Ratings before the program is killed; the middle one is corrected.
const RATED: usize = 11;
/// The same as in `simulate`.
const SEED: u64 = 1;

pub fn run(results: &Path) -> Result<(), Box<dyn std::error::Error>> {
    let protocol = definition::open("quick")?;
    let identity = Identity::new("S001", "1")?;
    let schedule = Schedule::new(&protocol, &identity, SEED)?;
    // An hour ago, so that the simulated rest of the session does not start earlier.
    let now = Timestamp::now() - Duration::from_secs(3600);
    let sitting = Sitting {
        started_at: now.to_string(),
        observer: Some(serde_json::json!({ "observer": "tools sample-study" })),
        pictures: Some(Pictures::without_screen(&protocol)),
        ..Sitting::default()
    };
    let mut store = SessionStore::create(results, &protocol, &identity, SEED, sitting)?;
    let context = RowContext { protocol: &protocol, schedule: &schedule, identity: &identity, sitting: 1 };
    let options = SessionOptions { pages: 0, frames: FrameCount::Off };
    let mut session = Session::new(protocol.clone(), schedule.clone(), &Resumed::default(), options);
    let mut at = Duration::ZERO;
    let (mut rows, mut taken_back) = (Vec::new(), false);
    while rows.len() < RATED {
        at += Duration::from_millis(700);
        if rows.len() == RATED / 2 && !taken_back && session.can_take_back() {
            taken_back = true;
            session.step(Event::TakeBack, at);
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
