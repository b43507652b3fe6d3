//! The chain of the sessions in a folder: each sitting names the session that ended before it. This reveals that a session
//! was deleted as a whole, which no seal can.
//!
//! The chain compares the rows of the last seal, because that seal stays in the sidecar when the session is resumed or
//! repaired, although its files change. Two sessions that end at the same time may name the same one; there is still no
//! gap.

use std::path::Path;

use super::{
    dataset::{DATA_FILE, SIDECAR_SUFFIX},
    sidecar::Sidecar,
    sitting::Previous,
};
use crate::{
    store::{StoreError, error::io, file::exists},
    system::{entries, found},
};

/// Returns the session that ended last in the folder of the data file `csv`, other than its own; `None` if there is none.
///
/// # Errors
/// The folder or a sidecar in it cannot be read.
pub(super) fn previous(csv: &Path) -> Result<Option<Previous>, StoreError> {
    let own = csv.with_extension("json");
    let folder = csv.parent().unwrap_or(csv);
    let mut others = Vec::new();
    for path in entries(folder).map_err(io(folder, "read"))? {
        if path != own && path.to_string_lossy().ends_with(SIDECAR_SUFFIX) {
            let written = found(&path).and_then(|metadata| metadata.map(|found| found.modified()).transpose());
            others.extend(written.map_err(io(&path, "access"))?.map(|at| (at, path)));
        }
    }
    others.sort();
    for (_, path) in others.into_iter().rev() {
        let sidecar = Sidecar::read(&path)?;
        let stem = path.file_name().and_then(|name| name.to_str()?.strip_suffix(SIDECAR_SUFFIX));
        if let (Some(seal), Some(stem)) = (sidecar.as_ref().and_then(Sidecar::last_seal), stem) {
            let data_sha256 = seal.data_sha256.clone();
            return Ok(Some(Previous { data_file: format!("{stem}{DATA_FILE}"), data_sha256 }));
        }
    }
    Ok(None)
}

/// Returns a note for each session that is named as the previous one of a sitting and is not as it was then.
///
/// # Errors
/// Its files cannot be read.
pub(super) fn gaps(csv: &Path, sidecar: &Sidecar) -> Result<Vec<String>, StoreError> {
    let mut notes = Vec::new();
    for Previous { data_file, data_sha256 } in sidecar.sittings.iter().filter_map(|sitting| sitting.previous.as_ref()) {
        let Some(name) = Path::new(data_file).file_name() else { continue };
        let other = csv.with_file_name(name);
        let what = if exists(&other)? {
            match Sidecar::read(&other.with_extension("json")) {
                Ok(Some(found)) if !found.seals().any(|seal| seal.data_sha256 == *data_sha256) => {
                    "was replaced, or a change of it was accepted"
                }
                // `verify` reports other faults with that session.
                Ok(_) | Err(StoreError::FileErrors(_)) => continue,
                Err(error) => return Err(error),
            }
        } else {
            "is no longer here"
        };
        notes.push(format!("{data_file}, which ended before this session, {what}"));
    }
    Ok(notes)
}
