//! Sessions that can be resumed although lines of their data were damaged.

use std::path::PathBuf;

use serde::Serialize;

use super::{Found, Watcher};
use crate::store::{FileErrors, dataset::refuse_link, ratings::Listed, session};

/// Move damaged lines of a session's data file to a file next to it, so that the session can be resumed.
///
/// A line is damaged if it cannot be read, if the definition and the seed do not plan it, or if it repeats a row. A damaged header is replaced. No byte is deleted: the lines go to a new file
/// …_data.csv.damaged-N. The sidecar records the repair, or that rows are missing, and machband verify lists it. When the
/// session is resumed, it shows the trials of these rows again. If the lines were damaged after their sitting ended, machband
/// verify reports that the file was changed, and resuming needs --accept-changes.
#[derive(Clone, Debug, PartialEq, Eq, clap::Args, Serialize)]
#[command(after_help = "Example: machband repair results/quick/data/subject-S001_session-1_task-quick_data.csv")]
pub struct Repair {
    /// Data file of a session, or a folder with data files.
    #[arg(value_name = "FILE|DIR")]
    pub path: PathBuf,
}

impl Repair {
    /// Moves the damaged lines of each data file to a file next to it.
    ///
    /// # Errors
    /// The folder cannot be read, or the watcher ended it. A file that cannot be repaired is among the errors found.
    pub fn repair(&self, watcher: &dyn Watcher) -> anyhow::Result<Found> {
        let path = &self.path;
        let mut all = Found::default();
        let listed = Listed::sessions(path);
        if listed.files.is_empty() && listed.errors.is_empty() {
            return Err(listed.nothing(path).into());
        }
        listed.warnings.iter().for_each(|warning| watcher.warn(&warning.to_string()));
        all.errors.extend(listed.errors.into_iter().map(|error| FileErrors(vec![error]).into()));
        for csv in &listed.files {
            let mut inside = csv.ancestors().take_while(|part| part != path);
            match inside.try_for_each(refuse_link).and_then(|()| session::repair(csv)) {
                Ok(repaired) => all.add(csv, repaired.to_string(), watcher)?,
                Err(error) => all.errors.push(error),
            }
        }
        Ok(all)
    }
}
