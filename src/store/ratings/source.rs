//! The options for reading ratings, and the description of what was read.

use std::{path::PathBuf, sync::Arc};

use crate::{
    experiment::Protocol,
    store::{FileError, sidecar::Sidecar},
};

/// Options for reading files.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ReadOptions {
    /// Column with the participant ID; `subject_id` by default.
    pub subject: Option<String>,
    /// Column with the response; by default `rating`, on the scale 0…3.
    pub response: Option<String>,
    /// The categories of the given response column, lowest first, if they are known.
    pub categories: Option<Vec<String>>,
    /// Column with the number of trials per row; by default `count`, if present.
    pub count: Option<String>,
    /// Columns with the factors. `None` means the factors of the definition; for a table of counts, all other columns;
    /// for result files without a sidecar, all columns with stimulus parameters. Measurements are left out of the last
    /// two.
    pub factors: Option<Vec<String>>,
    /// Additional columns to read as factors, such as the ones in a model's terms. A column that no file has is
    /// ignored, except that `inv_n` then means `depth`.
    pub also: Vec<String>,
    /// True if sessions with unrated trials are excluded.
    pub complete_only: bool,
    /// True if the session, repetition and response time of each row are also read.
    pub details: bool,
    /// Factors that are directions, in addition to stimulus parameters that are.
    pub direction: Vec<String>,
    /// Participants to leave out after reading.
    pub exclude: Vec<String>,
    /// Factors, each with the levels to keep after reading. `NA` stands for a missing value.
    pub only: Vec<(String, Vec<String>)>,
    /// True if the size of the study has no limit.
    pub large: bool,
}

impl ReadOptions {
    /// Returns the name of the column with the participant ID.
    pub(super) fn subject(&self) -> &str {
        self.subject.as_deref().unwrap_or("subject_id")
    }

    /// Returns the name of the column with the response.
    pub(super) fn response(&self) -> &str {
        self.response.as_deref().unwrap_or("rating")
    }

    /// Returns the name of the column with the count.
    pub(super) fn count(&self) -> &str {
        self.count.as_deref().unwrap_or("count")
    }
}

/// What is known about the ratings before the first row is read.
#[derive(Clone, Debug, PartialEq)]
pub struct Shape {
    /// Names of the factors, in the order of [`RatingRow::values`](crate::experiment::RatingRow::values).
    pub factors: Vec<String>,
    /// The factors that are directions.
    pub directions: Vec<String>,
    /// Name of the column with the participant ID.
    pub subject: String,
    /// Name of the column with the response.
    pub response: String,
    /// The ordered categories, if known: `0`…`3` for our own files.
    pub categories: Option<Vec<String>>,
    /// True if the factors were neither given nor defined, so that factors with a single level carry no information.
    pub guessed: bool,
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
    /// a sidecar, links that lead out of a data set, tables of counts, and columns that are measurements.
    pub warnings: Vec<FileError>,
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
    /// Rows below the header.
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
    /// Rows of unfinished sessions, excluded by [`ReadOptions::complete_only`].
    pub unfinished: u64,
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
