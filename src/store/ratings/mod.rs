//! Ratings from files: our result files and counts, folders of them, or any long CSV whose columns are named.
//!
//! Rows stream through a [`Sink`]; what is kept here grows with files, sessions and faults, not with rows. Of a result
//! file the practice rows are left out, of every trial only the last attempt counts, and the ratings of an unfinished
//! session count unless told otherwise; all of it is reported in [`Source`].

mod discovery;
mod emit;
mod fast;
mod faults;
mod header;
mod identity;
mod ledger;
mod plain;
mod plan;
mod reader;
mod record;
mod source;
mod survey;

use std::path::PathBuf;

pub use discovery::{DATA_FILE, data_files};

use super::{FileFault, sidecar::Sidecar};
use crate::experiment::Protocol;

/// How files are to be read.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Reading {
    /// Column of the subject; `subject_id` unless named.
    pub subject: Option<String>,
    /// Column of the response; `rating` unless named. The scale is 0…3 unless the column is named.
    pub response: Option<String>,
    /// The response's categories, the lowest first, where it is named and they are known.
    pub categories: Option<Vec<String>>,
    /// Column that says how many trials a row stands for; `count` where there is one, unless named.
    pub count: Option<String>,
    /// Columns of the factors. None: those of the definition; of a table of counts all other columns; of result files
    /// without a sidecar all columns of stimulus parameters.
    pub factors: Option<Vec<String>>,
    /// Further columns wanted as factors, such as those of a model's terms, besides the ones above. One that no file has
    /// is left out, except that `inv_n` is then `depth`.
    pub also: Vec<String>,
    /// Leaves out sessions in which planned trials are not rated.
    pub complete_only: bool,
    /// Whether session, repetition and response time of each row are wanted too.
    pub details: bool,
}

/// One row that counts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row<'a> {
    /// Who.
    pub subject: &'a str,
    /// The level of each factor, as it is written; empty where it is missing.
    pub values: &'a [&'a str],
    /// The rating, as it is written.
    pub rating: &'a str,
    /// How many trials.
    pub count: u64,
    /// Session and repetition, where they are wanted and the file has them.
    pub place: Option<(&'a str, u32)>,
    /// From onset to rating, seconds, where it is wanted and the file has it.
    pub response_time_s: Option<f64>,
}

/// What a reader gives its rows to. Each thread has one of its own; they are joined at the end, in the order of the
/// files.
pub trait Sink: Send {
    /// Takes a row.
    ///
    /// # Errors
    /// What is wrong with the rating; what is expected. It becomes a fault at the rating's line and column, and the row
    /// is left out.
    fn row(&mut self, row: &Row<'_>) -> Result<(), String>;

    /// Takes over what the sink of a later part has.
    ///
    /// # Errors
    /// Why the two do not fit together.
    fn absorb(&mut self, later: Self) -> Result<(), String>;
}

/// What a sink must know before its first row.
#[derive(Clone, Debug, PartialEq)]
pub struct Shape {
    /// Names of the factors, in the order of [`Row::values`].
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
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Layout {
    /// One row a trial, in the columns of a session's file.
    Results,
    /// Counts of ratings.
    Counts,
    /// One row a rating, in columns that were named.
    Long,
}

/// A file and what became of its rows.
#[derive(Clone, Debug, PartialEq)]
pub struct FileRead {
    /// Where it is.
    pub path: PathBuf,
    /// What it is.
    pub layout: Layout,
    /// Rows below the header.
    pub rows: u64,
    /// Rows that count.
    pub counted: u64,
    /// Trials that these stand for.
    pub ratings: u64,
    /// Practice rows, left out.
    pub practice: u64,
    /// Ratings taken back: rows of which a later attempt exists, left out.
    pub superseded: u64,
    /// Rows with a fault, left out.
    pub faulty: u64,
    /// Rows of unfinished sessions, left out because [`Reading::complete_only`] asks for it.
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

/// Reads files, and folders of them, through sinks that `new` makes.
///
/// # Errors
/// Where there is nothing to analyse at all: why. What is wrong with part of the input is in [`Source::faults`], and
/// the rest is read.
pub fn read<S: Sink>(
    paths: &[PathBuf],
    how: &Reading,
    new: impl Fn(&Shape) -> S + Sync,
) -> Result<(Source, S), super::FileFaults> {
    reader::read(paths, how, new)
}
