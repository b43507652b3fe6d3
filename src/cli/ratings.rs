//! `machband counts`, and what it and `analyze` say about the ratings that they read.

use super::OutPath;
use crate::{
    analysis::{
        Options,
        counts::{Excluded, Measured, Part},
        results::covariates,
    },
    report::{document::numbers::count, tables},
    store::{
        FileError, FileErrors, Writer,
        ratings::{FileRead, Reason, Source},
    },
    work::{Ratings, check_order, explained},
};

/// Summarizes in one line what was read and what was left out.
pub(super) fn sentence(source: &Source, measured: &Measured) -> String {
    let Measured { counts, excluded, .. } = measured;
    let sum = |of: fn(&FileRead) -> u64| source.files.iter().map(of).sum::<u64>();
    let left_out: Vec<String> = [
        (sum(|file| file.practice), "from practice".to_owned()),
        (sum(|file| file.superseded), "superseded by a correction".to_owned()),
        (sum(|file| file.erroneous), "with errors".to_owned()),
    ]
    .into_iter()
    .chain(Reason::ALL.map(|reason| (source.left_out(reason).0, reason.to_string())))
    .filter(|(rows, _)| *rows > 0)
    .map(|(rows, what)| format!("{rows} {what}"))
    .collect();
    let unfinished = source.sessions.iter().filter(|session| session.is_unfinished()).count();
    let mut line = format!(
        "{} of {} by {}, from {}",
        count(counts.total(), "rating"),
        count(counts.complete_conditions(), "condition"),
        count(counts.subjects.len() as u64, "participant"),
        count(source.files.len() as u64, "file")
    );
    if !left_out.is_empty() {
        line += &format!("; rows left out: {}", left_out.join(", "));
    }
    let (missing, requested): (Vec<&Excluded>, _) =
        excluded.iter().partition(|excluded| matches!(excluded.what, Part::Missing(_)));
    for (what, excluded) in [("excluded on request", requested), ("without a covariate", missing)] {
        let ratings = excluded.into_iter().map(|excluded| excluded.ratings).sum();
        if ratings > 0 {
            line += &format!("; {what}: {}", count(ratings, "rating"));
        }
    }
    if unfinished > 0 {
        line += &format!("; {unfinished} of {} unfinished", count(source.sessions.len() as u64, "session"));
    }
    line
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
