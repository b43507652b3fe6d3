//! Recorded sessions in the forms that others expect: BIDS, Psych-DS, PsychoPy's wide CSV, Parquet. Equal sessions give
//! equal bytes; a folder that is there is whole.

mod bids;
mod parquet;
mod psych_ds;
mod psychopy;
mod stimuli;

use std::{
    collections::BTreeMap,
    fs,
    path::{Path, PathBuf},
};

use rayon::prelude::*;

use super::{FileFault, FileFaults, StoreError, fault::io, ratings, recorded::Recorded, table::is_formula};
use crate::experiment::{columns, name_fault};

/// What a data set is exported as.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Brain Imaging Data Structure 1.11, behavioural data: one data set for all experiments.
    Bids,
    /// Psych-DS 1.5: a data set for each experiment.
    PsychDs,
    /// A wide CSV for each session, as PsychoPy writes it.
    Psychopy,
    /// A Parquet file for each experiment.
    Parquet,
}

/// What was written.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Exported {
    /// Names of the experiments, in their order.
    pub experiments: Vec<String>,
    /// Sessions.
    pub sessions: usize,
    /// Their rows.
    pub rows: usize,
    /// Pictures, where the format has any.
    pub pictures: usize,
    /// What whoever reads the data should know, each as `WHERE: what`.
    pub notes: Vec<String>,
}

/// An experiment with all its sessions.
struct Experiment {
    /// Name of its definition.
    name: String,
    /// In natural order of their paths.
    sessions: Vec<Recorded>,
}

impl Experiment {
    /// Whether its sessions have one definition, and so the same columns with the same meaning.
    fn has_one_definition(&self) -> bool {
        self.sessions.iter().all(|session| session.protocol == self.sessions[0].protocol)
    }
}

/// Exports the sessions in `from`, a results folder, that of one experiment, or its `data` folder, into the new or empty
/// folder `to`. `complete_only` leaves out sessions with trials that are not rated.
///
/// # Errors
/// `to` holds something or lies in the data; no session; every fault of every session that cannot be read, was changed,
/// or is there twice; pictures that are not those that were shown; the system's refusal. Nothing is written then.
pub fn export(from: &Path, to: &Path, format: Format, complete_only: bool) -> Result<Exported, StoreError> {
    let files = ratings::data_files(from)?;
    let to = target(from, to, &files)?;
    let sessions = read(&files)?;
    let mut exported = Exported::default();
    let sessions = chosen(sessions, complete_only, &mut exported.notes);
    if sessions.is_empty() {
        return Err(FileFaults::whole(
            from.display().to_string(),
            "has no session that is complete; expected one, or no --complete-only",
        )
        .into());
    }
    (exported.sessions, exported.rows) = (sessions.len(), sessions.iter().map(|session| session.rows.len()).sum());
    let experiments = by_experiment(sessions);
    distinct(&experiments)?;
    exported.experiments = experiments.iter().map(|experiment| experiment.name.clone()).collect();
    into_folder(&to, |folder| match format {
        Format::Bids => bids::write(&experiments, folder, &mut exported),
        Format::PsychDs => psych_ds::write(&experiments, folder, &mut exported),
        Format::Psychopy => psychopy::write(&experiments, folder),
        Format::Parquet => parquet::write(&experiments, folder),
    })?;
    Ok(exported)
}

/// The folder to write, by its full path; refused where it holds anything, or lies where sessions are looked for.
fn target(from: &Path, to: &Path, files: &[PathBuf]) -> Result<PathBuf, StoreError> {
    let fault = |message: String| FileFaults::whole(to.display().to_string(), message);
    let refused = |error| io(to, "read")(error);
    if to.exists() {
        if !to.is_dir() {
            return Err(fault("is a file; expected a new or empty folder".to_owned()).into());
        }
        if fs::read_dir(to).map_err(refused)?.next().is_some() {
            return Err(fault("is not empty; expected a new or empty folder".to_owned()).into());
        }
    }
    let full = canonical(to).map_err(refused)?;
    let data = files.iter().filter_map(|csv| dataset(csv));
    for folder in data.chain([from]) {
        if full.starts_with(canonical(folder).map_err(refused)?) {
            let message = format!("lies in {}; expected a folder outside the data", folder.display());
            return Err(fault(message).into());
        }
    }
    Ok(full)
}

/// The full path of what may not be there yet, without links.
fn canonical(path: &Path) -> std::io::Result<PathBuf> {
    let full = std::path::absolute(path)?;
    let mut missing = Vec::new();
    let mut there = full.as_path();
    while !there.exists() {
        match (there.parent(), there.components().next_back()) {
            (Some(parent), Some(last)) => {
                missing.push(last);
                there = parent;
            }
            _ => return Ok(full),
        }
    }
    let mut path = there.canonicalize()?;
    for part in missing.into_iter().rev() {
        match part {
            std::path::Component::ParentDir => _ = path.pop(),
            part => path.push(part),
        }
    }
    Ok(path)
}

/// The data set that a data file belongs to: the folder around its `data`.
fn dataset(csv: &Path) -> Option<&Path> {
    let data = csv.parent()?;
    (data.file_name()? == "data").then(|| data.parent())?
}

/// Reads all sessions, or names all their faults.
fn read(files: &[PathBuf]) -> Result<Vec<Recorded>, FileFaults> {
    let read: Vec<_> = files
        .par_iter()
        .map(|csv| match Recorded::open(csv) {
            Ok(recorded) => {
                let faults = faults(&recorded);
                if faults.is_empty() { Ok(recorded) } else { Err(faults) }
            }
            Err(StoreError::Faults(FileFaults(faults))) => Err(faults),
            Err(error) => Err(vec![fault(csv, None, error.to_string())]),
        })
        .collect();
    let (mut sessions, mut faults) = (Vec::new(), Vec::new());
    for one in read {
        match one {
            Ok(recorded) => sessions.push(recorded),
            Err(found) => faults.extend(found),
        }
    }
    if faults.is_empty() { Ok(sessions) } else { Err(FileFaults(faults)) }
}

fn fault(path: &Path, position: Option<(usize, usize)>, message: String) -> FileFault {
    FileFault { file: path.display().to_string(), position, message }
}

/// What keeps a session that can be read from leaving its folder.
fn faults(recorded: &Recorded) -> Vec<FileFault> {
    let mut faults = Vec::new();
    // The name becomes that of a folder, and a sidecar may say anything.
    if let Some(message) = name_fault(&recorded.protocol.name) {
        faults.push(fault(&recorded.sidecar_path, None, message));
    }
    let columns = columns(&recorded.protocol);
    for (index, row) in recorded.rows.iter().enumerate() {
        let at = Some((index + 2, 1));
        if let Err(message) = row.planned_trial(&recorded.context()) {
            faults.push(fault(&recorded.csv, at, message));
        }
        for (cell, column) in row.cells().iter().zip(&columns).filter(|(cell, _)| is_formula(cell)) {
            let message = format!(
                "{} is {cell:?}, which spreadsheets take for a formula; expected a text that begins otherwise",
                column.name
            );
            faults.push(fault(&recorded.csv, at, message));
        }
    }
    faults
}

/// Leaves out what is not complete where that is asked, and notes what is not.
fn chosen(sessions: Vec<Recorded>, complete_only: bool, notes: &mut Vec<String>) -> Vec<Recorded> {
    let mut kept = Vec::new();
    for session in sessions {
        let (rated, planned) = rated(&session);
        if rated == planned && session.torn.is_none() {
            kept.push(session);
            continue;
        }
        let torn = if session.torn.is_some() { ", and a row that is half written" } else { "" };
        let done = if complete_only { "it is left out" } else { "its whole rows are exported" };
        notes.push(format!("{}: {rated} of {planned} trials are rated{torn}; {done}", session.csv.display()));
        if !complete_only {
            kept.push(session);
        }
    }
    kept
}

/// Planned trials that are rated, and all that are planned.
fn rated(session: &Recorded) -> (usize, usize) {
    let trials: std::collections::BTreeSet<_> =
        session.rows.iter().filter_map(|row| row.planned_trial(&session.context()).ok()).collect();
    (trials.len(), session.schedule.trials.len())
}

fn by_experiment(sessions: Vec<Recorded>) -> Vec<Experiment> {
    let mut experiments: BTreeMap<String, Vec<Recorded>> = BTreeMap::new();
    for session in sessions {
        experiments.entry(session.protocol.name.clone()).or_default().push(session);
    }
    experiments.into_iter().map(|(name, sessions)| Experiment { name, sessions }).collect()
}

/// No two sessions may claim one place: neither by their names, nor where a file system does not tell upper from lower
/// case, nor where names of tasks lose their hyphens.
fn distinct(experiments: &[Experiment]) -> Result<(), FileFaults> {
    let mut places: BTreeMap<String, &Recorded> = BTreeMap::new();
    let mut subjects: BTreeMap<String, &str> = BTreeMap::new();
    let mut faults = Vec::new();
    for session in experiments.iter().flat_map(|experiment| &experiment.sessions) {
        let (subject, id) = (session.identity.subject(), session.identity.session());
        let known = subjects.entry(subject.to_ascii_lowercase()).or_insert(subject);
        if *known != subject {
            let message = format!(
                "participant {subject} and participant {known} differ in upper and lower case only; expected names that differ otherwise"
            );
            faults.push(fault(&session.csv, None, message));
        }
        let place = format!("{}/{}/{}", session.protocol.task(), subject, id).to_ascii_lowercase();
        if let Some(other) = places.insert(place, session) {
            let message = format!(
                "is the same session of the same task as {}; expected each once, and experiments whose names differ in more than hyphens",
                other.csv.display()
            );
            faults.push(fault(&session.csv, None, message));
        }
    }
    if faults.is_empty() { Ok(()) } else { Err(FileFaults(faults)) }
}

/// Lets a folder be filled under another name beside its place, and moves it there when it is whole.
fn into_folder(to: &Path, fill: impl FnOnce(&Path) -> Result<(), StoreError>) -> Result<(), StoreError> {
    if let Some(parent) = to.parent() {
        fs::create_dir_all(parent).map_err(io(parent, "make the folder"))?;
    }
    let name = to.file_name().unwrap_or_default().to_string_lossy();
    let temporary = to.with_file_name(format!(".{name}.{}.tmp", std::process::id()));
    fs::create_dir(&temporary).map_err(io(&temporary, "make the folder"))?;
    let filled = fill(&temporary).and_then(|()| {
        if to.exists() {
            // Fails where something was put there meanwhile.
            fs::remove_dir(to).map_err(io(to, "replace"))?;
        }
        fs::rename(&temporary, to).map_err(io(to, "write"))
    });
    if filled.is_err() {
        // Of no use; that it may stay behind on a broken disk changes nothing: it is hidden, and named as temporary.
        let _ = fs::remove_dir_all(&temporary);
    }
    filled
}

fn make_folder(path: &Path) -> Result<(), StoreError> {
    fs::create_dir_all(path).map_err(io(path, "make the folder"))
}

/// Notes as they stand in an [`Exported`]: several of one kind would hide the others.
fn note_once(notes: &mut Vec<String>, note: String) {
    if !notes.contains(&note) {
        notes.push(note);
    }
}
