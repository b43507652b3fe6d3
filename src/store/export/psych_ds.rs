//! Export as Psych-DS. A results folder is already such a data set; the copy contains only complete rows and describes
//! every column.

use std::{fs, path::Path};

use super::sessions::{Experiment, dataset};
use crate::{
    experiment::columns,
    store::{
        StoreError,
        dataset::{DATA_FILE, DESCRIPTION, SIDECAR_SUFFIX, describe},
        error::io,
        file::{make_folder, write_file},
        frames,
        recorded::Recorded,
        results,
    },
};

/// Files that describe a data set as a whole. Nothing else is copied, so other files next to the data stay private.
const OWN: [&str; 8] = [
    DESCRIPTION,
    "README.md",
    "CHANGES.md",
    ".psychds-ignore",
    ".psychdsignore",
    "LICENSE",
    "LICENSE.md",
    "CITATION.cff",
];

/// Writes a data set for each experiment into a subfolder of `to`.
pub(super) fn write(experiments: &[Experiment], to: &Path, notes: &mut Vec<String>) -> Result<(), StoreError> {
    for experiment in experiments {
        let folder = to.join(&experiment.name);
        copy(experiment, &folder)?;
        for session in &experiment.sessions {
            tidy(session, &folder.join("data"))?;
            if let Some(note) = describe(&folder, &session.protocol)? {
                notes.push(format!("{}: {note}", experiment.name));
            }
        }
    }
    Ok(())
}

/// Copies an experiment's sessions unchanged, together with the files that describe their data set.
pub(super) fn copy(experiment: &Experiment, folder: &Path) -> Result<(), StoreError> {
    let data = folder.join("data");
    make_folder(&data)?;
    let sources = experiment.sessions.iter().filter_map(|session| dataset(&session.csv));
    for (source, name) in sources.flat_map(|source| OWN.map(|name| (source, name))) {
        let (from, to) = (source.join(name), folder.join(name));
        if from.is_file() && !to.exists() {
            copy_file(&from, &to)?;
        }
    }
    for session in &experiment.sessions {
        let stem = session.stem();
        copy_file(&session.csv, &data.join(format!("{stem}{DATA_FILE}")))?;
        copy_file(&session.sidecar_path, &data.join(format!("{stem}{SIDECAR_SUFFIX}")))?;
        if let Some(path) = &session.frames {
            copy_file(path, &data.join(format!("{stem}{}", frames::SUFFIX)))?;
        }
    }
    Ok(())
}

/// Removes an incomplete last row, and the seal, which is then no longer valid.
fn tidy(session: &Recorded, data: &Path) -> Result<(), StoreError> {
    if session.partial_line.is_none() {
        return Ok(());
    }
    let stem = session.stem();
    let (whole, _) = results::whole(&session.csv, &columns(&session.protocol))?;
    write_file(&data.join(format!("{stem}{DATA_FILE}")), &whole)?;
    if session.sidecar.seal.is_some() {
        let mut sidecar = session.sidecar.clone();
        sidecar.seal = None;
        sidecar.write(&data.join(format!("{stem}{SIDECAR_SUFFIX}")))?;
    }
    Ok(())
}

/// Copies only the content, so that the new file is writable even if the data set is write-protected.
fn copy_file(from: &Path, to: &Path) -> Result<(), StoreError> {
    let content = fs::read(from).map_err(io(from, "read"))?;
    write_file(to, &content)
}
