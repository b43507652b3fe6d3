//! Compares the files of a session with the hashes that were recorded each time a sitting ended, and with the chain of the
//! sessions in a folder. This is the only place that does so.

use std::{
    collections::BTreeMap,
    fs::File,
    io::{self, Read},
    path::Path,
};

use sha2::{Digest as _, Sha256};

use super::{
    dataset::{DATA_FILE, FRAMES_SUFFIX, SIDECAR_SUFFIX, beside},
    sidecar::{Previous, Sidecar},
};
use crate::{
    store::{
        FileError, StoreError,
        error::{NotData, io},
        file::{exists, hexadecimal},
        open::{Complete, open_regular},
    },
    system::{entries, found},
};

/// How the incident begins that a user accepted a change of a file.
pub(in crate::store) const ACCEPTED: &str = "accepted ";

/// When the last seal was made.
const ENDED: &str = "the session ended";

/// Maximum size of a file that is compared with a seal, in bytes. Frames of 8 hours at 480 Hz have a quarter of it.
const MAX_HASHED: u64 = 4 << 30;

/// Returns the incident that the user accepted a difference from a seal, with both hashes.
pub(super) fn accepted(difference: &FileError) -> String {
    let file = Path::new(&difference.file).file_name().unwrap_or_default().to_string_lossy();
    format!("{ACCEPTED}that {file} {}", difference.message)
}

/// Returns an error for each file of a session that differs from what the session wrote.
///
/// # Errors
/// A file exists but cannot be read.
pub fn errors(csv: &Path, sidecar: &Sidecar) -> Result<Vec<FileError>, StoreError> {
    Ok(Hashes::read(csv, sidecar, None)?.differences(csv, sidecar).into_iter().map(|(_, error)| error).collect())
}

/// Returns the SHA-256 of a file; `None` if it does not exist. Reads it in constant memory.
///
/// # Errors
/// The file exists but cannot be read.
pub fn sha256(path: &Path) -> Result<Option<String>, StoreError> {
    Ok(Prefixes::of(path, open(path), Vec::new())?.whole)
}

/// The hashes of a session's files.
pub(super) struct Hashes {
    rows: Prefixes,
    /// `None` if neither the seals nor the incidents say whether there are frames.
    frames: Option<Prefixes>,
}

impl Hashes {
    /// Reads the files, each once and in constant memory. `data` is the data file, if it was read already.
    ///
    /// # Errors
    /// A file exists but cannot be read.
    pub fn read(csv: &Path, sidecar: &Sidecar, data: Option<&[u8]>) -> Result<Self, StoreError> {
        let lengths = sidecar.seals().map(|seal| seal.data_bytes).collect();
        let rows = match data {
            Some(data) => Prefixes::of(csv, Ok(data), lengths)?,
            None => Prefixes::of(csv, open(csv), lengths)?,
        };
        let frames = beside(csv, FRAMES_SUFFIX);
        let lengths = sidecar.seals().filter_map(|seal| seal.frames_bytes).collect();
        let has_frames = sidecar.seals().any(|seal| seal.frames_sha256.is_some());
        let frames = (has_frames || is_without_frames(sidecar))
            .then(|| Prefixes::of(&frames, open(&frames), lengths))
            .transpose()?;
        Ok(Self { rows, frames })
    }

    /// Returns the hash of the whole frames file, if it was compared with the seals and exists.
    pub fn of_frames(&self) -> Option<&str> {
        self.frames.as_ref()?.whole.as_deref()
    }

    /// Returns every difference from the seals with the index of its sitting, in the order of the sittings: the data file
    /// `csv`, the sidecar and the frames file. The seal of the last sitting covers the whole files, and the seals of earlier
    /// sittings cover their beginnings. Every sitting that ended must have a seal.
    pub fn differences(&self, csv: &Path, sidecar: &Sidecar) -> Vec<(usize, FileError)> {
        let [sidecar_path, frames] = [SIDECAR_SUFFIX, FRAMES_SUFFIX].map(|suffix| beside(csv, suffix));
        let last = sidecar.sittings.len().saturating_sub(1);
        let mut found = Vec::new();
        for (sitting, entry) in sidecar.sittings.iter().enumerate() {
            let is_prefix = sitting < last;
            let since = if is_prefix { format!("sitting {} ended", sitting + 1) } else { ENDED.to_owned() };
            let Some(seal) = &entry.seal else {
                if entry.ended_at.is_some() || entry.complete {
                    let message =
                        format!("has no seal although {since}; expected the hashes of the files at that time");
                    found.push((sitting, FileError::whole(&sidecar_path, message)));
                }
                continue;
            };
            let mut compare = |path: &Path, is: Result<String, String>, was: &str| {
                let message = match is {
                    Ok(is) if is == was => return,
                    Ok(is) => format!("was changed since {since}: sha256 {is}; expected {was}"),
                    Err(why) => format!("{why}; expected the file with sha256 {was} that the session wrote"),
                };
                found.push((sitting, FileError::whole(path, message)));
            };
            compare(csv, self.rows.hash(is_prefix.then_some(seal.data_bytes)), &seal.data_sha256);
            compare(&sidecar_path, Ok(sidecar.sha256_at_end_of(sitting)), &seal.sidecar_sha256);
            if let (Some(was), Some(hashes)) = (&seal.frames_sha256, &self.frames) {
                compare(&frames, hashes.hash(seal.frames_bytes.filter(|_| is_prefix)), was);
            }
        }
        let added = self.of_frames().filter(|_| is_without_frames(sidecar));
        found.extend(added.map(|is| {
            let message = format!(
                "is in no seal, so it was added after {ENDED}: sha256 {is}; expected only the files of the session"
            );
            (last, FileError::whole(&frames, message))
        }));
        found
    }
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

/// Opens a file that is compared with a seal.
fn open(path: &Path) -> io::Result<Complete<File>> {
    let file = open_regular(path)?;
    let size = file.metadata()?.len();
    if size > MAX_HASHED {
        Err(io::Error::other(NotData::TooLarge { size, most: MAX_HASHED }))
    } else {
        Complete::of(file)
    }
}

/// The hashes of the beginnings of a file.
struct Prefixes {
    /// The hash of each beginning of the file, by its length in bytes.
    of: BTreeMap<u64, String>,
    /// The hash of the whole file; `None` if it does not exist.
    whole: Option<String>,
}

impl Prefixes {
    /// Reads what was opened at `path`, and computes the hashes of its beginnings with these lengths in bytes.
    ///
    /// # Errors
    /// The file exists but cannot be read.
    fn of(path: &Path, opened: io::Result<impl Read>, mut lengths: Vec<u64>) -> Result<Self, StoreError> {
        lengths.sort_unstable();
        let mut of = BTreeMap::new();
        match opened.and_then(|source| Self::hashes(source, lengths, &mut of)) {
            Ok(whole) => Ok(Self { of, whole: Some(whole) }),
            Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(Self { of, whole: None }),
            Err(error) => Err(StoreError::io(path, "read", error)),
        }
    }

    fn hashes(mut source: impl Read, lengths: Vec<u64>, of: &mut BTreeMap<u64, String>) -> io::Result<String> {
        let (mut hasher, mut read) = (Sha256::new(), 0);
        let mut buffer = vec![0; 1 << 16];
        let mut lengths = lengths.into_iter().peekable();
        loop {
            while let Some(length) = lengths.next_if_eq(&read) {
                of.insert(length, hexadecimal(&hasher.clone().finalize()));
            }
            let most = lengths.peek().map_or(u64::MAX, |next| next - read).min(buffer.len() as u64);
            let count = match source.read(&mut buffer[..most as usize]) {
                Ok(0) => return Ok(hexadecimal(&hasher.finalize())),
                Ok(count) => count,
                Err(error) if error.kind() == io::ErrorKind::Interrupted => continue,
                Err(error) => return Err(error),
            };
            hasher.update(&buffer[..count]);
            read += count as u64;
        }
    }

    /// Returns the hash of the first `bytes` bytes, or of the whole file if `bytes` is `None`.
    fn hash(&self, bytes: Option<u64>) -> Result<String, String> {
        let whole = self.whole.clone().ok_or("no longer exists")?;
        match bytes {
            None => Ok(whole),
            Some(bytes) => self.of.get(&bytes).cloned().ok_or(format!("has fewer than {bytes} bytes")),
        }
    }
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
