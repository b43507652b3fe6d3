//! Determines which rows of result files count: the last attempt at each trial, and the first of duplicate rows.

use super::{
    rows::{Rows, Status},
    source::SessionRead,
};

/// A row of a result file: an attempt at a trial. The order is that of the session.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Attempt {
    /// Index of the session.
    pub session: u32,
    pub is_main: bool,
    pub trial: u32,
    pub attempt: u32,
    /// Index of the file.
    pub file: u32,
    /// Index of the row in the file.
    pub row: u32,
    pub rated: bool,
    /// Whether frames were dropped; `None` if this was not measured.
    pub dropped: Option<bool>,
}

/// Sets how these rows are used, and counts the trials of the sessions.
pub(super) fn decide(mut attempts: Vec<Attempt>, sessions: &mut [SessionRead], files: &mut [Rows]) {
    for measured in attempts.iter().filter(|attempt| attempt.is_main && attempt.dropped.is_some()) {
        sessions[measured.session as usize].dropped = Some(0);
    }
    attempts.sort_unstable();
    let trial = |row: &Attempt| (row.session, row.is_main, row.trial);
    let mut furthest = (u32::MAX, 0);
    for same_trial in attempts.chunk_by(|a, b| trial(a) == trial(b)) {
        let last = same_trial.last().map(|row| row.attempt);
        let Attempt { session, is_main, trial, .. } = same_trial[0];
        if is_main {
            let before = if furthest.0 == session { furthest.1 } else { 0 };
            sessions[session as usize].skipped += u64::from(trial - before - 1);
            furthest = (session, trial);
        }
        for same in same_trial.chunk_by(|a, b| a.attempt == b.attempt) {
            let (first, session) = (same[0], &mut sessions[same[0].session as usize]);
            same[1..].iter().for_each(|row| set(files, row, Status::Repeated(first.file)));
            let mut set = |row: &Attempt, status| set(files, row, status);
            if !first.is_main {
                set(&first, Status::Practice);
            } else if Some(first.attempt) < last {
                set(&first, Status::Superseded);
            } else {
                set(&first, Status::Counts(first.session));
                session.rated += u64::from(first.rated);
                session.dropped = session.dropped.map(|n| n + u64::from(first.dropped == Some(true)));
            }
        }
    }
}

fn set(files: &mut [Rows], row: &Attempt, status: Status) {
    files[row.file as usize].status[row.row as usize] = status;
}
