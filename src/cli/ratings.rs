//! `machband counts`, and what it and `analyze` say about the ratings that they read.

use std::collections::BTreeMap;

use super::OutPath;
use crate::{
    analysis::{Options, counts::Measured, results::covariates},
    report::{document::numbers::count, tables},
    store::{
        FileError, FileErrors, Writer,
        ratings::{FileRead, Source},
    },
    work::{Ratings, check_order, explained},
};

/// Summarizes in one line what was read, and how many rows were left out.
pub(super) fn sentence(source: &Source, Measured { counts, .. }: &Measured) -> String {
    let of = |file: &FileRead| {
        let reasons = file.left_out.values().flat_map(BTreeMap::values).sum::<u64>();
        file.practice + file.superseded + file.erroneous + reasons
    };
    let left_out = match source.files.iter().map(of).sum::<u64>() {
        0 => String::new(),
        rows => format!("; {} left out", count(rows, "row")),
    };
    format!(
        "{} of {} by {}, from {}{left_out}",
        count(counts.total(), "rating"),
        count(counts.complete_conditions(), "condition"),
        count(counts.subjects.len() as u64, "participant"),
        count(source.files.len() as u64, "file")
    )
}

/// Prints all warnings about the input, and fails with all errors in it, if there are any.
pub(super) fn problems(warnings: &[FileError], errors: &[FileError]) -> anyhow::Result<()> {
    warnings.iter().for_each(|warning| super::message("warning", &warning.to_string()));
    Ok(FileErrors::none(errors.to_vec())?)
}

/// Reduce ratings to counts, the sufficient statistic: one row per participant, condition and rating.
///
/// `analyze` accepts this table in place of the files, with the same --subject and --response, and computes the same
/// descriptive statistics, models and tests. The table contains neither the order of repeated ratings nor response times,
/// and it does not say whether the ratings are simulated.
#[derive(clap::Args)]
#[command(after_help = "Examples: machband counts results/bangay2003 --out counts.csv\n          \
    machband counts ratings.csv --subject id --response score --factors width,depth --out counts.csv")]
pub(super) struct CountsArguments {
    #[command(flatten)]
    ratings: Ratings,
    /// Table to write.
    #[arg(long, value_name = "FILE.csv")]
    out: OutPath,
}

pub(super) fn counts(arguments: &CountsArguments, writer: &Writer) -> anyhow::Result<()> {
    let progress = super::Bar::new("reading");
    let study = arguments.ratings.read(Default::default(), false, true).map_err(explained)?;
    check_order(&study, true)?;
    let counts = &study.measured.counts;
    writer.write(&arguments.out, &tables::counts_csv(counts, &study.source.shape))?;
    progress.clear();
    // An analysis has no conditions for single values of covariates.
    let described = study.measured.without_factors(&covariates(counts, &Options::default()));
    super::print_line(&sentence(&study.source, &described))?;
    super::print_line(&format!("{} in {}", count(counts.rows.len() as u64, "row"), arguments.out.display()))?;
    problems(&study.source.warnings, &study.source.errors)
}
