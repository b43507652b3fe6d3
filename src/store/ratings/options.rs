//! The options for reading ratings.

use serde::{Serialize, Serializer};

use crate::{
    store::table::{List, list},
    text::number::{numbers_of, positive},
};

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
    /// Analyze only these levels of a factor; NA means a missing value. Several factors can be
    /// given.
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

    /// True if the response is a rating on our own scale, 0…3.
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
