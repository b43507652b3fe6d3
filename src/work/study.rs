//! Reads a study of ratings, with what is excluded.

use std::path::{Path, PathBuf};

use super::RequestError;
use crate::{
    analysis::{
        counts::{Exclusions, Measured, MeasuredBuilder},
        number_of,
    },
    report::document::{self, count},
    store::{
        Columns, FileError, FileErrors,
        ratings::{self, FileRead, ReadOptions, Reason, Shape, Source},
        table::list,
    },
};

/// Maximum number of categories that are not named. A column with more, such as a response time, is a measurement.
const MAX_CATEGORIES: usize = 20;

/// The share of unreadable rows, one in this many, above which nothing is concluded from the others.
const UNREADABLE: u64 = 50;

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
    pub fn read(paths: &[PathBuf], options: &ReadOptions) -> anyhow::Result<Self> {
        Self::new(ratings::read(paths, options, builder, MeasuredBuilder::add)?, options)
    }

    /// Reads a table in memory, such as a data frame; `name` stands for it in messages. Errors count rows from 0.
    ///
    /// # Errors
    /// The same errors as [`Study::read`], or the columns differ in length.
    pub fn from_columns(name: &str, columns: Columns, options: &ReadOptions) -> anyhow::Result<Self> {
        Self::new(ratings::read_columns(name, columns, options, builder, MeasuredBuilder::add)?, options)
    }

    fn new((source, all): (Source, MeasuredBuilder), options: &ReadOptions) -> anyhow::Result<Self> {
        let all = all.finish();
        let (found, Shape { response, categories, .. }) = (all.counts.categories.len(), &source.shape);
        if categories.is_none() && found > MAX_CATEGORIES {
            // No more than 255 are read.
            let more = if found == 255 { " or more" } else { "" };
            let message = format!(
                "{response}: the number of different values is {found}{more}; expected at most {MAX_CATEGORIES} (a continuous \
                 response, such as a slider, becomes ordered in a new column with a few classes, for example its value divided \
                 by 20 and rounded), the column of the ratings, or the names of all categories, lowest first"
            );
            return Err(RequestError::value("response", message).such_as("categories", "0,1,2").into());
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
        let codes = if categories.is_none() { all.counts.codes() } else { Vec::new() };
        if !codes.is_empty() {
            // Averaged with ratings, they would distort every result.
            let told: Vec<String> = codes.iter().map(|(code, n)| format!("{code} ({})", count(*n, "rating"))).collect();
            let message = format!(
                "{response}: {} {} far from the other values, or not a whole number as they are, as a code for a missing answer \
                 or a mistake would be; expected it to be corrected or named as missing, or the names of all categories, \
                 lowest first",
                document::list(&told),
                if codes.len() == 1 { "is" } else { "are" }
            );
            let codes = list(codes.iter().map(|(code, _)| code));
            return Err(RequestError::value("response", message).such_as("missing", &codes).into());
        }
        all.counts.check_levels(&options.levels).map_err(|error| RequestError::new("levels", error))?;
        let directions: Vec<_> =
            options.direction.iter().flat_map(|list| &list.0).map(|name| (name.clone(), Vec::new())).collect();
        all.counts.check_levels(&directions).map_err(|error| RequestError::new("direction", error))?;
        let measured = all.narrowed(&exclusions).map_err(|(field, error)| RequestError::new(field, error))?;
        if !options.unlimited {
            // A number or an item is not listed level by level.
            let is_unlisted = |name: &String| options.roles.contains(name) && !options.also.contains(name);
            let factors = measured.counts.factors.iter().enumerate();
            let unlisted: Vec<usize> =
                factors.filter(|(_, factor)| is_unlisted(&factor.name)).map(|(f, _)| f).collect();
            let listed = if unlisted.is_empty() { &measured } else { &measured.without_factors(&unlisted) };
            let refused = |message| RequestError::whole(FileErrors::whole(file, message)).unless("large");
            listed.counts.check_size().map_err(refused)?;
        }
        Ok(Self { source, measured })
    }

    /// Checks that the order of the categories is known. For counts, categories `may_be_words`, but not beside numbers.
    ///
    /// # Errors
    /// Names the categories that are no numbers.
    pub fn check_order(&self, may_be_words: bool) -> Result<(), RequestError> {
        let (shape, counts) = (&self.source.shape, &self.measured.counts);
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
