//! What is on disk, and whether it can be read.

use std::{
    fs,
    path::{Path, PathBuf},
};

use machband::{
    experiment::{TrialRecord, columns},
    store::{
        check,
        dataset::SessionPaths,
        results::{self, ResultFile},
    },
};

use crate::run::{protocol, someone};

pub fn paths(results: &Path, definition: usize) -> SessionPaths {
    SessionPaths::new(results, &protocol(definition), &someone())
}

/// Every file below a folder.
pub fn files(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).into_iter().flatten() {
        let path = entry.unwrap().path();
        if path.is_dir() { found.extend(files(&path)) } else { found.push(path) }
    }
    found.sort();
    found
}

fn ends_with(path: &Path, end: &str) -> bool {
    path.to_string_lossy().ends_with(end)
}

/// Files below a folder that cannot be read: a result file may end in half a row, a JSON file is whole.
pub fn unparsable(folder: &Path, definition: usize) -> Vec<String> {
    let wrong = |path: &PathBuf| {
        let fault = if ends_with(path, ".json") {
            serde_json::from_slice::<serde_json::Value>(&fs::read(path).unwrap()).err().map(|error| error.to_string())
        } else if ends_with(path, "_data.csv") {
            let columns = columns(&protocol(definition));
            let read = ResultFile::open(path, &columns).map_err(|error| error.to_string());
            read.and_then(|file| file.recover(&columns).map_err(|error| error.to_string())).err()
        } else {
            None
        };
        fault.map(|fault| format!("{}: {fault}", path.display()))
    };
    files(folder).iter().filter_map(wrong).collect()
}

/// Whole lines of a result file; none where there is no file.
pub fn lines(csv: &Path) -> Vec<String> {
    let text = String::from_utf8_lossy(&fs::read(csv).unwrap_or_default()).into_owned();
    let whole = text.rfind('\n').map_or("", |end| &text[..end]);
    whole.lines().map(str::to_owned).collect()
}

/// Files that a program left half done.
pub fn leftovers(folder: &Path) -> Vec<PathBuf> {
    files(folder).into_iter().filter(|path| ends_with(path, ".tmp")).collect()
}

/// What identifies a row's trial.
pub fn planned(row: &TrialRecord) -> Vec<String> {
    let cells = row.cells();
    let names: Vec<&str> = PLANNED.to_vec();
    let all = columns(&protocol(0));
    names
        .iter()
        .map(|name| all.iter().position(|column| column.name == *name).map(|i| cells[i].clone()).unwrap())
        .collect()
}

const PLANNED: [&str; 13] = [
    "row_id",
    "experiment",
    "subject_id",
    "phase",
    "block",
    "trial",
    "repetition",
    "stimulus",
    "width",
    "depth",
    "orientation_deg",
    "color",
    "seed",
];

/// What is wrong with a session that has ended: not every planned trial once, in the planned order and on one clock.
pub fn faults_of_ended(results: &Path, definition: usize, expected: &[Vec<String>]) -> Vec<String> {
    let csv = paths(results, definition).csv;
    let mut wrong = Vec::new();
    let parsed = fs::read(&csv).map_err(|error| error.to_string()).and_then(|content| {
        results::parse("rows", &content, &columns(&protocol(definition))).map_err(|error| error.to_string())
    });
    match parsed {
        Err(error) => wrong.push(error),
        Ok(rows) => {
            let found: Vec<_> = rows.iter().map(planned).collect();
            if found != expected {
                let ids = |rows: &[Vec<String>]| rows.iter().map(|row| row[0].clone()).collect::<Vec<_>>().join(" ");
                wrong.push(format!("the rows are {}; expected {}", ids(&found), ids(expected)));
            }
            if !rows.iter().map(|row| row.onset_s.0).is_sorted() {
                wrong.push("onset_s runs back".to_owned());
            }
        }
    }
    let said = check::check(&csv.display().to_string()).map(|checked| checked.sentence);
    let whole = format!("{0} of {0} planned", expected.len());
    match said {
        Ok(said) if said.contains(&whole) => {}
        Ok(said) => wrong.push(format!("{said}; expected {whole}")),
        Err(error) => wrong.push(error.to_string()),
    }
    wrong
}
