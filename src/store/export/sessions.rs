//! Reads and checks the sessions to export, and copies them as Psych-DS. A results folder is already such a data set; the copy
//! contains only complete rows and describes every column.

use std::{
    collections::{BTreeMap, BTreeSet},
    path::{Path, PathBuf},
};

use rayon::prelude::*;
use serde_json::{Map, Value, json};

use crate::{
    experiment::{FieldKind, columns, name_error},
    store::{
        FileError, FileErrors, StoreError,
        dataset::{
            self, DESCRIPTION, FRAMES_SUFFIX, MAX_DESCRIPTION, PARTICIPANTS, PARTICIPANTS_DESCRIBED, Participants,
            SIDECAR_SUFFIX, beside, collect, describe,
        },
        error::io,
        file::{RECORDING, make_folder, parse_json, read_existing, sha256, write_file, write_json},
        open::read_regular,
        recorded::Recorded,
        results::{self, MAX_FRAMES},
        session::seal,
    },
    system::signals,
    text::is_formula,
};

/// Files that describe a data set as a whole. Nothing else is copied, so other files next to the data stay private.
pub(super) const DESCRIBING: [&str; 9] = [
    DESCRIPTION,
    "README.md",
    "CHANGES.md",
    ".psychds-ignore",
    ".psychdsignore",
    "LICENSE",
    "LICENSE.md",
    "LICENSE.txt",
    "CITATION.cff",
];

/// An experiment with all its sessions.
pub(super) struct Experiment {
    /// Name of the experiment's definition.
    pub name: String,
    /// The sessions, in natural order of their paths.
    pub sessions: Vec<Recorded>,
}

impl Experiment {
    /// Returns the data sets of the sessions, each with the IDs of its participants.
    ///
    /// # Errors
    /// A folder cannot be accessed.
    pub fn datasets(&self) -> Result<BTreeMap<PathBuf, BTreeSet<&str>>, StoreError> {
        let mut datasets = BTreeMap::<_, BTreeSet<_>>::new();
        for session in &self.sessions {
            if let Some(dataset) = dataset::of(&session.csv)? {
                datasets.entry(dataset).or_default().insert(session.identity.subject());
            }
        }
        Ok(datasets)
    }
}

/// Refuses links among the files to export and the folders that contain them. An export is published, and a link could
/// add any file of this computer to it. `from`, which the user named, may be a link.
///
/// # Errors
/// Reports every link, and every path that cannot be accessed.
pub(super) fn refuse_links(from: &Path, files: &[PathBuf]) -> Result<(), FileErrors> {
    let mut paths = BTreeSet::new();
    for csv in files {
        paths.extend(csv.ancestors().take_while(|path| *path != from).map(Path::to_owned));
        paths.extend([SIDECAR_SUFFIX, FRAMES_SUFFIX].map(|suffix| beside(csv, suffix)));
        let names = DESCRIBING.into_iter().chain([PARTICIPANTS]);
        let dataset = dataset::of(csv).map_err(|error| FileErrors(error.errors(csv)))?;
        paths.extend(dataset.into_iter().flat_map(|dataset| names.clone().map(move |name| dataset.join(name))));
    }
    let refused = |path: &PathBuf| dataset::refuse_link(path).map_err(|error| error.errors(path)).err();
    FileErrors::none(paths.iter().filter_map(refused).flatten().collect())
}

/// Reads all sessions, or reports all their errors. Unless `accept_changes` is true, it is an error if a file was
/// changed after its session ended. Leaves out the sessions that are being recorded, with a note for each.
pub(super) fn read(
    files: &[PathBuf],
    accept_changes: bool,
    notes: &mut Vec<String>,
) -> Result<Vec<Recorded>, StoreError> {
    let open = |csv: &PathBuf| {
        signals::check(csv)?;
        Ok(Recorded::open(csv).map(|session| (errors(&session), session)))
    };
    let opened = files.par_iter().map(open).collect::<Result<Vec<_>, StoreError>>()?;
    let (mut sessions, mut wrong) = (Vec::new(), Vec::new());
    for (csv, opened) in files.iter().zip(opened) {
        let mut leave_out = |why: &str| notes.push(format!("{}: {why}; the session is left out", csv.display()));
        match opened {
            Ok((_, Recorded { running: Some(why), .. })) => leave_out(&why),
            Err(StoreError::InUse(_)) => leave_out(RECORDING),
            Ok((errors, session)) => {
                wrong.extend(errors);
                sessions.push(session);
            }
            Err(error) => wrong.extend(error.errors(csv)),
        }
    }
    FileErrors::none(wrong)?;
    let changed: Vec<FileError> = sessions.iter().flat_map(|session| session.changed.iter().cloned()).collect();
    if changed.is_empty() || accept_changes {
        return Ok(sessions);
    }
    Err(StoreError::Refused(FileErrors(changed), "accept_changes"))
}

/// Returns the reasons why a readable session must not be exported.
fn errors(session: &Recorded) -> Vec<FileError> {
    // The experiment's name becomes a folder name, and a sidecar may contain any text.
    let name = name_error(&session.protocol.name).map(|message| FileError::whole(&session.sidecar_path, message));
    let mut errors: Vec<FileError> = name.into_iter().chain(session.row_errors.iter().cloned()).collect();
    let columns = columns(&session.protocol);
    for (row, line) in session.rows.iter().zip(2..) {
        for (cell, column) in row.cells().iter().zip(&columns).filter(|(cell, _)| is_formula(cell)) {
            let message =
                format!("{} is {cell:?}, which spreadsheets treat as a formula; expected other text", column.name);
            errors.push(FileError::at(&session.csv, (line, 1), message));
        }
    }
    errors
}

/// Notes every incomplete session, and excludes it if requested. Notes every change that was accepted.
pub(super) fn chosen(mut sessions: Vec<Recorded>, complete_only: bool, notes: &mut Vec<String>) -> Vec<Recorded> {
    sessions.retain(|session| {
        let ((rated, planned), is_complete) = (session.rated(), session.is_complete());
        if is_complete || !complete_only {
            notes.extend(session.changed.iter().map(|error| format!("{error}; exported as requested")));
            let accepted = session.sidecar.incidents(seal::ACCEPTED);
            notes.extend(accepted.map(|incident| format!("{}: the experimenter {incident}", session.csv.display())));
        }
        if is_complete {
            return true;
        }
        let partial_line = if session.partial_line.is_some() { ", and the last row is incomplete" } else { "" };
        let done = if complete_only { "the session is excluded" } else { "its complete rows are exported" };
        notes
            .push(format!("{}: {rated} of {planned} trials are answered{partial_line}; {done}", session.csv.display()));
        !complete_only
    });
    sessions
}

/// Groups sessions by experiment.
///
/// # Errors
/// Two sessions would have the same path: because their names are the same, because the file system ignores case, or
/// because task names lose their hyphens.
pub(super) fn by_experiment(sessions: Vec<Recorded>) -> Result<Vec<Experiment>, FileErrors> {
    let mut places: BTreeMap<String, &Recorded> = BTreeMap::new();
    let mut subjects: BTreeMap<String, &str> = BTreeMap::new();
    let mut errors = Vec::new();
    for session in &sessions {
        let (subject, id) = (session.identity.subject(), session.identity.session());
        let known = subjects.entry(subject.to_ascii_lowercase()).or_insert(subject);
        if *known != subject {
            let message = format!(
                "participant IDs {subject} and {known} differ only in case; expected IDs that differ in more than case"
            );
            errors.push(FileError::whole(&session.csv, message));
        }
        let place = format!("{}/{subject}/{id}", session.protocol.file_task()).to_ascii_lowercase();
        if let Some(other) = places.insert(place, session) {
            let message = format!(
                "is the same session of the same task as {}; expected each session once, and experiment names that differ in more than hyphens",
                other.csv.display()
            );
            errors.push(FileError::whole(&session.csv, message));
        }
    }
    FileErrors::none(errors)?;
    let mut experiments: BTreeMap<String, Vec<Recorded>> = BTreeMap::new();
    for session in sessions {
        experiments.entry(session.protocol.name.clone()).or_default().push(session);
    }
    Ok(experiments.into_iter().map(|(name, sessions)| Experiment { name, sessions }).collect())
}

/// Writes a data set for each experiment into a subfolder of `to`.
pub(super) fn write(experiments: &[Experiment], to: &Path, notes: &mut Vec<String>) -> Result<(), StoreError> {
    for experiment in experiments {
        let folder = to.join(&experiment.name);
        copy(experiment, &folder, notes)?;
        for session in &experiment.sessions {
            // The seals are kept, because they cover only complete rows.
            if session.partial_line.is_some() {
                let to = folder.join("data").join(session.csv.file_name().unwrap_or_default());
                let (rows, _) = results::whole(&session.csv, session.data.clone(), &columns(&session.protocol))?;
                write_file(&to, &rows)?;
            }
            let undescribed = describe(&folder, &session.protocol)?;
            notes.extend(undescribed.map(|note| format!("{}: {note}", experiment.name)));
        }
    }
    Ok(())
}

/// Copies an experiment's sessions unchanged, together with the files that describe their data set and the rows of their
/// participants.
///
/// # Errors
/// The data sets are described by different files; a file changed since it was read; I/O errors.
pub(super) fn copy(experiment: &Experiment, folder: &Path, notes: &mut Vec<String>) -> Result<(), StoreError> {
    let data = folder.join("data");
    make_folder(&data)?;
    for name in DESCRIBING {
        if let Some((_, content)) = described(name, experiment)? {
            write_file(&folder.join(name), &content)?;
        }
    }
    let (participants, described) = participants(std::slice::from_ref(experiment), notes)?;
    if participants.columns.len() > 1 {
        write_file(&folder.join(PARTICIPANTS), participants.text().as_bytes())?;
        write_json(&folder.join(PARTICIPANTS_DESCRIBED), &described)?;
    }
    for session in &experiment.sessions {
        signals::check(&session.csv)?;
        let csv = data.join(session.csv.file_name().unwrap_or_default());
        write_file(&csv, &session.data)?;
        write_file(&csv.with_extension("json"), &session.sidecar_text)?;
        if let Some(path) = &session.frames {
            copy_frames(path, &beside(&csv, FRAMES_SUFFIX), session)?;
        }
    }
    Ok(())
}

/// Returns a row for each participant, and a description of the columns.
///
/// # Errors
/// A table of participants cannot be read.
pub(super) fn participants(
    experiments: &[Experiment],
    notes: &mut Vec<String>,
) -> Result<(Participants, Value), StoreError> {
    let datasets: Vec<_> = experiments.iter().map(Experiment::datasets).collect::<Result<_, _>>()?;
    let (participants, found) = collect(datasets.into_iter().flatten())?;
    notes.extend(found);
    let columns = participants.columns.iter();
    let mut described: Map<_, _> = columns.map(|name| (name.clone(), json!({ "Description": name }))).collect();
    let protocols = experiments.iter().flat_map(|one| &one.sessions).map(|session| &session.protocol);
    for field in protocols.flat_map(|protocol| &protocol.participant) {
        let (description, unit) = field.description();
        let Some(entry) = described.get_mut(&field.name) else { continue };
        entry["Description"] = description.into();
        unit.into_iter().for_each(|unit| entry["Units"] = unit.into());
        field.text.iter().for_each(|text| entry["Text"] = text.as_str().into());
        let levels = field.options().into_iter().filter(|_| field.kind() == FieldKind::Choice);
        levels.for_each(|(choice, label)| entry["Levels"][choice] = label.into());
    }
    Ok((participants, described.into()))
}

/// Returns a file that describes the data sets of an experiment, with its content; `None` if they have no such file.
///
/// # Errors
/// Two data sets have different files, or only one has the file, because each may belong to another author with another
/// license; I/O errors.
pub(super) fn described(name: &str, experiment: &Experiment) -> Result<Option<(PathBuf, Vec<u8>)>, StoreError> {
    let (mut known, mut without): (Option<(PathBuf, Vec<u8>)>, _) = (None, None);
    for dataset in experiment.datasets()?.keys() {
        let path = dataset.join(name);
        let Some(content) = read_existing(&path, MAX_DESCRIPTION)? else {
            without = Some(path);
            continue;
        };
        if name == DESCRIPTION {
            parse_json::<Map<String, Value>>(&path, &content, "the description of a data set")?;
        }
        match &known {
            None => known = Some((path, content)),
            Some((first, other)) if *other != content => return Err(different(&path, "differs from", first).into()),
            Some(_) => {}
        }
    }
    match known.as_ref().zip(without) {
        Some(((first, _), path)) => Err(different(&path, "is missing, but there is", first).into()),
        None => Ok(known),
    }
}

fn different(path: &Path, how: &str, other: &Path) -> FileErrors {
    let expected = "and an export has only one such file; expected the same content, or one export for each folder";
    FileErrors::whole(path, format!("{how} {}, {expected}", other.display()))
}

/// Copies only the content of a frames file, so that the new file is writable even if the data set is write-protected.
///
/// # Errors
/// The file changed since the session was read; I/O errors.
fn copy_frames(from: &Path, to: &Path, session: &Recorded) -> Result<(), StoreError> {
    let frames = read_regular(from, MAX_FRAMES).map_err(io(from, "read"))?;
    if session.frames_sha256.as_ref().is_some_and(|then| *then != sha256(&frames)) {
        let message = "was changed during the export; expected a session that is not being recorded";
        return Err(FileErrors::whole(from, message).into());
    }
    write_file(to, &frames)
}
