//! Exports sessions as one complete folder.

use std::{
    collections::HashSet,
    fs,
    path::{Path, PathBuf},
};

use super::{bids, sessions};
use crate::{
    store::{
        FileErrors, StoreError, dataset,
        error::io,
        file::{exists, full_path, make_folder, sync_folder, sync_tree, temporary_folder},
        ratings::Listed,
    },
    system::{entries, found, remove_tree},
};

/// Format of an export.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Format {
    /// Brain Imaging Data Structure 1.11, behavioral data: one data set for all experiments
    Bids,
    /// Psych-DS 1.5: one data set per experiment
    PsychDs,
}

/// Which sessions are exported.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, clap::Args, serde::Serialize)]
pub struct Choice {
    /// Exclude sessions with unrated trials.
    #[arg(long)]
    pub complete_only: bool,
    /// Also export files that were changed after their session ended; the export then names them.
    #[arg(long)]
    pub accept_changes: bool,
}

/// A summary of what was exported.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Exported {
    /// Names of the experiments, sorted.
    pub experiments: Vec<String>,
    pub sessions: usize,
    pub rows: usize,
    /// Number of pictures, if the format includes them.
    pub pictures: usize,
    /// Notes for readers of the data, in the form `WHERE: what`, without duplicates.
    pub notes: Vec<String>,
}

/// Exports the sessions in `from` (a results folder, the folder of one experiment, or its `data` folder) into the new
/// or empty folder `to`.
///
/// # Errors
/// `to` is not empty or is inside the data; there is no session; a file or folder is a link; a session cannot be read,
/// was changed, or exists twice (every error in every such session is reported); a picture differs from the one that
/// was shown; I/O errors. If there is an error, nothing is written.
pub fn export(from: &Path, to: &Path, format: Format, choice: Choice) -> Result<Exported, StoreError> {
    let listed = Listed::sessions(from).complete(from)?;
    let warnings = [listed.unexpected(&[]), listed.warnings].concat();
    let files = listed.files;
    let to = target(from, to, &files)?;
    sessions::refuse_links(from, &files)?;
    let notes = warnings.iter().map(ToString::to_string).collect();
    let mut exported = Exported { notes, ..Exported::default() };
    let sessions = sessions::read(&files, choice.accept_changes, &mut exported.notes)?;
    let sessions = sessions::chosen(sessions, choice.complete_only, &mut exported.notes);
    if sessions.is_empty() {
        let why = exported.notes.join("; ");
        let message = format!("has no session to export ({why}); expected at least one that can be exported");
        return Err(FileErrors::whole(from, message).into());
    }
    (exported.sessions, exported.rows) = (sessions.len(), sessions.iter().map(|session| session.rows.len()).sum());
    let experiments = sessions::by_experiment(sessions)?;
    exported.experiments = experiments.iter().map(|experiment| experiment.name.clone()).collect();
    into_folder(&to, |folder| match format {
        Format::Bids => {
            exported.pictures = bids::write(&experiments, folder, &mut exported.notes)?;
            Ok(())
        }
        Format::PsychDs => sessions::write(&experiments, folder, &mut exported.notes),
    })?;
    let mut seen = HashSet::new();
    exported.notes.retain(|note| seen.insert(note.clone()));
    Ok(exported)
}

/// Returns the full path of the folder to write; an error if it is not empty or is inside the data.
fn target(from: &Path, to: &Path, files: &[PathBuf]) -> Result<PathBuf, StoreError> {
    let refused = |error| io(to, "read")(error);
    if let Some(metadata) = found(to).map_err(refused)? {
        if !metadata.is_dir() {
            return Err(StoreError::protected(to, "is a file; expected a new or empty folder"));
        }
        if !entries(to).map_err(refused)?.is_empty() {
            return Err(StoreError::protected(to, "is not empty; expected a new or empty folder"));
        }
    }
    let full = full_path(to).map_err(refused)?;
    let datasets: Vec<_> = files.iter().map(|csv| dataset::of(csv)).collect::<Result<_, _>>()?;
    for folder in datasets.iter().flatten().map(|folder| &**folder).chain([from]) {
        if full.starts_with(full_path(folder).map_err(refused)?) {
            let message = format!("is inside {}; expected a folder outside the data", folder.display());
            return Err(StoreError::protected(to, message));
        }
    }
    Ok(full)
}

/// Fills a temporary folder next to `to`, and renames it to `to` when it is complete and synced.
fn into_folder(to: &Path, fill: impl FnOnce(&Path) -> Result<(), StoreError>) -> Result<(), StoreError> {
    let (Some(parent), Some(name)) = (to.parent(), to.file_name()) else {
        return Err(FileErrors::whole(to, "cannot be created as a folder; expected a different path").into());
    };
    make_folder(parent)?;
    let temporary = temporary_folder(to).map_err(io(parent, "write"))?;
    let export = || {
        // The folder is inside the temporary folder because only its owner can access that one.
        let folder = temporary.join(name);
        make_folder(&folder)?;
        fill(&folder)?;
        sync_tree(&folder)?;
        if exists(to)? {
            // This fails if something was put into the folder in the meantime.
            fs::remove_dir(to).map_err(io(to, "replace"))?;
        }
        fs::rename(&folder, to).map_err(io(to, "write"))?;
        sync_folder(to)
    };
    let exported = export();
    // Anything that remains is not part of the export, and its name says that it is temporary.
    let _ = remove_tree(&temporary);
    exported.map_err(|error| match error {
        StoreError::Io { path, action, source } => {
            let inside = path.strip_prefix(&temporary);
            let path = inside.map_or_else(|_| path.clone(), |inside| parent.join(inside));
            StoreError::Io { path, action, source }
        }
        error => error,
    })
}
