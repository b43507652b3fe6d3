//! Compares the files of a session with the hashes that were recorded each time a sitting ended, and with the chain of the
//! sessions in a folder. This is the only place that does so.

use std::path::Path;

use super::{
    dataset::{DATA_FILE, FRAMES_SUFFIX, SIDECAR_SUFFIX, beside},
    results::{self, MAX_FRAMES},
    sidecar::{Previous, Sidecar},
};
use crate::{
    store::{
        FileError, StoreError,
        error::io,
        file::{exists, read_existing, sha256},
    },
    system::{entries, found},
};

/// How the incident begins that a user accepted a change of a file.
pub(in crate::store) const ACCEPTED: &str = "accepted ";

/// When the last seal was made.
const ENDED: &str = "the session ended";

/// Returns the incident that the user accepted a difference from a seal, with both hashes.
pub(super) fn accepted(difference: &FileError) -> String {
    let file = Path::new(&difference.file).file_name().unwrap_or_default().to_string_lossy();
    format!("{ACCEPTED}that {file} {}", difference.message)
}

/// The files of a session, compared with its seals.
#[derive(Debug)]
pub(in crate::store) struct Compared {
    /// Every difference, in the order of the sittings.
    pub differences: Vec<FileError>,
    /// The index of the first sitting whose seal differs.
    pub first: Option<usize>,
    /// The SHA-256 of the frames file; `None` if it does not exist, or if neither the seals nor the incidents say whether
    /// there are frames.
    pub frames_sha256: Option<String>,
}

/// Compares the data file `csv`, whose content is `data`, the sidecar and the frames file with the seals. The seal of the last
/// sitting covers the whole files, and the seals of earlier sittings cover their beginnings. Every sitting that ended must have
/// a seal.
///
/// # Errors
/// The frames file exists but cannot be read.
pub(in crate::store) fn compare(csv: &Path, sidecar: &Sidecar, data: &[u8]) -> Result<Compared, StoreError> {
    let [sidecar_path, frames_path] = [SIDECAR_SUFFIX, FRAMES_SUFFIX].map(|suffix| beside(csv, suffix));
    let is_without_frames = is_without_frames(sidecar);
    let has_frames = is_without_frames || sidecar.seals().any(|seal| seal.frames_sha256.is_some());
    let frames = if has_frames { read_existing(&frames_path, MAX_FRAMES)? } else { None };
    let frames_sha256 = frames.as_deref().map(sha256);
    let last = sidecar.sittings.len().saturating_sub(1);
    let (mut differences, mut first) = (Vec::new(), None);
    for (sitting, entry) in sidecar.sittings.iter().enumerate() {
        let is_prefix = sitting < last;
        let since = if is_prefix { format!("sitting {} ended", sitting + 1) } else { ENDED.to_owned() };
        let Some(seal) = &entry.seal else {
            if entry.ended_at.is_some() || entry.complete {
                let message = format!("has no seal although {since}; expected the hashes of the files at that time");
                differences.push(FileError::whole(&sidecar_path, message));
                first.get_or_insert(sitting);
            }
            continue;
        };
        let rows = results::count(data);
        let lost = |path: &Path| path == csv && !is_prefix && rows < seal.data_rows;
        let mut compare = |path: &Path, is: Result<String, String>, was: &str| {
            let message = match is {
                Ok(is) if is == was => return,
                Ok(is) if lost(path) => format!(
                    "was changed since {since}: sha256 {is}; expected {was}, with {} rows instead of {rows}",
                    seal.data_rows
                ),
                Ok(is) => format!("was changed since {since}: sha256 {is}; expected {was}"),
                Err(why) => format!("{why}; expected the file with sha256 {was} that the session wrote"),
            };
            differences.push(FileError::whole(path, message));
            first.get_or_insert(sitting);
        };
        let is = if is_prefix { beginning(data, seal.data_bytes) } else { Ok(sha256(data)) };
        compare(csv, is, &seal.data_sha256);
        compare(&sidecar_path, Ok(sidecar.sha256_at_end_of(sitting)), &seal.sidecar_sha256);
        if let Some(was) = &seal.frames_sha256 {
            let is = match (seal.frames_bytes.filter(|_| is_prefix), &frames) {
                (_, None) => Err("no longer exists".to_owned()),
                (Some(bytes), Some(frames)) => beginning(frames, bytes),
                (None, Some(_)) => Ok(frames_sha256.clone().unwrap_or_default()),
            };
            compare(&frames_path, is, was);
        }
    }
    if let Some(sha256) = frames_sha256.as_ref().filter(|_| is_without_frames) {
        let expected = "expected only the files of the session";
        let message = format!("is in no seal, so it was added after {ENDED}: sha256 {sha256}; {expected}");
        differences.push(FileError::whole(&frames_path, message));
        first.get_or_insert(last);
    }
    Ok(Compared { differences, first, frames_sha256 })
}

/// Returns the hash of the first `bytes` bytes of a file.
fn beginning(content: &[u8], bytes: u64) -> Result<String, String> {
    let end = usize::try_from(bytes).unwrap_or(usize::MAX);
    content.get(..end).map(sha256).ok_or_else(|| format!("has fewer than {end} bytes"))
}

/// True if no frames file belongs to a session: every sitting is sealed without one, and no incident tells of one.
fn is_without_frames(sidecar: &Sidecar) -> bool {
    let tells = |incident: &String| {
        incident.starts_with("the frames ") || incident.starts_with(ACCEPTED) && incident.contains(FRAMES_SUFFIX)
    };
    sidecar.sittings.iter().all(|sitting| {
        let is_sealed = sitting.seal.as_ref().is_some_and(|seal| seal.frames_sha256.is_none());
        is_sealed && !sitting.incidents.iter().any(tells)
    })
}

// Each sitting names the session that ended before it, which reveals that a session was deleted as a whole, as no seal can.
// This chain compares the rows of the last seal, because that seal stays in the sidecar when the session is resumed or
// repaired, although its files change. Two sessions that end at the same time may name the same one; there is still no gap.

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
        if let (Some(seal), Some(stem)) = (sidecar.as_ref().and_then(|sidecar| sidecar.seals().next_back()), stem) {
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
