//! `machband export`

use std::path::PathBuf;

use crate::{
    report::document::numbers::count,
    store::export::{self, Choice, Format},
    work::NewFolder,
};

/// Export recorded sessions as a data set that passes the standard's validator.
///
/// Exports are all-or-nothing, and the same sessions always give the same bytes. Pictures are included only if their
/// hashes match what was shown. Links are never followed.
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
    out: NewFolder,
    /// Exclude sessions with unrated trials.
    #[arg(long)]
    complete_only: bool,
    /// Also export files that were changed after their session ended; the export then names them.
    #[arg(long)]
    accept_changes: bool,
}

pub(super) fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let &Arguments { ref folder, format, ref out, complete_only, accept_changes } = arguments;
    let waiting = super::Bar::spinner("exporting");
    let exported = export::export(folder, out, format, Choice { complete_only, accept_changes });
    waiting.clear();
    let exported = exported?;
    exported.notes.iter().for_each(|note| super::message("warning", note));
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
