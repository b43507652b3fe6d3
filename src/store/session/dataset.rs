//! The results folder of an experiment: a Psych-DS data set.

use std::{
    fs,
    path::{Path, PathBuf},
    time::Duration,
};

use super::{description, frames};
use crate::{
    experiment::{Identity, Protocol},
    store::{
        StoreError,
        file::{make_folder, remove_temporary},
    },
};

/// Ends the name of a data file of a Psych-DS data set, as our results are.
pub const DATA_FILE: &str = "_data.csv";
/// Ends the name of a sidecar.
pub(crate) const SIDECAR_SUFFIX: &str = "_data.json";

/// Where the files of one session are.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SessionPaths {
    /// `RESULTS/NAME`, the data set.
    pub dataset: PathBuf,
    /// The rows.
    pub csv: PathBuf,
    /// Everything else about the session.
    pub sidecar: PathBuf,
    /// Every frame interval.
    pub frames: PathBuf,
}

impl SessionPaths {
    /// The contract's names below a results folder.
    pub fn new(results: &Path, protocol: &Protocol, identity: &Identity) -> Self {
        let dataset = results.join(&protocol.name);
        let stem = format!("subject-{}_session-{}_task-{}", identity.subject(), identity.session(), protocol.task());
        let data = dataset.join("data");
        Self {
            csv: data.join(format!("{stem}{DATA_FILE}")),
            sidecar: data.join(format!("{stem}{SIDECAR_SUFFIX}")),
            frames: data.join(format!("{stem}{}", frames::SUFFIX)),
            dataset,
        }
    }

    /// Makes the folders and describes the data set, if nobody has yet. If its description cannot be read, says so in a
    /// sentence.
    ///
    /// # Errors
    /// The folder cannot be made or written; a link.
    pub fn prepare(&self, protocol: &Protocol) -> Result<Option<String>, StoreError> {
        self.refuse_links()?;
        let data = self.dataset.join("data");
        make_folder(&data)?;
        // Other programs may be describing the data set too.
        remove_temporary(&self.dataset, "", Duration::from_secs(60));
        description::describe(&self.dataset, protocol)
    }

    /// Nothing below the results folder may lead out of it: anyone who puts a link there could decide where a session is
    /// written, or read what they must not. The results folder itself may be a link.
    ///
    /// # Errors
    /// The first link.
    pub(crate) fn refuse_links(&self) -> Result<(), StoreError> {
        let data = self.dataset.join("data");
        for path in [&self.dataset, &data, &self.csv, &self.sidecar, &self.frames] {
            if let Ok(target) = fs::read_link(path) {
                return Err(StoreError::Link { path: path.clone(), target });
            }
        }
        Ok(())
    }
}

/// The first of `P001`, `P002`, … that has no file in this experiment's results.
pub fn free_participant(results: &Path, protocol: &Protocol) -> String {
    let taken: Vec<String> = fs::read_dir(results.join(&protocol.name).join("data"))
        .into_iter()
        .flatten()
        .flatten()
        .filter_map(|entry| {
            let name = entry.file_name().into_string().ok()?;
            Some(name.strip_prefix("subject-")?.split('_').next()?.to_ascii_uppercase())
        })
        .collect();
    (1..).map(|number| format!("P{number:03}")).find(|id| !taken.contains(id)).unwrap_or_default()
}

/// The part of a data file's name before `_data.csv`, and the participant and session in it.
pub(crate) fn identity(csv: &Path) -> Result<(String, Identity), String> {
    let name = csv.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let expected = "expected a data file such as subject-S001_session-1_task-quick_data.csv";
    let stem = name.strip_suffix(DATA_FILE).ok_or_else(|| format!("is named otherwise; {expected}"))?;
    let part = |key: &str| stem.split('_').find_map(|part| part.strip_prefix(key)?.strip_prefix('-'));
    let (Some(subject), Some(session)) = (part("subject"), part("session")) else {
        return Err(format!("its name has no subject or session; {expected}"));
    };
    let identity = Identity::new(subject, session).map_err(|error| error.to_string())?;
    Ok((stem.to_owned(), identity))
}
