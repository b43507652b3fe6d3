//! `machband analyze` and `machband counts`, and what they say about the ratings that they read.

use std::collections::BTreeMap;

use serde::Serialize;

use super::{Bar, OutPath};
use crate::{
    analysis::{Options, counts::Measured, results::covariates},
    report::{Provenance, check_folder, document::numbers::count, skins, tables},
    store::{
        FileError, FileErrors, Writer,
        ratings::{FileRead, Source},
    },
    system::now,
    work::{Analyze, Ratings, Watcher as _, command},
};

/// Analyze ratings: descriptive statistics, ordinal model, tests, figures and a report.
///
/// Reads result files, folders of result files, tables of counts, or any table (CSV or Excel) with column names. If part of the
/// input has errors, every error is reported, the rest is analyzed, and the exit status is 1. Files that were changed
/// after their session ended are analyzed with a warning.
#[derive(clap::Args, Serialize)]
#[command(after_help = "Examples: machband analyze results/bangay2003 --out analysis\n          \
    machband analyze ratings.csv --subject id --response score --terms width,num:inv_n --out analysis")]
pub(super) struct Arguments {
    #[command(flatten)]
    #[serde(flatten)]
    analysis: Analyze,
    /// Folder for tables, figures and report.html; --force replaces an earlier analysis.
    #[arg(long, value_name = "DIR", value_hint = clap::ValueHint::DirPath)]
    out: OutPath,
    /// Write only the tables and model.json.
    #[arg(long)]
    tables_only: bool,
}

pub(super) fn run(arguments: &Arguments, writer: &Writer) -> anyhow::Result<()> {
    let Arguments { analysis, out, tables_only } = arguments;
    check_folder(writer, out)?;
    let provenance = Provenance::new(command("analyze", arguments, &[]), now());
    let progress = Bar::new("reading");
    let analyzed = analysis.run(&progress)?;
    progress.stage(if *tables_only { "writing" } else { "drawing and writing" });
    let files = analyzed.write(writer, out, &provenance, *tables_only)?;
    progress.clear();
    let document = analyzed.document(&[], None);
    let mut summary = document.sections.first().into_iter().flat_map(skins::terminal);
    summary.try_for_each(|line| super::print_line(&line))?;
    let report = files.iter().find(|file| file.extension().is_some_and(|extension| extension == "html"));
    super::print_line(&format!(
        "{} files written; see {}",
        files.len(),
        report.map_or_else(|| out.display(), |path| path.display())
    ))?;
    problems(analyzed.problems())
}

/// Summarizes in one line what was read, and how many rows were left out.
fn sentence(source: &Source, Measured { counts, .. }: &Measured) -> String {
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
pub(super) fn problems([errors, warnings]: [&[FileError]; 2]) -> anyhow::Result<()> {
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
    let study = arguments.ratings.read(Default::default(), false, true)?;
    study.check_order(true)?;
    let counts = &study.measured.counts;
    writer.write(&arguments.out, &tables::counts_csv(counts, &study.source.shape))?;
    progress.clear();
    // An analysis has no conditions for single values of covariates.
    let described = study.measured.without_factors(&covariates(counts, &Options::default()));
    super::print_line(&sentence(&study.source, &described))?;
    super::print_line(&format!("{} in {}", count(counts.rows.len() as u64, "row"), arguments.out.display()))?;
    problems([&study.source.errors, &study.source.warnings])
}
