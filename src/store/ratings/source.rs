//! The description of what was read.

use std::{
    collections::{BTreeMap, BTreeSet, HashMap},
    path::PathBuf,
    sync::{Arc, Mutex, PoisonError},
};

use serde_json::Value;

use crate::{
    experiment::Protocol,
    stimulus::{MachBand, Parameter},
    store::{FileError, FileErrors, definition, sidecar::Sidecar},
    text::names::named,
};

/// The shortest and the longest response time of rows that count, in seconds, if there is a limit.
pub type TimeLimits = (Option<f64>, Option<f64>);

/// What is known about the ratings before the first row is read.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Shape {
    /// Names of the factors, in the order of [`RatingRow::values`](crate::experiment::RatingRow::values).
    pub factors: Vec<String>,
    /// The factors that are directions.
    pub directions: Vec<String>,
    /// Factors, each with the order of its levels.
    pub levels: Vec<(String, Vec<String>)>,
    /// Name of the column with the participant ID.
    pub subject: String,
    /// Name of the column with the response.
    pub response: String,
    /// The ordered categories, if known: `0`…`3` for our own files.
    pub categories: Option<Vec<String>>,
    /// True if the factors were neither given nor defined, so that factors with a single level carry no information.
    pub guessed: bool,
    /// The limits of response times that were applied.
    pub time_limits: TimeLimits,
}

/// What was read and what was excluded.
#[derive(Clone, Debug)]
pub struct Source {
    /// Factors and categories.
    pub shape: Shape,
    /// The definition in the sidecars.
    pub protocol: Option<Protocol>,
    /// Hash of that definition.
    pub definition_sha256: Option<String>,
    /// Every file, in the order it was read.
    pub files: Vec<FileRead>,
    /// Every session in result files, sorted by participant and session.
    pub sessions: Vec<SessionRead>,
    /// All errors, in the order of the files. If a file has many similar errors, only the first ones are listed,
    /// followed by the number of others.
    pub errors: Vec<FileError>,
    /// Warnings about files that were read anyway: files that were changed after their session ended, sessions without
    /// a sidecar, tables of counts, missing responses, IDs that look alike, and what was converted or guessed.
    pub warnings: Vec<FileError>,
}

impl Source {
    /// Returns the parameters of the stimulus that was rated; `None` for a table from elsewhere. Without a definition, result
    /// files have the columns of a Mach band.
    pub fn parameters(&self) -> Option<&'static [Parameter]> {
        let known = self.protocol.as_ref().map(|protocol| protocol.stimulus.parameters());
        known.or((!self.sessions.is_empty()).then_some(MachBand::PARAMETERS))
    }

    /// Returns how many rows were left out for a reason, and how many participants have such rows.
    pub fn left_out(&self, reason: Reason) -> (u64, usize) {
        let of_reason = || self.files.iter().filter_map(|file| file.left_out.get(&reason)).flatten();
        let ids = of_reason().map(|(id, _)| id).filter(|id| !id.is_empty());
        (of_reason().map(|(_, rows)| rows).sum(), ids.collect::<BTreeSet<_>>().len())
    }
}

named! {
    /// Why rows of main trials do not count although they can be read.
    #[derive(PartialOrd, Ord)]
    Reason, UnknownReason {
        /// There is no response.
        NoResponse = "without a response",
        /// There is no participant.
        NoParticipant = "without a participant",
        /// The answer came before the lower limit of [`ReadOptions::min_time`](super::ReadOptions::min_time).
        TooFast = "answered too fast",
        /// The answer came after the upper limit.
        TooSlow = "answered too slowly",
        /// The session is unfinished, and [`ReadOptions::complete_only`](super::ReadOptions::complete_only) is true.
        Unfinished = "from unfinished sessions",
    }
}

/// The layout of a file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Layout {
    /// One row per trial, with the columns of a session's file.
    Results,
    /// Counts of ratings.
    Counts,
    /// One row per rating, with columns given in the options.
    #[default]
    Long,
}

/// A file and how its rows were used.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FileRead {
    pub path: PathBuf,
    /// The file's layout.
    pub layout: Layout,
    /// Rows below the header; in a wide table, there is a row for each of the columns.
    pub rows: u64,
    /// Rows that count.
    pub counted: u64,
    /// Number of trials in these rows.
    pub ratings: u64,
    /// Excluded practice rows.
    pub practice: u64,
    /// Excluded rows of corrected ratings, which have a later attempt.
    pub superseded: u64,
    /// Excluded rows with errors.
    pub erroneous: u64,
    /// Those among them that can be read but appear twice.
    pub repeated: u64,
    /// Other rows that do not count: for each reason, their number by participant.
    pub left_out: BTreeMap<Reason, BTreeMap<String, u64>>,
    /// The rows without a participant in a table in memory, counted from 0.
    pub nobodys: Vec<usize>,
    /// For each participant whose ratings are partly or all marked as simulated in the file, which then needs no sidecar: how
    /// many are, and how many there are.
    pub simulated: BTreeMap<String, [u64; 2]>,
    /// For each factor, the number of ratings that have no value of it.
    pub without_level: Vec<u64>,
    /// Number of ratings without a response time.
    pub without_time: u64,
    /// SHA-256 of the content, so that the analysis can be repeated with exactly this file; `None` for a file above 64
    /// MiB.
    pub sha256: Option<String>,
}

/// A session that was found in result files.
#[derive(Clone, Debug)]
pub struct SessionRead {
    /// Participant ID.
    pub subject: String,
    pub session: String,
    /// Path of the result file.
    pub path: PathBuf,
    /// Number of planned main trials, if a sidecar has the definition.
    pub planned: Option<u64>,
    /// Number of rated main trials.
    pub rated: u64,
    /// Number of main trials without a row, before the last one that has a row.
    pub skipped: u64,
    /// Number of main trials with a dropped frame; `None` if nothing was measured.
    pub dropped: Option<u64>,
    /// The sidecar, without its definition, its columns and the hashes of its pictures.
    pub sidecar: Option<Arc<Sidecar>>,
}

impl SessionRead {
    /// True if some planned trials are known to be unrated.
    pub fn is_unfinished(&self) -> bool {
        self.planned.is_some_and(|planned| self.rated < planned)
    }
}

/// The definitions of all sessions. Sessions with the same definition share it, because there may be thousands of
/// sessions.
#[derive(Debug, Default)]
pub(super) struct Definitions(Mutex<HashMap<String, (Arc<Protocol>, String)>>);

impl Definitions {
    /// Returns the definition in a sidecar, and its hash.
    pub fn protocol(&self, file: &str, definition: &Value) -> Result<(Arc<Protocol>, String), FileErrors> {
        let key = definition.to_string();
        let known = || self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(found) = known().get(&key) {
            return Ok(found.clone());
        }
        let found = definition::from_json(file, definition)?;
        let hash = definition::hash(&found);
        let found = (Arc::new(found), hash);
        known().insert(key, found.clone());
        Ok(found)
    }
}
