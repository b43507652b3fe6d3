//! A small session on disk, rated by the simulated observer.

use std::{path::Path, time::Duration};

use jiff::Timestamp;
use machband::{
    experiment::{
        FrameCount, Identity, OrderedLogit, Protocol, RowContext, Schedule, Session, SessionOptions, TrialRecord,
        TrialResponse, simulate,
    },
    store::{
        StoreError,
        session::{Interrupted, SessionStore},
        sidecar::Sitting,
    },
};

/// Seed of every session.
pub const SEED: u64 = 7;

pub fn sitting() -> Sitting {
    Sitting { started_at: Timestamp::UNIX_EPOCH.to_string(), ..Sitting::default() }
}

pub fn create(results: &Path, protocol: &Protocol, identity: &Identity) -> Result<SessionStore, StoreError> {
    SessionStore::create(results, protocol, identity, SEED, sitting())
}

/// Rates up to `limit` of the trials that are left, and ends the session if none is. With `again` every fourth rating is
/// taken back and given anew.
pub fn rate(
    store: &mut SessionStore,
    (protocol, identity): (&Protocol, &Identity),
    found: Option<&Interrupted>,
    limit: usize,
    again: bool,
) -> Result<(), StoreError> {
    let schedule = Schedule::new(protocol, identity, SEED).unwrap();
    let resumed = found.map(|found| found.resumed.clone()).unwrap_or_default();
    let options = SessionOptions { pages: 0, frames: FrameCount::Off };
    let mut session = Session::new(protocol.clone(), schedule.clone(), &resumed, options);
    let sitting = found.map_or(1, |found| found.sitting);
    let start = Duration::from_secs_f64(found.map_or(0.0, |found| found.elapsed_s));
    let mut left = limit;
    let rated = simulate(&mut session, &OrderedLogit::default(), identity, start, |response| {
        left = left.checked_sub(1).ok_or(None)?;
        let context = RowContext { protocol, schedule: &schedule, identity, sitting };
        let mut append = |what: &TrialResponse| {
            store.append(&TrialRecord::new(&context, what, Timestamp::UNIX_EPOCH + what.onset)).map_err(Some)
        };
        append(response)?;
        if again && response.trial % 4 == 3 {
            append(&TrialResponse { attempt: 2, rating: 3 - response.rating, ..response.clone() })?;
        }
        Ok(())
    });
    match rated {
        Ok(()) => store.finish(true, Timestamp::now().to_string(), None),
        Err(None) => Ok(()),
        Err(Some(error)) => Err(error),
    }
}
