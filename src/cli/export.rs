//! `machband export`

use std::{io::Write as _, path::PathBuf};

use crate::{
    report::document::numbers::count,
    store::export::{self, Format},
};

/// Export recorded sessions as a data set that passes the standard's validator.
///
/// Exports are all-or-nothing, and the same sessions always give the same bytes. Pictures are included only if their
/// hashes match what was shown.
#[derive(clap::Args)]
#[command(after_help = "Example: machband export results --format bids --out bids")]
pub(super) struct Arguments {
    /// Results folder, or the folder of one experiment.
    #[arg(value_name = "DIR")]
    folder: PathBuf,
    /// Format of the data set.
    #[arg(long, value_enum)]
    format: Format,
    /// New or empty folder outside the data.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Exclude sessions with unrated trials.
    #[arg(long)]
    complete_only: bool,
}

pub(super) fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let Arguments { folder, format, out, complete_only } = arguments;
    let waiting = super::spinner("exporting");
    let exported = export::export(folder, out, *format, *complete_only);
    waiting.finish_and_clear();
    let exported = exported?;
    for note in &exported.notes {
        // It does not matter if stderr is closed.
        let _ = writeln!(std::io::stderr(), "warning: {note}");
    }
    let pictures = match exported.pictures {
        0 => String::new(),
        pictures => format!(", {}", count(pictures as u64, "picture")),
    };
    super::print_line(&format!(
        "{} of {} in {}, {}{pictures}",
        count(exported.sessions as u64, "session"),
        exported.experiments.join(", "),
        out.display(),
        count(exported.rows as u64, "row")
    ))
}
