//! Files read whole, but for those that are too large.

use std::{fs::File, io::Read as _, path::Path};

use super::FileFaults;

/// Largest text file, in bytes. The largest that makes sense has a few thousand.
const LARGEST_TEXT: u64 = 1 << 20;

/// Reads a whole UTF-8 file of at most 1 MiB: a definition, a profile, an observer.
///
/// # Errors
/// As [`read_bytes`]; not UTF-8, with the line and column.
pub(super) fn read(path: &Path) -> Result<String, FileFaults> {
    String::from_utf8(read_bytes(path, LARGEST_TEXT, "a readable file")?).map_err(|error| {
        let valid = error.utf8_error().valid_up_to();
        let before = String::from_utf8_lossy(&error.as_bytes()[..valid]).into_owned();
        let mut faults = FileFaults::whole(path.display().to_string(), "is not UTF-8 text; expected UTF-8");
        faults.0[0].position = Some(position(&before, before.len()));
        faults
    })
}

/// Reads a whole file of at most `most` bytes; `expected` says what it should be.
///
/// # Errors
/// Missing, a folder, too large, or not readable.
pub(super) fn read_bytes(path: &Path, most: u64, expected: &str) -> Result<Vec<u8>, FileFaults> {
    let fail = |message: String| FileFaults::whole(path.display().to_string(), message);
    let refused = |error: std::io::Error| fail(format!("cannot be opened: {error}; expected {expected}"));
    let metadata = std::fs::metadata(path).map_err(refused)?;
    if metadata.is_dir() {
        return Err(fail(format!("is a folder; expected {expected}")));
    }
    let mut bytes = Vec::new();
    // Bounded while reading, not by the length alone: a pipe or a device has none.
    File::open(path).and_then(|file| file.take(most + 1).read_to_end(&mut bytes)).map_err(refused)?;
    if bytes.len() as u64 > most {
        let size = metadata.len().max(bytes.len() as u64);
        return Err(fail(format!("has {size} bytes; expected at most {most}")));
    }
    Ok(bytes)
}

/// Line and column, both from 1, of a byte offset.
pub(super) fn position(text: &str, offset: usize) -> (usize, usize) {
    let before = text.get(..offset).unwrap_or(text);
    let line_start = before.rfind('\n').map_or(0, |i| i + 1);
    (before.matches('\n').count() + 1, before[line_start..].chars().count() + 1)
}
