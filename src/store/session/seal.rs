//! Compares the files of a session with the hashes that were recorded each time a sitting ended. This is the only place
//! that does so.

use std::{
    collections::BTreeMap,
    io::{self, Read as _},
    path::{Path, PathBuf},
};

use sha2::{Digest as _, Sha256};

use super::{
    dataset::{DATA_FILE, SIDECAR_SUFFIX},
    frames,
    sidecar::Sidecar,
};
use crate::store::{FileError, error::NotData, file::hexadecimal, open::open_regular};

/// Maximum size of a file that is compared with a seal, in bytes. Frames of 8 hours at 480 Hz have a quarter of it.
const MAX_HASHED: u64 = 4 << 30;

/// A difference between a file and the seal of a sitting.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Difference {
    /// The file that differs.
    pub path: PathBuf,
    /// Index of the sitting that was sealed.
    pub sitting: usize,
    /// True if later sittings followed, so that the seal covers only the beginning of the file.
    pub is_prefix: bool,
    /// The recorded hash; `None` if the sitting has no seal.
    pub was: Option<String>,
    /// The hash now, or why there is none.
    pub is: Result<String, String>,
}

impl Difference {
    pub(super) fn error(&self) -> FileError {
        let since = match self.is_prefix {
            true => format!("sitting {} ended", self.sitting + 1),
            false => "the session ended".to_owned(),
        };
        let message = match (&self.was, &self.is) {
            (None, _) => format!("has no seal although {since}; expected the hashes of the files at that time"),
            (Some(was), Ok(is)) => format!("was changed since {since}: sha256 {is}; expected {was}"),
            (Some(_), Err(why)) => format!("{why}; expected the file that the session wrote"),
        };
        FileError::whole(&self.path, message)
    }

    /// Returns a message that the user accepted this difference, with both hashes.
    pub(super) fn accepted(&self) -> String {
        let file = self.path.file_name().unwrap_or_default().to_string_lossy();
        match (&self.was, &self.is) {
            (None, _) => format!("accepted that sitting {} has no seal in {file}", self.sitting + 1),
            (Some(was), Ok(is)) => format!("accepted a change of {file}: sha256 {was} when sealed, {is} now"),
            (Some(was), Err(why)) => format!("accepted a change of {file}: sha256 {was} when sealed; it {why}"),
        }
    }
}

/// Returns an error for each file of a session that differs from what the session wrote.
pub fn errors(csv: &Path, sidecar: &Sidecar) -> Vec<FileError> {
    differences(csv, sidecar).iter().map(Difference::error).collect()
}

/// Returns every difference between the files of a session and a seal, in the order of the sittings: the data file `csv`,
/// its frames file and its sidecar. The seal of the last sitting covers the whole files, and the seals of earlier
/// sittings cover their beginnings. Every sitting that ended must have a seal. Reads files in constant memory.
pub(super) fn differences(csv: &Path, sidecar: &Sidecar) -> Vec<Difference> {
    let name = csv.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let stem = name.strip_suffix(DATA_FILE).unwrap_or(&name);
    let [sidecar_path, frames] =
        [SIDECAR_SUFFIX, frames::SUFFIX].map(|suffix| csv.with_file_name(format!("{stem}{suffix}")));
    let last = sidecar.sittings.len().saturating_sub(1);
    let seals = || sidecar.sittings.iter().filter_map(|sitting| sitting.seal.as_ref());
    let of_rows = seals().next().map(|_| Prefixes::read(csv, seals().map(|seal| seal.data_bytes).collect()));
    let of_frames = seals()
        .any(|seal| seal.frames_sha256.is_some())
        .then(|| Prefixes::read(&frames, seals().filter_map(|seal| seal.frames_bytes).collect()));
    let mut found = Vec::new();
    for (sitting, entry) in sidecar.sittings.iter().enumerate() {
        let is_prefix = sitting < last;
        let Some(seal) = &entry.seal else {
            if entry.ended_at.is_some() || entry.complete {
                let (path, is) = (sidecar_path.clone(), Err("has no seal".to_owned()));
                found.push(Difference { path, sitting, is_prefix, was: None, is });
            }
            continue;
        };
        let mut compare = |path: &Path, is: Result<String, String>, was: &str| {
            if is.as_deref() != Ok(was) {
                let (path, was) = (path.to_owned(), Some(was.to_owned()));
                found.push(Difference { path, sitting, is_prefix, was, is });
            }
        };
        let hash = |of: &Option<Prefixes>, bytes: Option<u64>| {
            of.as_ref().map_or(Err("was not read".to_owned()), |of| of.hash(bytes.filter(|_| is_prefix)))
        };
        compare(csv, hash(&of_rows, Some(seal.data_bytes)), &seal.data_sha256);
        compare(&sidecar_path, Ok(sidecar.sha256_at_end_of(sitting)), &seal.sidecar_sha256);
        if let Some(was) = &seal.frames_sha256 {
            compare(&frames, hash(&of_frames, seal.frames_bytes), was);
        }
    }
    found
}

/// The hashes of the beginnings of a file.
struct Prefixes {
    /// The hash of each beginning of the file, by its length in bytes.
    of: BTreeMap<u64, String>,
    /// The hash of the whole file, or why it could not be read.
    whole: Result<String, String>,
}

impl Prefixes {
    /// Reads a file once, and computes the hashes of its beginnings with these lengths in bytes.
    fn read(path: &Path, mut lengths: Vec<u64>) -> Self {
        lengths.sort_unstable();
        let mut of = BTreeMap::new();
        let whole = Self::hashes(path, lengths, &mut of).map_err(|error| match error.kind() {
            io::ErrorKind::NotFound => "no longer exists".to_owned(),
            _ => format!("cannot be read: {error}"),
        });
        Self { of, whole }
    }

    fn hashes(path: &Path, lengths: Vec<u64>, of: &mut BTreeMap<u64, String>) -> io::Result<String> {
        let (mut file, mut hasher, mut read) = (open_regular(path)?, Sha256::new(), 0);
        let size = file.metadata()?.len();
        if size > MAX_HASHED {
            return Err(io::Error::other(NotData::TooLarge { size, most: MAX_HASHED }));
        }
        let mut buffer = vec![0; 1 << 16];
        let mut lengths = lengths.into_iter().peekable();
        loop {
            while let Some(length) = lengths.next_if_eq(&read) {
                of.insert(length, hexadecimal(&hasher.clone().finalize()));
            }
            let most = lengths.peek().map_or(u64::MAX, |next| next - read).min(buffer.len() as u64);
            let count = match file.read(&mut buffer[..most as usize]) {
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
        let whole = self.whole.clone()?;
        match bytes {
            None => Ok(whole),
            Some(bytes) => self.of.get(&bytes).cloned().ok_or(format!("has fewer than {bytes} bytes")),
        }
    }
}
