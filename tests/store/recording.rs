//! A small session on disk, and a simulated observer that rates it.

use std::{path::Path, time::Duration};

use jiff::Timestamp;
use machband::{
    experiment::{Course, Identity, Protocol, TrialRecord, TrialResponse, task::Answer},
    store::{
        StoreError,
        dataset::SessionPaths,
        definition,
        session::{Changes, Interrupted, SessionStore},
        sidecar::Sitting,
    },
};

use crate::common;

/// The seed of every session.
pub const SEED: u64 = 7;

/// A definition with two practice and four main trials. Its color contains commas and must be quoted, and `tanh_k`
/// needs its own column.
pub const TEXT: &str = "schema = 1\nname = \"small-one\"\ntitle = \"Small\"\n[stimulus]\nkind = \"mach-band\"\ncolor = \"1,0.5,0\"\n[factors]\nwidth = [0.1, 0.4]\ntanh_k = [5, 7.5]\n[design]\npractice = 2\n[recovery]\nduration_s = 0.1\n";

pub fn small() -> Protocol {
    definition::parse("small.toml", TEXT).unwrap()
}

pub fn identity() -> Identity {
    Identity::new("S001", "1").unwrap()
}

pub fn paths(results: &Path) -> SessionPaths {
    SessionPaths::new(results, &small(), &identity())
}

pub fn create(results: &Path) -> Result<SessionStore, StoreError> {
    SessionStore::create(results, &small(), &identity(), SEED, sitting()).map(|(store, _)| store)
}

pub fn resume(results: &Path) -> Result<(SessionStore, Interrupted), StoreError> {
    SessionStore::resume(results, &small(), &identity(), Some(SEED), sitting(), Changes::Refuse)
}

pub fn rows(csv: &Path) -> Vec<TrialRecord> {
    common::rows(csv, &small())
}

pub fn sitting() -> Sitting {
    Sitting { started_at: Timestamp::UNIX_EPOCH.to_string(), ..Sitting::default() }
}

/// Records up to `limit` trials of a participant.
pub fn record(results: &Path, subject: &str, limit: usize) -> SessionStore {
    let identity = Identity::new(subject, "1").unwrap();
    let (mut store, _) = SessionStore::create(results, &small(), &identity, SEED, sitting()).unwrap();
    rate(&mut store, (&small(), &identity), None, limit, false).unwrap();
    store
}

/// Returns the rating at the other end of the paper's scale.
fn other(answer: &Answer) -> Answer {
    let Answer::Key(rating) = answer else { panic!("{answer:?}") };
    Answer::Key(3 - rating)
}

/// Rates up to `limit` of the remaining trials, and ends the session if none remain. With `again`, every fourth rating
/// is undone and given again.
pub fn rate(
    store: &mut SessionStore,
    (protocol, identity): (&Protocol, &Identity),
    found: Option<&Interrupted>,
    limit: usize,
    again: bool,
) -> Result<(), StoreError> {
    let new = Interrupted::before_the_first_trial(Course::new(protocol, identity, SEED).unwrap());
    let mut left = limit;
    let rated = common::answer(found.unwrap_or(&new), identity, |context, response| {
        left = left.checked_sub(1).ok_or(None)?;
        let mut append = |what: &TrialResponse| {
            store.append(&TrialRecord::new(context, what, Timestamp::UNIX_EPOCH + what.onset)).map_err(Some)
        };
        append(response)?;
        if again && response.trial % 4 == 3 {
            let onset = response.onset + response.response_time;
            append(&TrialResponse {
                attempt: 2,
                answer: other(&response.answer),
                onset,
                response_time: Duration::from_millis(10),
                ..response.clone()
            })?;
        }
        Ok(())
    });
    match rated {
        Ok(()) => store.finish(true, Timestamp::now().to_string(), None),
        Err(None) => Ok(()),
        Err(Some(error)) => Err(error),
    }
}
