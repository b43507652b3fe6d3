//! `machband counts`

use std::path::PathBuf;

use super::ratings::RatingOptions;
use crate::{report::tables, store::write_file};

/// Reduce ratings to counts, the sufficient statistic: one row per subject, condition and rating.
///
/// `analyze` takes the table in place of the files, with the same --subject and --response if they were named; description, models and tests are the same. It has no repeated
/// ratings and no response times.
#[derive(clap::Args)]
#[command(after_help = "Examples: machband counts results/bangay2003 --out counts.csv\n          \
    machband counts ratings.csv --subject id --response score --factors width,depth --out counts.csv")]
pub(super) struct Arguments {
    #[command(flatten)]
    ratings: RatingOptions,
    /// The table.
    #[arg(long, value_name = "FILE.csv")]
    out: PathBuf,
}

pub(super) fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let progress = super::spinner("reading");
    let study = arguments.ratings.read(&[], false)?;
    let counts = &study.measured.counts;
    write_file(&arguments.out, &tables::counts(counts, &study.source.shape).csv())?;
    progress.finish_and_clear();
    super::say(&super::ratings::sentence(&study.source, counts))?;
    super::say(&format!("{} rows in {}", counts.rows.len(), arguments.out.display()))?;
    super::ratings::faults(&study.source)
}
