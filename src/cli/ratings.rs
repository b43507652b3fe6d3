//! `machband counts`, and the file and column options that it shares with `analyze`.

use std::path::PathBuf;

use super::OutPath;
use crate::{
    analysis::counts::Counts,
    report::{Study, document::numbers::count, tables},
    store::{
        Writer,
        ratings::{FileRead, ReadOptions, Source},
        table::split_list,
    },
};

/// Where to find the ratings.
#[derive(clap::Args)]
pub(super) struct RatingOptions {
    /// Result files, folders of result files, tables of counts, or any CSV file.
    #[arg(required = true, value_name = "FILE|DIR")]
    paths: Vec<PathBuf>,
    /// Column with the participant ID [default: subject_id].
    #[arg(long, value_name = "COL")]
    subject: Option<String>,
    /// Column with the ordered response [default: rating, 0–3].
    #[arg(long, value_name = "COL")]
    response: Option<String>,
    /// Categories of the response, lowest first, if they are not numbers. Quote a category that contains a comma, as in
    /// CSV: 'low,"medium, mostly",high'.
    #[arg(long, value_name = "C,…", value_parser = categories, requires = "response")]
    categories: Option<Vec<Vec<String>>>,
    /// Column with the number of trials per row [default: count, if present].
    #[arg(long, value_name = "COL")]
    count: Option<String>,
    /// Columns with the factors [default: the factors of the definition or of the terms].
    #[arg(long, value_name = "COL,…", value_parser = split_list)]
    factors: Option<Vec<Vec<String>>>,
    /// Exclude sessions with unrated trials.
    #[arg(long)]
    complete_only: bool,
}

/// Parses the categories of a response.
fn categories(text: &str) -> Result<Vec<String>, String> {
    let names = split_list(text)?;
    match names.iter().enumerate().find(|(index, name)| names[..*index].contains(name)) {
        Some((_, twice)) => Err(format!("{twice} appears twice; expected each category once")),
        None => Ok(names),
    }
}

impl RatingOptions {
    /// Reads the files; `also` names additional columns that a model needs.
    pub(super) fn read(&self, also: &[String], details: bool, large: bool) -> anyhow::Result<Study> {
        let how = ReadOptions {
            subject: self.subject.clone(),
            response: self.response.clone(),
            categories: self.categories.as_ref().map(|lists| lists.concat()),
            count: self.count.clone(),
            factors: self.factors.as_ref().map(|lists| lists.concat()),
            also: also.to_vec(),
            complete_only: self.complete_only,
            details,
            large,
        };
        Ok(Study::read(&self.paths, &how)?)
    }
}

/// Summarizes in one line what was read and what was left out.
pub(super) fn sentence(source: &Source, counts: &Counts) -> String {
    let sum = |of: fn(&FileRead) -> u64| source.files.iter().map(of).sum::<u64>();
    let left_out: Vec<String> = [
        (sum(|file| file.practice), "from practice"),
        (sum(|file| file.superseded), "superseded by a correction"),
        (sum(|file| file.unfinished), "from unfinished sessions"),
        (sum(|file| file.erroneous), "with errors"),
    ]
    .into_iter()
    .filter(|(rows, _)| *rows > 0)
    .map(|(rows, what)| format!("{rows} {what}"))
    .collect();
    let unfinished = source.sessions.iter().filter(|session| session.is_unfinished()).count();
    let mut line = format!(
        "{} of {} by {}, from {}",
        count(counts.total(), "rating"),
        count(counts.conditions.len() as u64, "condition"),
        count(counts.subjects.len() as u64, "participant"),
        count(source.files.len() as u64, "file")
    );
    if !left_out.is_empty() {
        line += &format!("; rows left out: {}", left_out.join(", "));
    }
    if unfinished > 0 {
        line += &format!("; {unfinished} of {} unfinished", count(source.sessions.len() as u64, "session"));
    }
    line
}

/// Prints all warnings about the input, and fails with all errors in it, if there are any.
pub(super) fn problems(source: &Source) -> anyhow::Result<()> {
    source.warnings.iter().for_each(|warning| super::message("warning", &warning.to_string()));
    if source.errors.is_empty() {
        return Ok(());
    }
    let lines: Vec<String> = source.errors.iter().map(ToString::to_string).collect();
    Err(anyhow::anyhow!(lines.join("\n")))
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
    ratings: RatingOptions,
    /// Table to write.
    #[arg(long, value_name = "FILE.csv")]
    out: OutPath,
}

pub(super) fn counts(arguments: &CountsArguments, writer: &Writer) -> anyhow::Result<()> {
    let progress = super::spinner("reading");
    let study = arguments.ratings.read(&[], false, true)?;
    let counts = &study.measured.counts;
    writer.write(&arguments.out, &tables::counts_csv(counts, &study.source.shape))?;
    progress.finish_and_clear();
    super::print_line(&sentence(&study.source, counts))?;
    super::print_line(&format!("{} in {}", count(counts.rows.len() as u64, "row"), arguments.out.display()))?;
    problems(&study.source)
}
