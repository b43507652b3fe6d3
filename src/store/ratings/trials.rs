//! Which rows of result files count: of every trial the last attempt, and of a row that stands twice the first.
//!
//! A trial is eight bytes: session by session they are sorted once all files have been gone through.

use std::collections::HashMap;

use crate::experiment::Phase;

/// Phase, number and attempt of a trial, in this order from the highest bit; below them what else the row says.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(super) struct Trial(u64);

const MAIN: u64 = 1 << 63;
const NUMBER: u32 = 32;
const ATTEMPT: u32 = 3;
/// The row has another identity: only its name says this one.
const BY_NAME: u64 = 4;
const RATED: u64 = 2;
const DROPPED: u64 = 1;

impl Trial {
    /// The trial of this number and attempt, both from 1 to a million.
    pub fn new(phase: Phase, number: u32, attempt: u32) -> Self {
        let main = if phase == Phase::Main { MAIN } else { 0 };
        Self(main | u64::from(number) << NUMBER | u64::from(attempt) << ATTEMPT)
    }

    /// Whether it is a main trial.
    pub fn is_main(self) -> bool {
        self.0 & MAIN != 0
    }

    /// Phase, number and attempt alone.
    fn key(self) -> u64 {
        self.0 >> ATTEMPT
    }

    /// Whether both are attempts of one trial.
    fn is_attempt_of(self, other: Self) -> bool {
        self.0 >> NUMBER == other.0 >> NUMBER
    }

    fn has(self, flag: u64) -> bool {
        self.0 & flag != 0
    }
}

/// Which trial a row of a result file records.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Identity<'a> {
    pub subject: &'a str,
    pub session: &'a str,
    pub trial: Trial,
}

impl<'a> Identity<'a> {
    /// By the name of the row; none where it is not made of participant, session, phase, trial and attempt.
    pub fn named(row_id: &'a str) -> Option<Self> {
        let mut parts = row_id.split('_');
        let mut next = || parts.next();
        let (subject, session, phase) = (next()?, next()?, next()?.parse().ok()?);
        let trial = Trial::new(phase, number(next()?)?, number(next()?)?);
        next().is_none().then_some(Self { subject, session, trial })
    }
}

/// A whole number of digits only, from 1 to a million. A session has at most 100,000 trials.
pub(super) fn number(text: &str) -> Option<u32> {
    let digits = text.len() < 10 && text.bytes().all(|byte| byte.is_ascii_digit());
    text.parse().ok().filter(|number| digits && (1..=1_000_000).contains(number))
}

/// What a row says beside its identity.
#[derive(Clone, Copy, Debug)]
pub(super) struct Noted {
    /// Whether its rating counts.
    pub rated: bool,
    /// Whether frames were dropped, where it was measured.
    pub dropped: Option<bool>,
}

/// What becomes of a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Status {
    /// It counts.
    Counts,
    /// A later attempt counts.
    Superseded,
    /// It stands in this file already.
    Repeated(usize),
}

/// The trials of result files.
#[derive(Debug, Default)]
pub(super) struct Trials {
    pub sessions: Vec<Session>,
    index: HashMap<Box<[u8]>, usize>,
    /// The session of the last row: the next one is most often of the same.
    recent: usize,
    key: Vec<u8>,
}

/// The trials of a session.
#[derive(Debug)]
pub(super) struct Session {
    pub subject: Box<str>,
    pub session: Box<str>,
    /// Whether dropped frames were measured.
    measured: bool,
    /// The trials of each file, by its index; sorted when all files have been gone through.
    files: Vec<(usize, Vec<Trial>)>,
    /// The last attempt of every main trial, where a trial is in several files or has several attempts.
    last: Option<Vec<Trial>>,
}

impl Trials {
    /// Index of a session that has rows; `recent` is that of the row before, most often the same.
    pub fn find(&self, subject: &str, session: &str, recent: usize) -> Option<usize> {
        if self.sessions.get(recent).is_some_and(|known| known.is(subject, session)) {
            return Some(recent);
        }
        self.index.get(&session_key(subject, session, Vec::new())[..]).copied()
    }

    /// The trials of a session, in one file; both are new if need be.
    fn enter(&mut self, subject: &str, session: &str, file: usize) -> &mut Session {
        if !self.sessions.get(self.recent).is_some_and(|known| known.is(subject, session)) {
            self.key = session_key(subject, session, std::mem::take(&mut self.key));
            self.recent = self.index.get(&self.key[..]).copied().unwrap_or_else(|| {
                self.index.insert(self.key.as_slice().into(), self.sessions.len());
                let (subject, session) = (subject.into(), session.into());
                self.sessions.push(Session { subject, session, measured: false, files: Vec::new(), last: None });
                self.sessions.len() - 1
            });
        }
        let session = &mut self.sessions[self.recent];
        if session.files.last().is_none_or(|(known, _)| *known != file) {
            session.files.push((file, Vec::new()));
        }
        session
    }

    /// Notes a row; `row_id` is its name, empty where it has none.
    pub fn note(&mut self, row: &Identity<'_>, row_id: &str, noted: Noted, file: usize) {
        let flags = if noted.rated { RATED } else { 0 } | if noted.dropped == Some(true) { DROPPED } else { 0 };
        let session = self.enter(row.subject, row.session, file);
        session.measured |= noted.dropped.is_some() && row.trial.is_main();
        session.push(Trial(row.trial.0 | flags));
        // A row may have been copied and its participant's name changed: it is the same row all the same.
        if let Some(named) = Identity::named(row_id).filter(|named| named != row) {
            self.enter(named.subject, named.session, file).push(Trial(named.trial.0 | BY_NAME));
        }
    }

    /// Takes over what was noted of later files.
    pub fn absorb(&mut self, later: Self) {
        for from in later.sessions {
            for (file, trials) in from.files {
                let session = self.enter(&from.subject, &from.session, file);
                session.measured |= from.measured;
                session.files.last_mut().into_iter().for_each(|(_, known)| known.extend_from_slice(&trials));
            }
        }
    }

    /// All rows are noted.
    pub fn finish(&mut self) {
        self.sessions.iter_mut().for_each(Session::finish);
    }
}

/// Participant and session as one key; a text of a CSV file in UTF-8 does not have the byte between them.
fn session_key(subject: &str, session: &str, mut key: Vec<u8>) -> Vec<u8> {
    key.clear();
    key.extend_from_slice(subject.as_bytes());
    key.push(0xff);
    key.extend_from_slice(session.as_bytes());
    key
}

impl Session {
    fn is(&self, subject: &str, session: &str) -> bool {
        &*self.subject == subject && &*self.session == session
    }

    fn push(&mut self, trial: Trial) {
        if let Some((_, trials)) = self.files.last_mut() {
            trials.push(trial);
        }
    }

    fn finish(&mut self) {
        for (_, trials) in &mut self.files {
            // Stable: of equal ones the first in the file is the first here.
            trials.sort_by_key(|trial| trial.key());
        }
        let single = self.files.len() == 1
            && self.files[0].1.windows(2).all(|pair| !pair[0].is_attempt_of(pair[1]))
            && !self.files[0].1.iter().any(|trial| trial.has(BY_NAME));
        if single {
            return;
        }
        let mut last: Vec<Trial> = self.files.iter().flat_map(|(_, trials)| trials).copied().collect();
        last.sort_by_key(|trial| trial.key());
        last.dedup_by_key(|trial| trial.key());
        last.retain(|trial| trial.is_main() && !trial.has(BY_NAME));
        // The last attempt is the last of its trial here.
        last.reverse();
        last.dedup_by(|earlier, later| earlier.is_attempt_of(*later));
        last.reverse();
        self.last = Some(last);
    }

    /// Index of the first file with one of its rows; none where rows are only named after it.
    pub fn file(&self) -> Option<usize> {
        self.files.iter().find(|(_, trials)| trials.iter().any(|trial| !trial.has(BY_NAME))).map(|(file, _)| *file)
    }

    /// Main trials whose last attempt says this.
    fn count(&self, flag: u64) -> u64 {
        let trials = self.last.as_ref().unwrap_or(&self.files[0].1);
        trials.iter().filter(|trial| trial.is_main() && trial.has(flag)).count() as u64
    }

    /// Main trials whose last attempt is rated.
    pub fn rated(&self) -> u64 {
        self.count(RATED)
    }

    /// Main trials in whose last attempt a frame was dropped; none where nothing was measured.
    pub fn dropped(&self) -> Option<u64> {
        self.measured.then(|| self.count(DROPPED))
    }

    /// What becomes of a row. `is_new` notes a trial that stands in the file twice, and gives whether it was not met
    /// before.
    pub fn status(&self, trial: Trial, file: usize, is_new: impl FnOnce(Trial) -> bool) -> Status {
        let Some(last) = &self.last else { return Status::Counts };
        for (other, trials) in &self.files {
            let first = trials.partition_point(|known| known.key() < trial.key());
            let same = trials[first..].iter().take_while(|known| known.key() == trial.key()).count();
            if *other == file {
                if same > 1 && !is_new(trial) {
                    return Status::Repeated(file);
                }
                break;
            }
            if same > 0 {
                return Status::Repeated(*other);
            }
        }
        let place = last.partition_point(|known| known.key() < trial.key());
        match last.get(place) {
            Some(found) if trial.is_main() && found.key() != trial.key() && found.is_attempt_of(trial) => {
                Status::Superseded
            }
            _ => Status::Counts,
        }
    }
}
