//! How to read ratings, and what was read.

use std::path::PathBuf;

use crate::{
    experiment::Protocol,
    store::{FileFault, sidecar::Sidecar},
};

/// How to read files.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ReadOptions {
    /// Column with the participant ID; `subject_id` by default.
    pub subject: Option<String>,
    /// Column with the response; by default `rating`, on the scale 0…3.
    pub response: Option<String>,
    /// The categories of a given response column, lowest first, if they are known.
    pub categories: Option<Vec<String>>,
    /// Column with the number of trials per row; by default `count`, if present.
    pub count: Option<String>,
    /// Columns with the factors. `None` means those of the definition; for a table of counts, all other columns; for result
    /// files without a sidecar, all columns of stimulus parameters.
    pub factors: Option<Vec<String>>,
    /// Additional columns to read as factors, such as those of a model's terms. A column that no file has is ignored, except
    /// that `inv_n` then means `depth`.
    pub also: Vec<String>,
    /// Excludes sessions with unrated trials.
    pub complete_only: bool,
    /// Whether session, repetition and response time of each row are also read.
    pub details: bool,
}

impl ReadOptions {
    /// Name of the participant's column.
    pub(super) fn subject(&self) -> &str {
        self.subject.as_deref().unwrap_or("subject_id")
    }

    /// Name of the response's column.
    pub(super) fn response(&self) -> &str {
        self.response.as_deref().unwrap_or("rating")
    }

    /// Name of the count's column.
    pub(super) fn count(&self) -> &str {
        self.count.as_deref().unwrap_or("count")
    }
}

/// What is known of the ratings before the first row.
#[derive(Clone, Debug, PartialEq)]
pub struct Shape {
    /// Names of the factors, in the order of [`RatingRow::values`](crate::experiment::RatingRow::values).
    pub factors: Vec<String>,
    /// Name of the subject's column.
    pub subject: String,
    /// Name of the response's column.
    pub response: String,
    /// The ordered categories, if known: `0`…`3` for our own files.
    pub categories: Option<Vec<String>>,
    /// Whether the factors were neither given nor defined, so that those with a single level carry no information.
    pub guessed: bool,
}

/// What was read and what was excluded.
#[derive(Clone, Debug)]
pub struct Source {
    /// Factors and categories.
    pub shape: Shape,
    /// The definition in the sidecars.
    pub protocol: Option<Protocol>,
    /// Its hash.
    pub definition_sha256: Option<String>,
    /// Every file, in the order it was read.
    pub files: Vec<FileRead>,
    /// Every session of result files, by subject and session.
    pub sessions: Vec<SessionRead>,
    /// All faults, in the order of the files; of many similar faults in one file, the first ones and a final one with the
    /// number of others.
    pub faults: Vec<FileFault>,
}

/// What a file is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Layout {
    /// One row per trial, in the columns of a session's file.
    Results,
    /// Counts of ratings.
    Counts,
    /// One row per rating, in the given columns.
    #[default]
    Long,
}

/// A file and how its rows were used.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FileRead {
    pub path: PathBuf,
    /// What it is.
    pub layout: Layout,
    /// Rows below the header.
    pub rows: u64,
    /// Rows that count.
    pub counted: u64,
    /// Number of trials in these rows.
    pub ratings: u64,
    /// Practice rows, excluded.
    pub practice: u64,
    /// Corrected ratings: rows with a later attempt, excluded.
    pub superseded: u64,
    /// Rows with a fault, excluded.
    pub faulty: u64,
    /// Rows of unfinished sessions, excluded by [`ReadOptions::complete_only`].
    pub unfinished: u64,
    /// SHA-256 of the content, so that the analysis can be repeated on exactly this file; `None` above 64 MiB.
    pub sha256: Option<String>,
}

/// A session that was found in result files.
#[derive(Clone, Debug)]
pub struct SessionRead {
    /// Participant.
    pub subject: String,
    pub session: String,
    /// File.
    pub path: PathBuf,
    /// Number of planned main trials, if a sidecar has the definition.
    pub planned: Option<u64>,
    /// Main trials that are rated.
    pub rated: u64,
    /// Main trials with a dropped frame; `None` if nothing was measured.
    pub dropped: Option<u64>,
    pub sidecar: Option<Sidecar>,
}

impl SessionRead {
    /// Whether planned trials are unrated, as far as is known.
    pub fn is_unfinished(&self) -> bool {
        self.planned.is_some_and(|planned| self.rated < planned)
    }
}
