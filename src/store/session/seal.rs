//! Compares the files of a session with the hashes that were recorded when it ended.

use std::{
    fs::File,
    io::{self, Write},
    path::Path,
};

use sha2::{Digest as _, Sha256};

use super::{
    dataset::{DATA_FILE, SIDECAR_SUFFIX},
    frames,
    sidecar::Sidecar,
};
use crate::store::{FileError, file::hexadecimal};

/// Returns an error for each file of a sealed session that differs from its seal: the data file `csv`, its frames file
/// and its sidecar. Without a seal, returns nothing. Reads files in constant memory.
pub fn errors(csv: &Path, sidecar: &Sidecar) -> Vec<FileError> {
    let Some(seal) = &sidecar.seal else { return Vec::new() };
    let name = csv.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let stem = name.strip_suffix(DATA_FILE).unwrap_or(&name);
    let [sidecar_path, frames] =
        [SIDECAR_SUFFIX, frames::SUFFIX].map(|suffix| csv.with_file_name(format!("{stem}{suffix}")));
    let mut errors = Vec::new();
    let mut compare = |path: &Path, is: Option<String>, was: &str| {
        let message = match is {
            Some(is) if is == was => return,
            Some(is) => format!("was changed since the session ended: sha256 {is}; expected {was}"),
            None => "no longer exists; expected the file that the session wrote".to_owned(),
        };
        errors.push(FileError::whole(path, message));
    };
    compare(csv, sha256_of(csv).ok(), &seal.data_sha256);
    compare(&sidecar_path, Some(sidecar.own_sha256()), &seal.sidecar_sha256);
    if let Some(was) = &seal.frames_sha256 {
        compare(&frames, sha256_of(&frames).ok(), was);
    }
    errors
}

/// Computes the SHA-256 of a file in constant memory, in lowercase hexadecimal.
fn sha256_of(path: &Path) -> io::Result<String> {
    let mut hasher = Hasher(Sha256::new());
    io::copy(&mut File::open(path)?, &mut hasher)?;
    Ok(hexadecimal(&hasher.0.finalize()))
}

struct Hasher(Sha256);

impl Write for Hasher {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.update(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}
