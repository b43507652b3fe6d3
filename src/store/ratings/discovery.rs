//! Which files are meant by files and folders that were named.

use std::{
    collections::HashSet,
    path::{Path, PathBuf},
};

use crate::store::{FileFault, FileFaults, dataset::DATA_FILE, frames};

fn whole(path: &Path, message: String) -> FileFault {
    FileFault::whole(path.display().to_string(), message)
}

/// The files to read, each once, in the order they were named; those of a folder in natural order of their paths.
pub(super) fn files(paths: &[PathBuf]) -> (Vec<PathBuf>, Vec<FileFault>) {
    let (mut found, mut faults) = (Vec::new(), Vec::new());
    let mut seen = HashSet::new();
    for path in paths {
        match std::fs::metadata(path) {
            Ok(metadata) if metadata.is_dir() => match folder(path) {
                Ok(files) if files.is_empty() => {
                    faults.push(whole(path, "has no CSV file; expected a folder of result files".to_owned()));
                }
                Ok(files) => found.extend(files),
                Err(message) => faults.push(whole(path, message)),
            },
            // Named with the data files by a pattern such as `data/*.csv`.
            Ok(_) if has_suffix(path, frames::SUFFIX) => {}
            Ok(_) => found.push(path.clone()),
            Err(error) => {
                faults.push(whole(path, format!("cannot be opened: {error}; expected a CSV file or a folder of them")));
            }
        }
    }
    found.retain(|path| seen.insert(path.canonicalize().unwrap_or_else(|_| path.clone())));
    (found, faults)
}

/// The data files of all sessions in a folder and those below it, in natural order of their paths.
///
/// # Errors
/// The folder cannot be read, or has none.
pub fn data_files(root: &Path) -> Result<Vec<PathBuf>, FileFaults> {
    let fault = |message: String| FileFaults(vec![whole(root, message)]);
    let mut files = folder(root).map_err(fault)?;
    files.retain(|path| has_suffix(path, DATA_FILE));
    if files.is_empty() {
        return Err(fault("has no data file of a session; expected a results folder".to_owned()));
    }
    Ok(files)
}

/// The data files in a folder and the folders below it; where there are none, all its CSV files.
fn folder(root: &Path) -> Result<Vec<PathBuf>, String> {
    let mut files = Vec::new();
    let mut entered = HashSet::new();
    let mut open = vec![root.to_owned()];
    while let Some(folder) = open.pop() {
        // A link to a folder above would never end.
        if !entered.insert(folder.canonicalize().unwrap_or_else(|_| folder.clone())) {
            continue;
        }
        let shown = folder.display();
        let entries = std::fs::read_dir(&folder)
            .map_err(|error| format!("the folder {shown} cannot be read: {error}; expected a readable folder"))?;
        for entry in entries {
            let entry =
                entry.map_err(|error| format!("the folder {shown} cannot be read: {error}; expected all of it"))?;
            // Hidden files are other programs': `._name.csv` beside every file that a Mac put on a foreign disk.
            if entry.file_name().to_string_lossy().starts_with('.') {
                continue;
            }
            let path = entry.path();
            if path.is_dir() {
                open.push(path);
            } else if has_suffix(&path, ".csv") {
                files.push(path);
            }
        }
    }
    if files.iter().any(|path| has_suffix(path, DATA_FILE)) {
        files.retain(|path| has_suffix(path, DATA_FILE));
    }
    files.sort_by(|a, b| natural(&a.to_string_lossy(), &b.to_string_lossy()));
    Ok(files)
}

fn has_suffix(path: &Path, suffix: &str) -> bool {
    path.file_name().is_some_and(|name| name.to_string_lossy().to_ascii_lowercase().ends_with(suffix))
}

/// Natural order of texts: digits within them as whole numbers, so that S2 is before S10.
pub(super) fn natural(a: &str, b: &str) -> std::cmp::Ordering {
    let (mut left, mut right) = (a.as_bytes(), b.as_bytes());
    while let (Some(&l), Some(&r)) = (left.first(), right.first()) {
        let (digits_l, digits_r) = (digits(left), digits(right));
        let order = if digits_l > 0 && digits_r > 0 {
            let (l, r) = (significant(&left[..digits_l]), significant(&right[..digits_r]));
            (left, right) = (&left[digits_l..], &right[digits_r..]);
            l.len().cmp(&r.len()).then_with(|| l.cmp(r))
        } else {
            (left, right) = (&left[1..], &right[1..]);
            l.cmp(&r)
        };
        if order.is_ne() {
            return order;
        }
    }
    // `S01` and `S1` differ too.
    left.len().cmp(&right.len()).then_with(|| a.cmp(b))
}

fn digits(text: &[u8]) -> usize {
    text.iter().take_while(|byte| byte.is_ascii_digit()).count()
}

fn significant(digits: &[u8]) -> &[u8] {
    let zeros = digits.iter().take_while(|digit| **digit == b'0').count();
    &digits[zeros..]
}

#[cfg(test)]
mod tests {
    use super::natural;

    #[test]
    fn numbers_within_names_are_ordered_by_size() {
        let mut names = ["S10/b", "S2/b", "S2/a10", "s1", "S02/b", "S2/a9", "S"];
        names.sort_by(|a, b| natural(a, b));
        assert_eq!(names, ["S", "S2/a9", "S2/a10", "S02/b", "S2/b", "S10/b", "s1"]);
    }
}
