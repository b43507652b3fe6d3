//! `machband export`

use std::{io::Write as _, path::PathBuf};

use crate::store::export;

/// Write recorded sessions in the form that others expect.
///
/// `bids`: one BIDS 1.11 data set with the pictures that were shown, proved by their hashes; `psych-ds`: a Psych-DS data set
/// an experiment, of whole rows only; `psychopy`: a wide CSV a session, with PsychoPy's columns; `parquet`: a typed table an
/// experiment. Everything is written or nothing; equal sessions give equal bytes.
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

#[derive(Clone, Copy, clap::ValueEnum)]
enum Format {
    Bids,
    PsychDs,
    Psychopy,
    Parquet,
}

impl From<Format> for export::Format {
    fn from(format: Format) -> Self {
        match format {
            Format::Bids => Self::Bids,
            Format::PsychDs => Self::PsychDs,
            Format::Psychopy => Self::Psychopy,
            Format::Parquet => Self::Parquet,
        }
    }
}

pub(super) fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let Arguments { folder, format, out, complete_only } = arguments;
    let waiting = super::spinner("exporting");
    let exported = export::export(folder, out, (*format).into(), *complete_only);
    waiting.finish_and_clear();
    let exported = exported?;
    for note in &exported.notes {
        // Where nobody listens, nothing is lost.
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
