//! How ratings are to be read, and what was read.

use std::path::PathBuf;

use crate::{
    experiment::Protocol,
    store::{FileFault, sidecar::Sidecar},
};

/// How files are to be read.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ReadOptions {
    /// Column of the subject; `subject_id` unless named.
    pub subject: Option<String>,
    /// Column of the response; `rating` unless named. The scale is 0…3 unless the column is named.
    pub response: Option<String>,
    /// The response's categories, the lowest first, where it is named and they are known.
    pub categories: Option<Vec<String>>,
    /// Column with the number of trials that a row represents; `count` if there is one, unless named.
    pub count: Option<String>,
    /// Columns of the factors. None: those of the definition; of a table of counts all other columns; of result files
    /// without a sidecar all columns of stimulus parameters.
    pub factors: Option<Vec<String>>,
    /// Further columns to read as factors, such as those of a model's terms, besides the ones above. One that no file has
    /// is left out, except that `inv_n` is then `depth`.
    pub also: Vec<String>,
    /// Leaves out sessions in which planned trials are not rated.
    pub complete_only: bool,
    /// Whether session, repetition and response time of each row are read too.
    pub details: bool,
}

impl ReadOptions {
    /// Name of the column of the subject.
    pub(super) fn subject(&self) -> &str {
        self.subject.as_deref().unwrap_or("subject_id")
    }

    /// Name of the column of the response.
    pub(super) fn response(&self) -> &str {
        self.response.as_deref().unwrap_or("rating")
    }

    /// Name of the column of the count.
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
    /// The ordered categories, where they are known: `0`…`3` of our own files.
    pub categories: Option<Vec<String>>,
    /// Whether the factors were neither named nor defined, so that those with a single level say nothing.
    pub guessed: bool,
}

/// What was read, and what was not.
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
    /// Everything that is wrong, in the order of the files; of many alike in one file the first ones and a last that
    /// says how many more.
    pub faults: Vec<FileFault>,
}

/// What a file is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Layout {
    /// One row a trial, in the columns of a session's file.
    Results,
    /// Counts of ratings.
    Counts,
    /// One row a rating, in columns that were named.
    #[default]
    Long,
}

/// A file and what became of its rows.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FileRead {
    /// Where it is.
    pub path: PathBuf,
    /// What it is.
    pub layout: Layout,
    /// Rows below the header.
    pub rows: u64,
    /// Rows that count.
    pub counted: u64,
    /// Trials that these represent.
    pub ratings: u64,
    /// Practice rows, left out.
    pub practice: u64,
    /// Ratings taken back: rows of which a later attempt exists, left out.
    pub superseded: u64,
    /// Rows with a fault, left out.
    pub faulty: u64,
    /// Rows of unfinished sessions, left out because [`ReadOptions::complete_only`] asks for it.
    pub unfinished: u64,
    /// SHA-256 of the content, so that the analysis can be repeated on just this file; none of a file above 64 MiB.
    pub sha256: Option<String>,
}

/// A session that was found in result files.
#[derive(Clone, Debug)]
pub struct SessionRead {
    /// Participant.
    pub subject: String,
    /// Session.
    pub session: String,
    /// File.
    pub path: PathBuf,
    /// Main trials that are planned, where a sidecar has the definition.
    pub planned: Option<u64>,
    /// Main trials that are rated.
    pub rated: u64,
    /// Main trials in which a frame was dropped; none where nothing was measured.
    pub dropped: Option<u64>,
    /// The sidecar.
    pub sidecar: Option<Sidecar>,
}

impl SessionRead {
    /// Whether planned trials are not rated, as far as is known.
    pub fn is_unfinished(&self) -> bool {
        self.planned.is_some_and(|planned| self.rated < planned)
    }
}
