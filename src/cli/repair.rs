//! `machband repair`

use std::path::PathBuf;

use super::print_line;
use crate::{
    report::document::numbers::count,
    store::{
        ratings,
        session::{Repaired, repair},
    },
};

/// Move damaged lines of a session's data file to a file next to it, so that the session can be resumed.
///
/// A line is damaged if it cannot be read, if the definition and the seed do not plan it, or if it repeats a row or is
/// not in the order of recording. A damaged header is replaced. No byte is deleted: the lines go to a new file
/// …_data.csv.damaged-N. The sidecar records the repair, and machband verify lists it. When the session is resumed, it
/// shows the trials of these lines again. If the lines were damaged after their sitting ended, machband
/// verify reports that the file was changed, and resuming needs --accept-changes.
#[derive(clap::Args)]
#[command(after_help = "Example: machband repair results/quick/data/subject-S001_session-1_task-quick_data.csv")]
pub(super) struct Arguments {
    /// Data file of a session, or a folder with data files.
    #[arg(value_name = "FILE|DIR")]
    path: PathBuf,
}

pub(super) fn run(arguments: &Arguments) -> anyhow::Result<()> {
    let path = &arguments.path;
    let files = if path.is_dir() { ratings::data_files(path)? } else { vec![path.clone()] };
    let mut errors = Vec::new();
    for csv in &files {
        match repair(csv) {
            Ok(Repaired { lines, moved_to, header_restored }) => {
                let numbers: Vec<String> = lines.iter().map(usize::to_string).collect();
                let moved = moved_to.map(|path| {
                    let moved = count(lines.len() as u64, "damaged line");
                    format!("{moved} moved to {}: {}", path.display(), numbers.join(", "))
                });
                let header = header_restored.then(|| "the header was restored".to_owned());
                let done: Vec<String> = moved.into_iter().chain(header).collect();
                let done = if done.is_empty() { "no line is damaged".to_owned() } else { done.join("; ") };
                print_line(&format!("{}: {done}", csv.display()))?;
            }
            Err(error) => errors.push(error.to_string()),
        }
    }
    if errors.is_empty() { Ok(()) } else { Err(anyhow::anyhow!(errors.join("\n"))) }
}
