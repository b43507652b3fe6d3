//! The ratings that an analysis reads, and their counts.

use std::path::PathBuf;

use serde::Serialize;

use super::RequestError;
use crate::{
    analysis::{
        counts::{ExclusionError, Exclusions},
        number_of,
    },
    report::{
        Study, StudyError,
        tasks::{self, TaskStudy},
    },
    store::{
        FileErrors,
        ratings::ReadOptions,
        table::{List, list},
    },
};

/// Where to find the ratings, and how to read them.
#[derive(Clone, Debug, Default, PartialEq, clap::Args, Serialize)]
pub struct Ratings {
    /// Result files, folders of result files, tables of counts, or any table (CSV or Excel).
    #[arg(required = true, value_name = "FILE|DIR")]
    pub paths: Vec<PathBuf>,
    #[command(flatten)]
    #[serde(flatten)]
    pub how: ReadOptions,
}

impl Ratings {
    /// Returns the same ratings without what is to be excluded.
    #[must_use]
    pub fn excluding(mut self, Exclusions { exclude, only }: Exclusions) -> Self {
        (self.how.exclude, self.how.only) = ((!exclude.is_empty()).then_some(List(exclude)), only);
        self
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
    pub(super) fn options(&self, [also, roles]: [Vec<String>; 2], details: bool, unlimited: bool) -> ReadOptions {
        ReadOptions { also, roles, details, unlimited, ..self.how.clone() }
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
