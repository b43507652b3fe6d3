//! Export as Psych-DS. A results folder is already such a data set; the copy contains only complete rows and describes
//! every column.

use std::{
    fs::File,
    path::{Path, PathBuf},
};

use serde_json::{Map, Value};

use super::sessions::{DESCRIBING, Experiment};
use crate::{
    experiment::columns,
    store::{
        FileErrors, StoreError,
        dataset::{DESCRIPTION, MAX_DESCRIPTION, PARTICIPANTS, PARTICIPANTS_DESCRIBED, beside, describe},
        error::io,
        file::{make_folder, parse_json, read_existing, write_file, write_json},
        frames,
        open::open_regular,
        participants::{Collected, collect},
        recorded::Recorded,
        results,
        session::seal,
    },
};

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
    let Collected { participants, descriptions, notes: found } = collect(experiment.datasets()?)?;
    notes.extend(found);
    if !participants.is_empty() {
        write_file(&folder.join(PARTICIPANTS), participants.text().as_bytes())?;
        write_json(&folder.join(PARTICIPANTS_DESCRIBED), &descriptions.into())?;
    }
    for session in &experiment.sessions {
        let csv = data.join(session.csv.file_name().unwrap_or_default());
        write_file(&csv, &session.data)?;
        write_file(&csv.with_extension("json"), &session.sidecar_text)?;
        if let Some(path) = &session.frames {
            copy_frames(path, &beside(&csv, frames::SUFFIX), session)?;
        }
    }
    Ok(())
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
    let mut source = open_regular(from).map_err(io(from, "read"))?;
    let mut copied = File::create_new(to).map_err(io(to, "write"))?;
    std::io::copy(&mut source, &mut copied).map_err(io(from, "copy"))?;
    if session.frames_sha256.is_some() && seal::sha256(to)? != session.frames_sha256 {
        let message = "was changed during the export; expected a session that is not being recorded";
        return Err(FileErrors::whole(from, message).into());
    }
    Ok(())
}
