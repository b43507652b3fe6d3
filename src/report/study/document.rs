//! Reads a study from files, and arranges the sections of its document.

use std::path::{Path, PathBuf};

use super::{
    description, health, methods, model,
    provenance::{self, Provenance},
    summary,
};
use crate::{
    analysis::{
        Results,
        counts::{Exclusions, Measured, MeasuredBuilder},
    },
    experiment::RatingRow,
    report::{
        document::{Document, count, list},
        figures::Figure,
    },
    store::{
        Columns, FileError, FileErrors,
        ratings::{self, FileRead, ReadOptions, Reason, Shape, Source},
    },
};

/// Maximum number of categories that are not named. A column with more, such as a response time, is a measurement.
const MAX_CATEGORIES: usize = 20;

/// The share of unreadable rows, one in this many, above which nothing is concluded from the others.
const UNREADABLE: u64 = 50;

/// The reason why there is no study.
#[derive(Clone, Debug, thiserror::Error)]
pub enum StudyError {
    /// The files cannot be analyzed.
    #[error(transparent)]
    Files(#[from] FileErrors),
    /// The study is larger than usual.
    #[error(transparent)]
    TooLarge(FileErrors),
    /// The column of the response is probably another one: it has too many different values.
    #[error("{response}: the number of different values is {found}{}; expected at most {MAX_CATEGORIES} (a continuous response, such as a slider, becomes ordered in a new column with a few classes, for example its value divided by 20 and rounded), the column of the ratings, or the names of all categories, lowest first", if *found == 255 { " or more" } else { "" })]
    TooManyCategories {
        /// Name of the column.
        response: String,
        /// Number of different values; no more than 255 are read.
        found: usize,
    },
    /// Some numbers look like codes for a missing answer, or like mistakes. Averaged with ratings, they would distort every
    /// result.
    #[error("{response}: {} far from the other values, or not a whole number as they are, as a code for a missing answer or a mistake would be; expected that it is corrected or named as missing, or the names of all categories, lowest first", told(.codes))]
    Codes {
        /// Name of the column.
        response: String,
        /// The numbers, and how often each occurs.
        codes: Vec<(String, u64)>,
    },
    /// A name that this option gives does not exist, or no ratings are left.
    #[error("{1}")]
    Names(&'static str, String),
}

fn told(codes: &[(String, u64)]) -> String {
    let codes: Vec<String> = codes.iter().map(|(code, n)| format!("{code} ({})", count(*n, "rating"))).collect();
    format!("{} {}", list(&codes), if codes.len() == 1 { "is" } else { "are" })
}

/// The ratings in the files, and the errors found in them.
#[derive(Clone, Debug)]
pub struct Study {
    /// Where the ratings come from.
    pub source: Source,
    pub measured: Measured,
}

impl Study {
    /// Reads files and folders of files.
    ///
    /// # Errors
    /// There is nothing to analyze, more than 2 % of the rows cannot be read, the study is too large, the response is
    /// probably not a rating, or an exclusion names something unknown. If fewer rows have errors, they are in
    /// [`Source::errors`].
    pub fn read(paths: &[PathBuf], options: &ReadOptions) -> Result<Self, StudyError> {
        Self::new(ratings::read(paths, options, builder, add)?, options)
    }

    /// Reads a table in memory, such as a data frame; `name` stands for it in messages. Errors count rows from 0.
    ///
    /// # Errors
    /// The same errors as [`Study::read`], or the columns differ in length.
    pub fn from_columns(name: &str, columns: Columns, options: &ReadOptions) -> Result<Self, StudyError> {
        Self::new(ratings::read_columns(name, columns, options, builder, add)?, options)
    }

    fn new((source, all): (Source, MeasuredBuilder), options: &ReadOptions) -> Result<Self, StudyError> {
        let all = all.finish();
        let (found, Shape { response, categories, .. }) = (all.counts.categories.len(), &source.shape);
        if categories.is_none() && found > MAX_CATEGORIES {
            return Err(StudyError::TooManyCategories { response: response.clone(), found });
        }
        let sum = |of: fn(&FileRead) -> u64| source.files.iter().map(of).sum::<u64>();
        let (unreadable, rows) = (sum(|file| file.erroneous - file.repeated), sum(|file| file.rows));
        let (nobodys, _) = source.left_out(Reason::NoParticipant);
        let is_affected =
            |file: &&FileRead| file.erroneous > file.repeated || file.left_out.contains_key(&Reason::NoParticipant);
        let file = source.files.iter().find(is_affected).or(source.files.first());
        let file = file.map_or(Path::new("."), |file| &file.path);
        let of_files = if source.files.len() > 1 { format!(" of {} files", source.files.len()) } else { String::new() };
        if UNREADABLE * (unreadable + nobodys) > rows {
            let share = 100 / UNREADABLE;
            let parts = [(unreadable, "cannot be read"), (nobodys, "have no participant")];
            let parts = parts.into_iter().filter(|(number, _)| *number > 0);
            let parts = parts.map(|(number, what)| format!("{number} of {rows} rows{of_files} {what}"));
            let what = parts.collect::<Vec<_>>().join(", and ");
            let message = format!("{what}, so nothing is analyzed; expected at most {share}\u{a0}% of such rows");
            let rows = source.files.iter().flat_map(|file| &file.nobodys).copied().collect();
            let error = FileError { rows, ..FileError::whole(file, message) };
            return Err(FileErrors([source.errors, vec![error]].concat()).into());
        }
        let exclusions = Exclusions::from(options);
        let codes = if source.shape.categories.is_none() { all.counts.codes() } else { Vec::new() };
        if !codes.is_empty() {
            let codes = codes.into_iter().map(|(code, n)| (code.to_owned(), n)).collect();
            return Err(StudyError::Codes { response: source.shape.response, codes });
        }
        all.counts.check_levels(&options.levels).map_err(|error| StudyError::Names("levels", error))?;
        let directions: Vec<_> =
            options.direction.iter().flat_map(|list| &list.0).map(|name| (name.clone(), Vec::new())).collect();
        all.counts.check_levels(&directions).map_err(|error| StudyError::Names("direction", error))?;
        let measured = all.narrowed(&exclusions).map_err(|(field, error)| StudyError::Names(field, error))?;
        if !options.unlimited {
            // A number or an item is not listed level by level.
            let is_unlisted = |name: &String| options.roles.contains(name) && !options.also.contains(name);
            let factors = measured.counts.factors.iter().enumerate();
            let unlisted: Vec<usize> =
                factors.filter(|(_, factor)| is_unlisted(&factor.name)).map(|(f, _)| f).collect();
            let listed = if unlisted.is_empty() { &measured } else { &measured.without_factors(&unlisted) };
            listed.counts.check_size().map_err(|message| StudyError::TooLarge(FileErrors::whole(file, message)))?;
        }
        Ok(Self { source, measured })
    }
}

impl From<&ReadOptions> for Exclusions {
    fn from(options: &ReadOptions) -> Self {
        Self { exclude: options.exclude.clone().unwrap_or_default().0, only: options.only.clone() }
    }
}

fn builder(shape: &Shape) -> MeasuredBuilder {
    let mut builder = MeasuredBuilder::new(&shape.factors);
    if let Some(categories) = &shape.categories {
        builder = builder.with_categories(categories);
    }
    builder.directions.clone_from(&shape.directions);
    builder.levels.clone_from(&shape.levels);
    builder.only_varied = shape.guessed;
    builder
}

fn add(builder: &mut MeasuredBuilder, row: &RatingRow<'_>) -> Result<(), String> {
    builder.add(row)
}

/// Describes a study in a document with these charts; `provenance` says how to repeat the analysis, for readers who do not
/// have it open.
pub fn document(source: &Source, results: &Results, figures: &[Figure], provenance: Option<&Provenance>) -> Document {
    let (methods, references) = methods::sections(source, results);
    let mut sections = vec![
        summary::section(source, results),
        health::section(source, results),
        description::section(results, figures),
        model::section(results, figures),
        description::agreement(results),
        methods,
        references,
    ];
    sections.extend(provenance.map(|provenance| provenance::section(source, provenance)));
    let (title, subtitle) = match &source.protocol {
        Some(protocol) => {
            let title = if protocol.title.trim().is_empty() { &protocol.name } else { &protocol.title };
            (title.clone(), format!("Experiment {}", protocol.name))
        }
        None => ("Analysis of ratings".to_owned(), "No definition of an experiment".to_owned()),
    };
    Document { title, subtitle, sections }
}
