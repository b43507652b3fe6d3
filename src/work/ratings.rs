//! The ratings that an analysis reads, and their counts.

use std::{fmt, path::PathBuf, str::FromStr};

use serde::Serialize;

use super::RequestError;
use crate::{
    analysis::{
        counts::{ExclusionError, Exclusions},
        number_of, numbers_of,
    },
    report::{
        Study, StudyError,
        tasks::{self, TaskStudy},
    },
    store::{
        FileErrors,
        ratings::ReadOptions,
        table::{List, list, split_list},
    },
    text::{names::serde_as_text, number::positive},
};

/// Where to find the ratings.
#[derive(Clone, Debug, Default, PartialEq, clap::Args, Serialize)]
pub struct Ratings {
    /// Result files, folders of result files, tables of counts, or any table (CSV or Excel).
    #[arg(required = true, value_name = "FILE|DIR")]
    pub paths: Vec<PathBuf>,
    /// Column with the participant ID [default: subject_id, or the only column participant, participant_id, subject or subject_nr].
    #[arg(long, value_name = "COL")]
    pub subject: Option<String>,
    /// Column with the ordered response [default: rating, 0–3].
    #[arg(long, value_name = "COL", group = "scale")]
    pub response: Option<String>,
    /// Columns with the ordered responses at each level of a factor, which is named condition unless NAME= says
    /// otherwise.
    #[arg(long, value_name = "[NAME=]COL,…", value_parser = wide, group = "scale")]
    pub wide: Option<Only>,
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
    #[arg(long, value_name = "FACTOR=LEVEL,…")]
    pub levels: Vec<Only>,
    /// The orders that columns of a table in memory have by themselves; those of columns that are not factors say nothing.
    #[arg(skip)]
    #[serde(skip)]
    pub orders: Vec<Only>,
    /// Factors that are directions, which are circular [default: stimulus parameters that are directions].
    #[arg(long, value_name = "COL,…")]
    pub direction: Option<List>,
    /// Participants to exclude.
    #[arg(long, value_name = "ID,…")]
    pub exclude: Option<List>,
    /// Analyze only these levels of a factor; NA means a missing value. Several factors can be
    /// given.
    #[arg(long, value_name = "FACTOR=LEVEL,…")]
    pub only: Vec<Only>,
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
}

/// A factor and some of its levels.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Only {
    /// Name of the factor; quoted in text if it contains =.
    pub factor: String,
    /// The levels; `NA` stands for a missing value.
    pub levels: Vec<String>,
}

impl fmt::Display for Only {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { factor, levels } = self;
        let is_quoted = factor.contains('=') || factor.starts_with('"');
        let factor = if is_quoted { format!("\"{}\"", factor.replace('"', "\"\"")) } else { factor.clone() };
        write!(f, "{factor}={}", list(levels))
    }
}

impl FromStr for Only {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        const EXPECTED: &str = "expected a factor, =, and its levels, such as width=0.1,0.2";
        let (factor, levels) = match text.strip_prefix('"').and_then(|text| text.split_once("\"=")) {
            Some((factor, levels)) => (factor.replace("\"\"", "\""), levels),
            None => {
                let (factor, levels) = text.split_once('=').ok_or(EXPECTED)?;
                (factor.trim().to_owned(), levels)
            }
        };
        match split_list(levels)? {
            levels if levels.is_empty() || factor.is_empty() => Err(EXPECTED.to_owned()),
            levels => Ok(Self { factor, levels }),
        }
    }
}

serde_as_text!(Only);

/// Parses the columns of a wide table.
fn wide(text: &str) -> Result<Only, String> {
    match text.split_once('=').filter(|(name, _)| !name.contains([',', '"'])) {
        Some(_) => text.parse(),
        None => format!("condition={text}").parse(),
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

fn pairs(all: &[Only]) -> Vec<(String, Vec<String>)> {
    all.iter().map(|only| (only.factor.clone(), only.levels.clone())).collect()
}

impl Ratings {
    /// Returns what is to be excluded.
    pub fn exclusions(&self) -> Exclusions {
        Exclusions { exclude: self.exclude.clone().unwrap_or_default().0, only: pairs(&self.only) }
    }

    /// Returns the same ratings without what is to be excluded.
    #[must_use]
    pub fn excluding(self, Exclusions { exclude, only }: Exclusions) -> Self {
        Self {
            exclude: (!exclude.is_empty()).then_some(List(exclude)),
            only: only.into_iter().map(|(factor, levels)| Only { factor, levels }).collect(),
            ..self
        }
    }

    /// Reads the files; `also` names additional columns that a model needs: those of its terms, and of covariates and items.
    ///
    /// # Errors
    /// No file can be read, or an exclusion is not possible.
    pub fn read(&self, also: [Vec<String>; 2], details: bool, large: bool) -> Result<Study, StudyError> {
        if let Some((path, task)) = TaskStudy::task_at(&self.paths)? {
            let answers = tasks::answers(&task);
            let message =
                format!("has {answers}; expected ratings on a scale of categories (machband analyze reads every task)");
            return Err(FileErrors::whole(&path, message).into());
        }
        Study::read(&self.paths, &self.options(also, details, large))
    }

    /// Returns how the ratings are read.
    pub(super) fn options(&self, [also, roles]: [Vec<String>; 2], details: bool, large: bool) -> ReadOptions {
        let Exclusions { exclude, only } = self.exclusions();
        ReadOptions {
            subject: self.subject.clone(),
            response: self.response.clone(),
            wide: self.wide.clone().map(|Only { factor, levels }| (factor, levels)),
            missing: self.missing.clone().unwrap_or_default().0,
            categories: self.categories.clone().map(|list| list.0),
            count: self.count.clone(),
            factors: self.factors.clone().map(|list| list.0),
            also,
            roles,
            levels: pairs(&self.levels),
            orders: pairs(&self.orders),
            direction: self.direction.clone().unwrap_or_default().0,
            exclude,
            only,
            order: self.order.clone(),
            time: self.time.clone(),
            time_limits: (self.min_time, self.max_time),
            complete_only: self.complete_only,
            details,
            large,
        }
    }
}

/// Checks that the order of the categories is known. For counts, categories `may_be_words`, but not beside numbers.
///
/// # Errors
/// Names the categories that are no numbers.
pub fn check_order(study: &Study, may_be_words: bool) -> Result<(), RequestError> {
    let (shape, counts) = (&study.source.shape, &study.measured.counts);
    let words: Vec<&String> = counts.categories.iter().filter(|category| number_of(category).is_none()).collect();
    let are_all = words.len() == counts.categories.len();
    if counts.is_ordered(shape.categories.as_deref()) || are_all && may_be_words {
        return Ok(());
    }
    let message = format!(
        "{}: {} {}; expected numbers, or the order of all categories, lowest first",
        shape.response,
        list(words.iter().take(12)),
        if words.len() == 1 { "is not a number" } else { "are not numbers" },
    );
    // Not an order of these words, which somebody would copy.
    Err(RequestError::value("response", message).such_as("categories", "LOWEST,…,HIGHEST"))
}

/// Turns an error of reading into one of the request, if that is what is wrong.
pub fn explained(error: StudyError) -> anyhow::Error {
    let field = match &error {
        StudyError::Files(_) => return error.into(),
        StudyError::TooManyCategories { .. } => {
            return RequestError::value("response", error).such_as("categories", "0,1,2").into();
        }
        StudyError::Codes { codes, .. } => {
            let codes = list(codes.iter().map(|(code, _)| code));
            return RequestError::value("response", error).such_as("missing", &codes).into();
        }
        StudyError::Levels(_) => "levels",
        StudyError::Direction(_) => "direction",
        StudyError::TooLarge(_) => return RequestError::whole(error).unless("large").into(),
        StudyError::Exclusion(ExclusionError::Participant { .. } | ExclusionError::Nothing) => "exclude",
        StudyError::Exclusion(ExclusionError::Factor { .. } | ExclusionError::Level { .. }) => "only",
    };
    RequestError::new(field, error).into()
}
