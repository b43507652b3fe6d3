//! Export as Psych-DS. A results folder is already such a data set; the copy contains only complete rows and describes
//! every column.

use std::{fs, path::Path};

use super::sessions::{DESCRIBING, Experiment};
use crate::{
    experiment::columns,
    store::{
        StoreError,
        dataset::{self, DATA_FILE, PARTICIPANTS, PARTICIPANTS_DESCRIBED, SIDECAR_SUFFIX, describe},
        error::io,
        file::{make_folder, write_file, write_json},
        frames,
        open::{open_regular, read_regular},
        participants::{Collected, collect},
        recorded::Recorded,
        results,
    },
};

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
        for name in ["README.md", "CHANGES.md"] {
            append(&folder.join(name), &changed_files([experiment]))?;
        }
    }
    Ok(())
}

/// Returns a section for a README that lists the files that were changed after their session ended; empty if there are
/// none.
pub(super) fn changed_files<'a>(experiments: impl IntoIterator<Item = &'a Experiment>) -> String {
    let lines: String =
        experiments.into_iter().flat_map(Experiment::changed).map(|line| format!("- {line}\n")).collect();
    if lines.is_empty() {
        return lines;
    }
    let version = env!("CARGO_PKG_VERSION");
    format!(
        "
## Changed files

These files differ from what the session wrote. They were exported by machband {version} as requested.

{lines}"
    )
}

/// Adds text to the end of a file that was just exported.
fn append(path: &Path, text: &str) -> Result<(), StoreError> {
    if text.is_empty() {
        return Ok(());
    }
    let mut content = fs::read(path).map_err(io(path, "read"))?;
    content.extend_from_slice(text.as_bytes());
    write_file(path, &content)
}

/// Copies an experiment's sessions unchanged, together with the files that describe their data set and the rows of their
/// participants.
pub(super) fn copy(experiment: &Experiment, folder: &Path) -> Result<(), StoreError> {
    let data = folder.join("data");
    make_folder(&data)?;
    let sources = experiment.sessions.iter().filter_map(|session| dataset::of(&session.csv));
    for (source, name) in sources.flat_map(|source| DESCRIBING.map(|name| (source, name))) {
        let (from, to) = (source.join(name), folder.join(name));
        if from.is_file() && !to.exists() {
            let content = read_regular(&from, dataset::MAX_DESCRIPTION).map_err(io(&from, "read"))?;
            write_file(&to, &content)?;
        }
    }
    let Collected { participants, descriptions, .. } = collect(experiment.datasets(), &experiment.subjects())?;
    if !participants.is_empty() {
        write_file(&folder.join(PARTICIPANTS), participants.text().as_bytes())?;
        write_json(&folder.join(PARTICIPANTS_DESCRIBED), &descriptions.into())?;
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

/// Removes an incomplete last row. The seals are kept, because they cover only complete rows.
fn tidy(session: &Recorded, data: &Path) -> Result<(), StoreError> {
    if session.partial_line.is_none() {
        return Ok(());
    }
    let stem = session.stem();
    let (whole, _) = results::whole(&session.csv, &columns(&session.protocol))?;
    write_file(&data.join(format!("{stem}{DATA_FILE}")), &whole)
}

/// Copies only the content, so that the new file is writable even if the data set is write-protected. A file of any size
/// needs no more memory.
fn copy_file(from: &Path, to: &Path) -> Result<(), StoreError> {
    let mut source = open_regular(from).map_err(io(from, "read"))?;
    let mut target = fs::File::create_new(to).map_err(io(to, "write"))?;
    std::io::copy(&mut source, &mut target).map(drop).map_err(io(to, "write"))
}
