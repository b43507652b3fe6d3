//! Determines which rows of result files count: the last attempt at each trial, and the first of duplicate rows.
//!
//! Each row takes eight bytes here. The rows of each session are sorted after all files have been read.

use std::collections::HashMap;

use crate::experiment::Phase;

/// An attempt at a trial. From the highest bit down, it holds the phase, the number, the attempt, and flags from its
/// row.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Trial(u64);

const MAIN: u64 = 1 << 63;
const NUMBER: u32 = 32;
const ATTEMPT: u32 = 2;
const RATED: u64 = 2;
const DROPPED: u64 = 1;

impl Trial {
    /// Creates an attempt at the trial with this number; number and attempt are both from 1 to a million.
    pub fn new(phase: Phase, number: u32, attempt: u32) -> Self {
        let main = if phase == Phase::Main { MAIN } else { 0 };
        Self(main | u64::from(number) << NUMBER | u64::from(attempt) << ATTEMPT)
    }

    /// True for a main trial.
    pub fn is_main(self) -> bool {
        self.0 & MAIN != 0
    }

    /// Returns the phase, number and attempt, without the flags.
    fn key(self) -> u64 {
        self.0 >> ATTEMPT
    }

    /// True if both are attempts at the same trial.
    fn is_attempt_of(self, other: Self) -> bool {
        self.0 >> NUMBER == other.0 >> NUMBER
    }
}

/// The trial that a row of a result file records.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Identity<'a> {
    pub subject: &'a str,
    pub session: &'a str,
    pub trial: Trial,
}

/// How a row is used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Status {
    Counts,
    /// A later attempt counts.
    Superseded,
    /// The row also occurs in the file with this index, and that one counts.
    Repeated(usize),
}

/// The trials of result files.
#[derive(Debug, Default)]
pub(super) struct Trials {
    pub sessions: Vec<Session>,
    index: HashMap<(String, String), usize>,
    /// The session of the previous row, because the next row usually belongs to the same session.
    recent: usize,
}

/// The trials of a session.
#[derive(Debug)]
pub(super) struct Session {
    pub subject: String,
    pub session: String,
    /// True if dropped frames were measured.
    measured: bool,
    /// The trials in each file, with the file's index. They are sorted after all files have been read.
    files: Vec<(usize, Vec<Trial>)>,
}

impl Trials {
    /// Returns the index of a session. `recent` is the index for the previous row, which is usually the same.
    pub fn find(&self, subject: &str, session: &str, recent: usize) -> Option<usize> {
        if self.sessions.get(recent).is_some_and(|known| known.subject == subject && known.session == session) {
            return Some(recent);
        }
        self.index.get(&(subject.to_owned(), session.to_owned())).copied()
    }

    /// Returns a session with `file` as its last file. Creates the session and the file's entry if necessary.
    fn enter(&mut self, subject: &str, session: &str, file: usize) -> &mut Session {
        self.recent = self.find(subject, session, self.recent).unwrap_or_else(|| {
            let (subject, session) = (subject.to_owned(), session.to_owned());
            self.index.insert((subject.clone(), session.clone()), self.sessions.len());
            self.sessions.push(Session { subject, session, measured: false, files: Vec::new() });
            self.sessions.len() - 1
        });
        let session = &mut self.sessions[self.recent];
        if session.files.last().is_none_or(|(known, _)| *known != file) {
            session.files.push((file, Vec::new()));
        }
        session
    }

    /// Adds a row, with whether it is rated, and whether frames were dropped (`None` if this was not measured).
    pub fn add(&mut self, row: &Identity<'_>, rated: bool, dropped: Option<bool>, file: usize) {
        let flags = if rated { RATED } else { 0 } | if dropped == Some(true) { DROPPED } else { 0 };
        let session = self.enter(row.subject, row.session, file);
        session.measured |= dropped.is_some() && row.trial.is_main();
        session.files.last_mut().into_iter().for_each(|(_, trials)| trials.push(Trial(row.trial.0 | flags)));
    }

    /// Adds the rows of later files.
    pub fn absorb(&mut self, later: Self) {
        for from in later.sessions {
            for (file, trials) in from.files {
                let session = self.enter(&from.subject, &from.session, file);
                session.measured |= from.measured;
                session.files.last_mut().into_iter().for_each(|(_, known)| known.extend_from_slice(&trials));
            }
        }
    }

    /// Sorts the rows. Must be called after all rows have been added.
    pub fn finish(&mut self) {
        for (_, trials) in self.sessions.iter_mut().flat_map(|session| &mut session.files) {
            // The sort is stable, so that the first of several equal rows in a file stays first.
            trials.sort_by_key(|trial| trial.key());
        }
    }
}

impl Session {
    /// Returns the index of the first file that has rows of this session.
    pub fn file(&self) -> usize {
        self.files[0].0
    }

    /// Counts the main trials whose last attempt has a flag.
    fn count(&self, flag: u64) -> u64 {
        let mut trials: Vec<Trial> = self.files.iter().flat_map(|(_, trials)| trials).copied().collect();
        trials.sort_by_key(|trial| trial.key());
        trials.dedup_by_key(|trial| trial.key());
        let last = trials.chunk_by(|a, b| a.is_attempt_of(*b)).filter_map(<[Trial]>::last);
        last.filter(|trial| trial.is_main() && trial.0 & flag != 0).count() as u64
    }

    /// Counts the main trials whose last attempt is rated.
    pub fn rated(&self) -> u64 {
        self.count(RATED)
    }

    /// Counts the main trials with a dropped frame in their last attempt; `None` if nothing was measured.
    pub fn dropped(&self) -> Option<u64> {
        self.measured.then(|| self.count(DROPPED))
    }

    /// Determines how a row is used. `is_new` is called with a trial that occurs twice in the file, and returns whether
    /// this is its first row.
    pub fn status(&self, trial: Trial, file: usize, mut is_new: impl FnMut(Trial) -> bool) -> Status {
        let mut status = Status::Counts;
        for (other, trials) in &self.files {
            let first = trials.partition_point(|known| known.key() < trial.key());
            let same = trials[first..].iter().take_while(|known| known.key() == trial.key()).count();
            if *other < file && same > 0 {
                return Status::Repeated(*other);
            }
            if trials.get(first + same).is_some_and(|next| next.is_attempt_of(trial)) {
                status = Status::Superseded;
            }
            if *other == file && same > 1 && !is_new(trial) {
                return Status::Repeated(file);
            }
        }
        status
    }
}
