//! Recorded sessions as a data set that passes a standard's validator.

use std::path::PathBuf;

use serde::Serialize;

use super::{NewFolder, Watcher};
use crate::store::export::{self, Choice, Exported, Format};

/// Export recorded sessions as a data set that passes the standard's validator.
///
/// Exports are all-or-nothing, and the same sessions always give the same bytes. Pictures are included only if their
/// hashes match what was shown. Links are never followed.
#[derive(Clone, Debug, PartialEq, Eq, clap::Args, Serialize)]
#[command(after_help = "Example: machband export results --format bids --out bids")]
pub struct Export {
    /// Results folder, or the folder of one experiment.
    #[arg(value_name = "DIR")]
    pub folder: PathBuf,
    /// Format of the data set.
    #[arg(long, value_enum)]
    pub format: Format,
    /// New or empty folder outside the data.
    #[arg(long, value_name = "DIR")]
    pub out: NewFolder,
    #[command(flatten)]
    #[serde(flatten)]
    pub choice: Choice,
}

impl Export {
    /// Writes the data set, or nothing. The watcher is warned of what a reader of the data set should know.
    ///
    /// # Errors
    /// A session cannot be read or was changed, the folder is not empty, or a file cannot be written.
    pub fn export(&self, watcher: &dyn Watcher) -> anyhow::Result<Exported> {
        let exported = export::export(&self.folder, &self.out, self.format, self.choice)?;
        exported.notes.iter().for_each(|note| watcher.warn(note));
        Ok(exported)
    }
}
