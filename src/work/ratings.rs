//! The ratings that an analysis reads, and their counts.

use std::path::PathBuf;

use serde::Serialize;

use crate::{
    report::Study,
    store::{FileErrors, ratings::ReadOptions, table::List},
};

/// Where to find the ratings.
#[derive(Clone, Debug, Default, PartialEq, clap::Args, Serialize)]
pub struct Ratings {
    /// Result files, folders of result files, tables of counts, or any CSV file.
    #[arg(required = true, value_name = "FILE|DIR")]
    pub paths: Vec<PathBuf>,
    /// Column with the participant ID [default: subject_id].
    #[arg(long, value_name = "COL")]
    pub subject: Option<String>,
    /// Column with the ordered response [default: rating, 0–3].
    #[arg(long, value_name = "COL")]
    pub response: Option<String>,
    /// Categories of the response, lowest first, if they are not numbers. Quote a category that contains a comma, as in
    /// CSV: 'low,"medium, mostly",high'.
    #[arg(long, value_name = "C,…", value_parser = categories, requires = "response")]
    pub categories: Option<List>,
    /// Column with the number of trials per row [default: count, if present].
    #[arg(long, value_name = "COL")]
    pub count: Option<String>,
    /// Columns with the factors [default: the factors of the definition or of the terms].
    #[arg(long, value_name = "COL,…")]
    pub factors: Option<List>,
    /// Exclude sessions with unrated trials.
    #[arg(long)]
    pub complete_only: bool,
}

/// Parses the categories of a response.
fn categories(text: &str) -> Result<List, String> {
    let List(names) = text.parse()?;
    match names.iter().enumerate().find(|(index, name)| names[..*index].contains(name)) {
        Some((_, twice)) => Err(format!("{twice} appears twice; expected each category once")),
        None => Ok(List(names)),
    }
}

impl Ratings {
    /// Reads the files; `also` names additional columns that a model needs.
    ///
    /// # Errors
    /// No file can be read.
    pub fn read(&self, also: Vec<String>, details: bool, large: bool) -> Result<Study, FileErrors> {
        let how = ReadOptions {
            subject: self.subject.clone(),
            response: self.response.clone(),
            categories: self.categories.clone().map(|list| list.0),
            count: self.count.clone(),
            factors: self.factors.clone().map(|list| list.0),
            also,
            complete_only: self.complete_only,
            details,
            large,
        };
        Study::read(&self.paths, &how)
    }
}
