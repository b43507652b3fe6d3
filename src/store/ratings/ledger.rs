//! Which rows of result files count: of every trial the last attempt, and of a row that stands twice the first.
//!
//! Kept is one bit a trial, and more only of what is unusual: trials that were rated again, rows that stand twice, rows
//! whose name is not the one that sessions give.

use std::{
    collections::{HashMap, HashSet},
    hash::BuildHasher as _,
};

use hashbrown::{DefaultHashBuilder, HashTable, hash_table::Entry};

use super::{faults::Place, identity::Identity};

/// What is known of the rows of result files.
#[derive(Debug, Default)]
pub(super) struct Ledger {
    pub sessions: Vec<Session>,
    hasher: DefaultHashBuilder,
    index: HashTable<u32>,
    /// The session of the last row: the next one is most often of the same.
    recent: usize,
    /// Attempts after the first.
    later: HashSet<Key>,
    /// What stands twice, and where it stands first.
    repeated: HashMap<Key, Option<Place>>,
    /// Hashes of names of rows that are not the usual ones, and where such a name stands first.
    unusual: HashMap<u64, Option<Place>>,
}

/// A row's identity.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct Key {
    session: u32,
    main: bool,
    trial: u32,
    attempt: u32,
}

/// A session's trials.
#[derive(Debug)]
pub(super) struct Session {
    pub subject: Box<str>,
    pub session: Box<str>,
    /// Index of the file in which it was met first.
    pub file: usize,
    /// Whether dropped frames were measured.
    pub measured: bool,
    /// Main trials with a first attempt, and of these the ones whose rating does not count, and with dropped frames.
    main: Bits,
    unrated: Bits,
    dropped: Bits,
    /// Practice trials with a first attempt.
    practice: Bits,
    /// Main trials with later attempts: the last of them.
    last: HashMap<u32, Last>,
}

/// The last attempt of a trial.
#[derive(Clone, Copy, Debug)]
struct Last {
    attempt: u32,
    rated: bool,
    dropped: bool,
}

/// What a row says beside its identity.
#[derive(Clone, Copy, Debug)]
pub(super) struct Said<'a> {
    /// Name of the row; empty where it has none.
    pub row_id: &'a str,
    /// Whether its rating counts.
    pub rated: bool,
    /// Whether frames were dropped, where it was measured.
    pub dropped: Option<bool>,
}

/// What becomes of a row.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Fate {
    /// It counts.
    Counts,
    /// A later attempt counts.
    Superseded,
    /// It stands elsewhere already.
    Repeated(Place),
}

impl Ledger {
    /// One whose hashes are those of another.
    pub fn like(other: &Self) -> Self {
        Self { hasher: other.hasher.clone(), ..Self::default() }
    }

    fn hash(&self, subject: &str, session: &str) -> u64 {
        self.hasher.hash_one((subject, session))
    }

    /// Index of a session that has rows.
    pub fn find(&self, subject: &str, session: &str) -> Option<usize> {
        let is = |&index: &u32| self.sessions[index as usize].is(subject, session);
        self.index.find(self.hash(subject, session), is).map(|index| *index as usize)
    }

    /// Index of a session, a new one if need be.
    fn enter(&mut self, subject: &str, session: &str, file: usize) -> usize {
        if self.sessions.get(self.recent).is_some_and(|known| known.is(subject, session)) {
            return self.recent;
        }
        let hash = self.hash(subject, session);
        let Self { sessions, hasher, index, .. } = self;
        let is = |index: &u32| sessions[*index as usize].is(subject, session);
        let rehash = |index: &u32| {
            let known = &sessions[*index as usize];
            hasher.hash_one((&*known.subject, &*known.session))
        };
        self.recent = match index.entry(hash, is, rehash) {
            Entry::Occupied(entry) => *entry.get() as usize,
            Entry::Vacant(entry) => {
                entry.insert(sessions.len() as u32);
                sessions.push(Session::new(subject, session, file));
                sessions.len() - 1
            }
        };
        self.recent
    }

    /// Notes a row.
    pub fn note(&mut self, row: &Identity<'_>, said: &Said<'_>, file: usize) {
        let number = self.enter(row.subject, row.session, file);
        if !said.row_id.is_empty() && !row.is_named(said.row_id) {
            self.unusual.insert(self.hasher.hash_one(said.row_id), None);
        }
        let key = Key { session: number as u32, main: row.main, trial: row.trial, attempt: row.attempt };
        let session = &mut self.sessions[number];
        let known = match (row.attempt, row.main) {
            (1, true) => session.main.set(row.trial),
            (1, false) => session.practice.set(row.trial),
            _ => !self.later.insert(key),
        };
        if known {
            // The first counts, so what this one says does not matter.
            self.repeated.insert(key, None);
        } else if row.main {
            session.measured |= said.dropped.is_some();
            let dropped = said.dropped.unwrap_or(false);
            if row.attempt > 1 {
                session.note_last(row.trial, Last { attempt: row.attempt, rated: said.rated, dropped });
            } else {
                session.note_first(row.trial, said.rated, dropped);
            }
        }
    }

    /// Takes over what was noted of later rows.
    pub fn absorb(&mut self, later: Self) {
        let mut numbers = Vec::with_capacity(later.sessions.len());
        for from in later.sessions {
            let number = self.enter(&from.subject, &from.session, from.file);
            numbers.push(number as u32);
            let key = |main, trial| Key { session: number as u32, main, trial, attempt: 1 };
            let session = &mut self.sessions[number];
            let twice_main = session.main.both(&from.main).map(|trial| key(true, trial));
            let twice_practice = session.practice.both(&from.practice).map(|trial| key(false, trial));
            self.repeated.extend(twice_main.chain(twice_practice).map(|key| (key, None)));
            session.absorb(from);
        }
        let moved = |key: Key| Key { session: numbers[key.session as usize], ..key };
        for key in later.later.into_iter().map(moved) {
            if !self.later.insert(key) {
                self.repeated.insert(key, None);
            }
        }
        self.repeated.extend(later.repeated.into_keys().map(|key| (moved(key), None)));
        self.unusual.extend(later.unusual);
    }

    /// Whether rows may stand twice, so that it must be found out where they stand first.
    pub fn has_doubts(&self) -> bool {
        !self.repeated.is_empty() || !self.unusual.is_empty()
    }

    /// The doubts that a row settles if it is the first of its kind.
    fn doubts(&self, row: &Identity<'_>, row_id: &str) -> [Option<Doubt>; 2] {
        if !self.has_doubts() {
            return [None; 2];
        }
        let key = (self.find(row.subject, row.session))
            .map(|session| Key { session: session as u32, main: row.main, trial: row.trial, attempt: row.attempt })
            .filter(|key| self.repeated.contains_key(key));
        let name = Some(self.hasher.hash_one(row_id)).filter(|hash| self.unusual.contains_key(hash));
        [key.map(Doubt::Key), name.map(Doubt::Name)]
    }

    /// Notes where a row stands, for [`Ledger::settle`].
    pub fn place(&self, row: &Identity<'_>, row_id: &str, place: Place, firsts: &mut HashMap<Doubt, Place>) {
        for doubt in self.doubts(row, row_id).into_iter().flatten() {
            let first = firsts.entry(doubt).or_insert(place);
            *first = place.min(*first);
        }
    }

    /// Takes over where rows stand first.
    pub fn settle(&mut self, firsts: HashMap<Doubt, Place>) {
        for (doubt, place) in firsts {
            let known = match doubt {
                Doubt::Key(key) => self.repeated.entry(key).or_default(),
                Doubt::Name(hash) => self.unusual.entry(hash).or_default(),
            };
            *known = Some(known.map_or(place, |known| known.min(place)));
        }
    }

    /// What becomes of a row.
    pub fn fate(&self, row: &Identity<'_>, row_id: &str, place: Place) -> Fate {
        for doubt in self.doubts(row, row_id).into_iter().flatten() {
            let first = match doubt {
                Doubt::Key(key) => self.repeated.get(&key),
                Doubt::Name(hash) => self.unusual.get(&hash),
            };
            if let Some(first) = first.copied().flatten().filter(|first| *first != place) {
                return Fate::Repeated(first);
            }
        }
        let superseded = row.main
            && !self.later.is_empty()
            && (self.find(row.subject, row.session))
                .and_then(|session| self.sessions[session].last.get(&row.trial))
                .is_some_and(|last| last.attempt > row.attempt);
        if superseded { Fate::Superseded } else { Fate::Counts }
    }
}

/// What may stand twice.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Doubt {
    Key(Key),
    Name(u64),
}

impl Session {
    fn new(subject: &str, session: &str, file: usize) -> Self {
        Self {
            subject: subject.into(),
            session: session.into(),
            file,
            measured: false,
            main: Bits::default(),
            unrated: Bits::default(),
            dropped: Bits::default(),
            practice: Bits::default(),
            last: HashMap::new(),
        }
    }

    fn is(&self, subject: &str, session: &str) -> bool {
        &*self.subject == subject && &*self.session == session
    }

    fn note_first(&mut self, trial: u32, rated: bool, dropped: bool) {
        if !rated {
            self.unrated.set(trial);
        }
        if dropped {
            self.dropped.set(trial);
        }
    }

    fn note_last(&mut self, trial: u32, last: Last) {
        let known = self.last.entry(trial).or_insert(last);
        if last.attempt > known.attempt {
            *known = last;
        }
    }

    fn absorb(&mut self, later: Self) {
        self.measured |= later.measured;
        // Of trials that stand twice the first row counts.
        self.unrated.add(&later.unrated, &self.main);
        self.dropped.add(&later.dropped, &self.main);
        self.main.add(&later.main, &Bits::default());
        self.practice.add(&later.practice, &Bits::default());
        for (trial, last) in later.last {
            self.note_last(trial, last);
        }
    }

    /// Main trials whose last attempt is rated.
    pub fn rated(&self) -> u64 {
        let first = self.main.count() - self.unrated.count();
        let undone = self.last.keys().filter(|&&trial| self.main.get(trial) && !self.unrated.get(trial)).count();
        let done = self.last.values().filter(|last| last.rated).count();
        first - undone as u64 + done as u64
    }

    /// Main trials in whose last attempt a frame was dropped.
    pub fn dropped(&self) -> u64 {
        let undone = self.last.keys().filter(|&&trial| self.dropped.get(trial)).count();
        let done = self.last.values().filter(|last| last.dropped).count();
        self.dropped.count() - undone as u64 + done as u64
    }
}

/// A set of trials.
#[derive(Clone, Debug, Default)]
struct Bits(Vec<u64>);

impl Bits {
    /// Puts a trial in; gives whether it was in.
    fn set(&mut self, trial: u32) -> bool {
        let (word, bit) = (trial as usize / 64, 1 << (trial % 64));
        if self.0.len() <= word {
            self.0.resize(word + 1, 0);
        }
        let was = self.0[word] & bit != 0;
        self.0[word] |= bit;
        was
    }

    fn get(&self, trial: u32) -> bool {
        self.0.get(trial as usize / 64).is_some_and(|word| word >> (trial % 64) & 1 == 1)
    }

    fn count(&self) -> u64 {
        self.0.iter().map(|word| u64::from(word.count_ones())).sum()
    }

    /// Puts in what another set has beyond a third.
    fn add(&mut self, other: &Self, without: &Self) {
        if self.0.len() < other.0.len() {
            self.0.resize(other.0.len(), 0);
        }
        for (i, word) in other.0.iter().enumerate() {
            self.0[i] |= word & !without.0.get(i).copied().unwrap_or(0);
        }
    }

    /// What is in both.
    fn both(&self, other: &Self) -> impl Iterator<Item = u32> {
        let words = self.0.iter().zip(&other.0).map(|(a, b)| a & b).collect::<Vec<_>>();
        (0_u32..)
            .zip(words)
            .flat_map(|(i, word)| (0..64).filter(move |bit| word >> bit & 1 == 1).map(move |bit| i * 64 + bit))
    }
}
