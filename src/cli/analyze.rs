//! `machband analyze`

use std::path::{Path, PathBuf};

use serde::Serialize;

use super::{
    Bar, OutPath,
    ratings::{problems, sentence},
};
use crate::{
    report::{
        Provenance, check_folder,
        document::Document,
        skins,
        study::{Parts, document, shell_command},
        study_files, task_files,
        tasks::{self, TaskResults, TaskStudy},
        write_files,
    },
    store::Writer,
    system::now,
    work::{Analyze, Watcher as _, words},
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
    check_folder(writer, &arguments.out)?;
    let progress = Bar::new("reading");
    if let Some(study) = arguments.analysis.read_task()? {
        return run_task(arguments, writer, &study, &progress);
    }
    let study = arguments.analysis.read()?;
    progress.stage("analyzing");
    let results = arguments.analysis.analyze(&study, &progress)?;
    progress.stage(if arguments.tables_only { "writing" } else { "predicting, drawing and writing" });
    let words = std::iter::once("analyze".to_owned()).chain(words(arguments));
    let provenance = Provenance::new(shell_command(words), now());
    let (contents, _) = study_files(&study, &results, &provenance, &arguments.out, arguments.tables_only)?;
    let files = write_files(writer, &arguments.out, contents)?;
    progress.clear();
    super::print_line(&sentence(&study.source, &results.measured))?;
    print_summary(&document(&study.source, &results, Parts::default()))?;
    report_written(&files, &arguments.out)?;
    problems(&study.source.warnings, &study.source.errors)
}

/// Analyzes the answers to a task other than a rating.
fn run_task(arguments: &Arguments, writer: &Writer, study: &TaskStudy, progress: &Bar) -> anyhow::Result<()> {
    progress.stage("analyzing");
    let results = TaskResults::of(study, arguments.analysis.resampling.seed);
    progress.stage("drawing and writing");
    let words = std::iter::once("analyze".to_owned()).chain(words(arguments));
    let provenance = Provenance::new(shell_command(words), now());
    let contents = task_files(study, &results, &provenance, &arguments.out, arguments.tables_only)?;
    let files = write_files(writer, &arguments.out, contents)?;
    progress.clear();
    print_summary(&tasks::document(study, &results, &[], None))?;
    report_written(&files, &arguments.out)?;
    problems(&study.warnings, &study.errors)
}

/// Prints the first section of a report.
fn print_summary(document: &Document) -> anyhow::Result<()> {
    let mut lines = document.sections.first().into_iter().flat_map(skins::terminal);
    lines.try_for_each(|line| super::print_line(&line))
}

/// Says how many files were written into a folder, and which to open.
fn report_written(files: &[PathBuf], out: &Path) -> anyhow::Result<()> {
    let report = files.iter().find(|file| file.extension().is_some_and(|extension| extension == "html"));
    super::print_line(&format!("{} files written; see {}", files.len(), report.map_or(out, |report| report).display()))
}
