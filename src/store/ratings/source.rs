//! How to read ratings, and the description of what was read.

use std::{
    collections::{BTreeMap, BTreeSet},
    path::PathBuf,
    sync::Arc,
};

use serde::{Serialize, Serializer};

use crate::{
    experiment::Protocol,
    stimulus::{MachBand, Parameter},
    store::{
        FileError,
        sidecar::{Sidecar, Sitting},
        table::{List, list},
    },
    text::{
        names::named,
        number::{numbers_of, positive},
    },
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
pub(super) enum Layout {
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
    /// The sidecar, if it can be read.
    pub sidecar: Option<Arc<Sidecar>>,
}

impl SessionRead {
    /// True if some planned trials are known to be unrated.
    pub fn is_unfinished(&self) -> bool {
        self.planned.is_some_and(|planned| self.rated < planned)
    }

    /// Returns its sittings, if there is a sidecar.
    pub fn sittings(&self) -> impl Iterator<Item = &Sitting> {
        self.sidecar.iter().flat_map(|sidecar| &sidecar.sittings)
    }

    /// True if any of its ratings come from a program instead of a person.
    pub fn is_simulated(&self) -> bool {
        self.sittings().any(|sitting| sitting.observer.is_some())
    }
}

/// A factor and some of its levels; `NA` stands for a missing value.
pub type Levels = (String, Vec<String>);

/// How files are read.
#[derive(Clone, Debug, Default, PartialEq, clap::Args, Serialize)]
pub struct ReadOptions {
    /// Column with the participant ID [default: subject_id, or the only column participant, participant_id, subject or subject_nr].
    #[arg(long, value_name = "COL")]
    pub subject: Option<String>,
    /// Column with the ordered response [default: rating, 0–3].
    #[arg(long, value_name = "COL", group = "scale")]
    pub response: Option<String>,
    /// Columns with the ordered responses at each level of a factor, which is named condition unless NAME= says
    /// otherwise.
    #[arg(long, value_name = "[NAME=]COL,…", value_parser = wide, group = "scale")]
    #[serde(serialize_with = "wide_as_text")]
    pub wide: Option<Levels>,
    /// Texts that mean a missing response, such as -99, in addition to an empty cell, NA and similar words.
    #[arg(long, value_name = "TEXT,…", allow_hyphen_values = true)]
    pub missing: Option<List>,
    /// Categories of the response, lowest first, if they are not numbers. Quote a category that contains a comma, as in
    /// CSV: 'low,"medium, mostly",high'.
    #[arg(long, value_name = "C,…", value_parser = categories, requires = "scale")]
    pub categories: Option<List>,
    /// Column with the number of trials per row [default: count, if present].
    #[arg(long, value_name = "COL")]
    pub count: Option<String>,
    /// Columns with the factors [default: the factors of the definition or of the terms].
    #[arg(long, value_name = "COL,…")]
    pub factors: Option<List>,
    /// Order of the levels of a factor, of which the first is the baseline; levels that are not named follow. Several
    /// factors can be given [default: numbers in ascending order, other levels in natural order].
    #[arg(long, value_name = "FACTOR=LEVEL,…", value_parser = levels)]
    #[serde(serialize_with = "as_text")]
    pub levels: Vec<Levels>,
    /// The orders that columns of a table in memory have by themselves; those of columns that are not factors say nothing.
    #[arg(skip)]
    #[serde(skip)]
    pub orders: Vec<Levels>,
    /// Factors that are directions, which are circular [default: stimulus parameters that are directions].
    #[arg(long, value_name = "COL,…")]
    pub direction: Option<List>,
    /// Participants to exclude.
    #[arg(long, value_name = "ID,…")]
    pub exclude: Option<List>,
    /// Analyze only these levels of a factor; NA means a missing value. Several factors can be given.
    #[arg(long, value_name = "FACTOR=LEVEL,…", value_parser = levels)]
    #[serde(serialize_with = "as_text")]
    pub only: Vec<Levels>,
    /// Exclude sessions with unrated trials.
    #[arg(long)]
    pub complete_only: bool,
    /// Column with the place of each row in its session: numbers that increase from trial to trial. The report then describes
    /// drift, and how much successive ratings are related [default: the number of the trial in result files].
    #[arg(long, value_name = "COL")]
    pub order: Option<String>,
    /// Column with the response time in seconds [default: response_time_s, if present].
    #[arg(long, value_name = "COL")]
    pub time: Option<String>,
    /// Exclude trials that were answered faster, in seconds.
    #[arg(long, value_name = "S", value_parser = positive)]
    pub min_time: Option<f64>,
    /// Exclude trials that were answered more slowly, in seconds.
    #[arg(long, value_name = "S", value_parser = positive)]
    pub max_time: Option<f64>,
    /// Additional columns to read as factors, such as the ones in a model's terms. A column that no file has is
    /// ignored, except that `inv_n` then means `depth`.
    #[arg(skip)]
    #[serde(skip)]
    pub also: Vec<String>,
    /// Columns of covariates and items: read as factors beside those that are declared.
    #[arg(skip)]
    #[serde(skip)]
    pub roles: Vec<String>,
    /// True if the session, repetition and response time of each row are also read.
    #[arg(skip)]
    #[serde(skip)]
    pub details: bool,
    /// True if the size of the study has no limit.
    #[arg(skip)]
    #[serde(skip)]
    pub unlimited: bool,
}

impl ReadOptions {
    /// Returns the names of the columns that are read as factors beside those that are declared.
    pub(super) fn also(&self) -> impl Iterator<Item = &String> {
        self.also.iter().chain(&self.roles)
    }

    /// Returns whether a column is named as a factor.
    pub(super) fn is_factor(&self, name: &str) -> bool {
        self.factors.iter().flat_map(|list| &list.0).chain(self.also()).any(|factor| factor == name)
    }

    /// Returns the name of the column with the response.
    pub(super) fn response(&self) -> &str {
        self.response.as_deref().unwrap_or("rating")
    }

    /// True if the response is the rating of a session.
    pub(super) fn own_scale(&self) -> bool {
        self.response.is_none() && self.wide.is_none()
    }

    /// Returns the name of the factor whose levels are columns.
    pub(super) fn wide_factor(&self) -> Option<&String> {
        self.wide.as_ref().map(|(name, _)| name)
    }

    /// Returns the name of the column with the response time.
    pub(super) fn time(&self) -> &str {
        self.time.as_deref().unwrap_or("response_time_s")
    }

    /// Returns the name of the column with the count.
    pub(super) fn count(&self) -> &str {
        self.count.as_deref().unwrap_or("count")
    }
}

/// Writes a factor and levels as [`levels`] reads them: a name that contains = is quoted.
fn text((factor, levels): &Levels) -> String {
    let is_quoted = factor.contains('=') || factor.starts_with('"');
    let factor = if is_quoted { format!("\"{}\"", factor.replace('"', "\"\"")) } else { factor.clone() };
    format!("{factor}={}", list(levels))
}

fn as_text<S: Serializer>(all: &[Levels], serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_seq(all.iter().map(text))
}

fn wide_as_text<S: Serializer>(wide: &Option<Levels>, serializer: S) -> Result<S::Ok, S::Error> {
    wide.as_ref().map(text).serialize(serializer)
}

/// Parses a factor and some of its levels.
fn levels(text: &str) -> Result<Levels, String> {
    const EXPECTED: &str = "expected a factor, =, and its levels, such as width=0.1,0.2";
    let (factor, levels) = match text.strip_prefix('"').and_then(|text| text.split_once("\"=")) {
        Some((factor, levels)) => (factor.replace("\"\"", "\""), levels),
        None => {
            let (factor, levels) = text.split_once('=').ok_or(EXPECTED)?;
            (factor.trim().to_owned(), levels)
        }
    };
    match levels.parse::<List>()?.0 {
        levels if levels.is_empty() || factor.is_empty() => Err(EXPECTED.to_owned()),
        levels => Ok((factor, levels)),
    }
}

/// Parses the columns of a wide table.
fn wide(text: &str) -> Result<Levels, String> {
    match text.split_once('=').filter(|(name, _)| !name.contains([',', '"'])) {
        Some(_) => levels(text),
        None => levels(&format!("condition={text}")),
    }
}

/// Parses the categories of a response.
fn categories(text: &str) -> Result<List, String> {
    let List(names) = text.parse()?;
    match names.iter().enumerate().find(|(index, name)| names[..*index].contains(name)) {
        Some((_, twice)) => Err(format!("{twice} appears twice; expected each category once")),
        // Means are of the numbers, and the model follows the order.
        None if numbers_of(&names).is_some_and(|numbers| !numbers.is_sorted()) => {
            Err("numbers are categories in ascending order; expected this order (for a reversed scale, write each rating as \
                 the lowest plus the highest category minus the rating in a new column)"
                .to_owned())
        }
        None if names.len() < 2 => Err("expected two or more categories, lowest first".to_owned()),
        None => Ok(List(names)),
    }
}
