//! `machband export`

use std::{io::Write as _, path::PathBuf};

use crate::store::export::{self, Format};

/// Export recorded sessions as a data set that the community's validators accept.
///
/// Exports are all or nothing, and equal sessions give equal bytes. Pictures are included only if their hashes match what
/// was shown.
#[derive(clap::Args)]
#[command(after_help = "Example: machband export results --format bids --out bids")]
pub(super) struct Arguments {
    /// Results folder, or that of one experiment.
    #[arg(value_name = "DIR")]
    folder: PathBuf,
    /// What to write.
    #[arg(long, value_enum)]
    format: Format,
    /// New or empty folder, outside the data.
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Leave out sessions with trials that are not rated.
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
        // A closed stderr costs nothing.
        let _ = writeln!(std::io::stderr(), "warning: {note}");
    }
    let pictures = if exported.pictures > 0 { format!(", {} pictures", exported.pictures) } else { String::new() };
    super::say(&format!(
        "{} sessions of {} in {}, {} rows{pictures}",
        exported.sessions,
        exported.experiments.join(", "),
        out.display(),
        exported.rows
    ))
}
