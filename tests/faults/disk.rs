//! Reads what a session left on disk and reports what is wrong with it.

use std::{
    fs,
    path::{Path, PathBuf},
    time::{Duration, SystemTime},
};

use machband::{
    experiment::{TrialRecord, columns},
    store::{check, dataset::SessionPaths, results},
};

use crate::{
    common::everything,
    run::{identity, protocol},
};

pub fn paths(results: &Path, definition: usize) -> SessionPaths {
    SessionPaths::new(results, &protocol(definition), &identity())
}

/// Every file below a folder whose name ends with `end`, and its content.
fn files(folder: &Path, end: &str) -> Vec<(PathBuf, Vec<u8>)> {
    let mut found = if folder.exists() { everything(folder) } else { Vec::new() };
    found.retain(|(path, _)| path.to_string_lossy().ends_with(end));
    found
}

/// Files below a folder that cannot be read. A result file may end in an incomplete row; a JSON file must be complete.
pub fn unparsable(folder: &Path, definition: usize) -> Vec<String> {
    let json = files(folder, ".json").into_iter().map(|(path, content)| {
        (path, serde_json::from_slice::<serde_json::Value>(&content).err().map(|error| error.to_string()))
    });
    let rows = files(folder, "_data.csv").into_iter().map(|(path, _)| {
        let columns = columns(&protocol(definition));
        let read = results::read(&path, &columns).map_err(|error| error.to_string());
        (path, read.err())
    });
    json.chain(rows).filter_map(|(path, fault)| Some(format!("{}: {}", path.display(), fault?))).collect()
}

/// The texts of the sidecars below a folder.
pub fn sidecars(folder: &Path) -> Vec<String> {
    files(folder, "_data.json").into_iter().map(|(_, text)| String::from_utf8_lossy(&text).into_owned()).collect()
}

/// The complete lines of a result file; empty if there is no file.
pub fn lines(csv: &Path) -> Vec<String> {
    let text = String::from_utf8_lossy(&fs::read(csv).unwrap_or_default()).into_owned();
    let whole = text.rfind('\n').map_or("", |end| &text[..end]);
    whole.lines().map(str::to_owned).collect()
}

/// The rows among these that are not in a result file.
pub fn lost(csv: &Path, rows: &[String]) -> Vec<String> {
    let kept = lines(csv);
    rows.iter().filter(|row| !kept.contains(row)).map(|row| format!("lost: {row}")).collect()
}

/// The unfinished temporary files that a program left.
pub fn temporary_files(folder: &Path) -> Vec<PathBuf> {
    files(folder, ".tmp").into_iter().map(|(path, _)| path).collect()
}

/// Lets an hour pass for the temporary files in a folder, so that they are old enough to be removed.
pub fn age_temporary_files(folder: &Path) {
    let hour_ago = SystemTime::now() - Duration::from_secs(3600);
    for path in temporary_files(folder) {
        fs::File::options().write(true).open(path).unwrap().set_modified(hour_ago).unwrap();
    }
}

pub fn rows(csv: &Path, definition: usize) -> Result<Vec<TrialRecord>, String> {
    let content = fs::read(csv).map_err(|error| error.to_string())?;
    results::parse("rows", &content, &columns(&protocol(definition))).map_err(|error| error.to_string())
}

/// The cells that identify a row's trial.
pub fn planned(row: &TrialRecord) -> Vec<String> {
    let columns = columns(&protocol(0));
    let cells = columns.iter().zip(row.cells());
    cells.filter(|(column, _)| PLANNED.split(' ').any(|name| name == column.name)).map(|(_, cell)| cell).collect()
}

const PLANNED: &str =
    "row_id experiment subject_id phase block trial repetition stimulus width depth orientation_deg color seed";

/// The faults of a finished session, which must have every planned trial once, in the planned order and on one clock.
pub fn faults_of_ended(results: &Path, definition: usize, expected: &[Vec<String>]) -> Vec<String> {
    let csv = paths(results, definition).csv;
    let mut wrong = Vec::new();
    match rows(&csv, definition) {
        Err(error) => wrong.push(error),
        Ok(rows) => {
            let found: Vec<_> = rows.iter().map(planned).collect();
            if found != expected {
                let ids = |rows: &[Vec<String>]| rows.iter().map(|row| row[0].clone()).collect::<Vec<_>>().join(" ");
                wrong.push(format!("the rows are {}; expected {}", ids(&found), ids(expected)));
            }
            if !rows.iter().map(|row| row.onset_s.0).is_sorted() {
                wrong.push("onset_s goes back".to_owned());
            }
        }
    }
    let whole = format!("{0} of {0} planned", expected.len());
    match check::check(csv.display().to_string()) {
        Ok(checked) if checked.sentence.contains(&whole) => {}
        Ok(checked) => wrong.push(format!("{}; expected {whole}", checked.sentence)),
        Err(error) => wrong.push(error.to_string()),
    }
    wrong
}
