//! Options that `analyze` and `counts` share: which files, and which of their columns.

use std::path::PathBuf;

use crate::{
    analysis::counts::Counts,
    report::{Study, document::numbers::count},
    store::ratings::{ReadOptions, Source},
};

/// Where ratings are.
#[derive(clap::Args)]
pub(super) struct RatingOptions {
    /// Result files, folders of them, tables of counts, or any CSV.
    #[arg(required = true, value_name = "FILE|DIR")]
    paths: Vec<PathBuf>,
    /// Column of the subject; subject_id unless named.
    #[arg(long, value_name = "COL")]
    subject: Option<String>,
    /// Column of the ordered response; unless named, rating, on the scale 0–3.
    #[arg(long, value_name = "COL")]
    response: Option<String>,
    /// The response's categories, the lowest first, if they are not numbers.
    #[arg(long, value_name = "C,…", value_delimiter = ',', requires = "response")]
    categories: Option<Vec<String>>,
    /// Column that says how many trials a row stands for; count, where there is one.
    #[arg(long, value_name = "COL")]
    count: Option<String>,
    /// Columns of the factors; unless named, those of the definition, or of the terms.
    #[arg(long, value_name = "COL,…", value_delimiter = ',')]
    factors: Option<Vec<String>>,
    /// Leave out sessions in which planned trials are not rated.
    #[arg(long)]
    complete_only: bool,
}

impl RatingOptions {
    /// Reads the files; `also` are columns that a model needs.
    pub(super) fn read(&self, also: &[String], details: bool) -> anyhow::Result<Study> {
        let how = ReadOptions {
            subject: self.subject.clone(),
            response: self.response.clone(),
            categories: self.categories.clone(),
            count: self.count.clone(),
            factors: self.factors.clone(),
            also: also.to_vec(),
            complete_only: self.complete_only,
            details,
        };
        Ok(Study::read(&self.paths, &how)?)
    }
}

/// What was read and what was left out, in a line.
pub(super) fn sentence(source: &Source, counts: &Counts) -> String {
    let sum = |of: fn(&crate::store::ratings::FileRead) -> u64| source.files.iter().map(of).sum::<u64>();
    let left_out: Vec<String> = [
        (sum(|file| file.practice), "practice rows"),
        (sum(|file| file.superseded), "ratings taken back"),
        (sum(|file| file.unfinished), "ratings of unfinished sessions"),
        (sum(|file| file.faulty), "faulty rows"),
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
        line += &format!("; left out: {}", left_out.join(", "));
    }
    if unfinished > 0 {
        line += &format!("; {unfinished} of {} sessions unfinished", source.sessions.len());
    }
    line
}

/// Everything that was wrong with the input, as the command's failure.
pub(super) fn faults(source: &Source) -> anyhow::Result<()> {
    if source.faults.is_empty() {
        return Ok(());
    }
    let lines: Vec<String> = source.faults.iter().map(ToString::to_string).collect();
    Err(anyhow::anyhow!(lines.join("\n")))
}
