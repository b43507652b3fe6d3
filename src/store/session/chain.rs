//! The chain of the sessions in a folder: each sitting names the session that ended before it. This reveals that a session
//! was deleted as a whole, which no seal can.
//!
//! The chain compares the rows of the last seal, because that seal stays in the sidecar when the session is resumed or
//! repaired, although its files change. Two sessions that end at the same time may name the same one; there is still no
//! gap.

use std::{
    fs, io,
    path::{Path, PathBuf},
    time::SystemTime,
};

use super::{
    dataset::{DATA_FILE, SIDECAR_SUFFIX},
    sidecar::Sidecar,
    sitting::Previous,
};
use crate::system::entries;

/// Returns the session that ended last in the folder of the data file `csv`, other than its own; `None` if there is none.
///
/// # Errors
/// The folder cannot be read.
pub(super) fn previous(csv: &Path) -> io::Result<Option<Previous>> {
    let own = csv.with_extension("json");
    let written = |path: PathBuf| {
        let is_other = path != own && path.to_string_lossy().ends_with(SIDECAR_SUFFIX);
        let at = is_other.then(|| fs::metadata(&path).ok()?.modified().ok()).flatten()?;
        Some((at, path))
    };
    let folder = entries(csv.parent().unwrap_or(csv))?;
    let mut others: Vec<(SystemTime, PathBuf)> = folder.into_iter().filter_map(written).collect();
    others.sort();
    Ok(others.into_iter().rev().find_map(|(_, path)| {
        let data_sha256 = Sidecar::read(&path).ok()??.last_seal()?.data_sha256.clone();
        let stem = path.file_name()?.to_str()?.strip_suffix(SIDECAR_SUFFIX)?;
        Some(Previous { data_file: format!("{stem}{DATA_FILE}"), data_sha256 })
    }))
}

/// Returns a note for each session that is named as the previous one of a sitting and is not as it was then.
pub(super) fn gaps(csv: &Path, sidecar: &Sidecar) -> Vec<String> {
    let gap = |Previous { data_file, data_sha256 }: &Previous| {
        let other = csv.with_file_name(Path::new(data_file).file_name()?);
        let what = match Sidecar::read(&other.with_extension("json")) {
            // A folder that cannot be searched says nothing about its files.
            _ if matches!(other.try_exists(), Ok(false)) => "is no longer here",
            Ok(Some(found))
                if !found.sittings.iter().flat_map(|one| &one.seal).any(|s| s.data_sha256 == *data_sha256) =>
            {
                "was replaced, or a change of it was accepted"
            }
            // `verify` reports other faults with that session.
            _ => return None,
        };
        Some(format!("{data_file}, which ended before this session, {what}"))
    };
    sidecar.sittings.iter().filter_map(|sitting| gap(sitting.previous.as_ref()?)).collect()
}
