//! Small text files: definitions, profiles, observers.

use std::{fs::File, io::Read as _, path::Path};

use super::FileFaults;

/// Largest file read as a definition, in bytes. The largest that makes sense has a few thousand.
const LARGEST: u64 = 1 << 20;

/// Reads a whole UTF-8 file of at most 1 MiB.
///
/// # Errors
/// Missing, a folder, too large, not UTF-8 (with the line and column), or not readable.
pub(super) fn read(path: &Path) -> Result<String, FileFaults> {
    let name = path.display().to_string();
    let fail = |message: String| FileFaults::whole(name.clone(), message);
    let metadata = std::fs::metadata(path)
        .map_err(|error| fail(format!("cannot be opened: {error}; expected a readable file")))?;
    if metadata.is_dir() {
        return Err(fail("is a folder; expected a file".to_owned()));
    }
    let mut bytes = Vec::new();
    // Bounded while reading, not by the length alone: a pipe or a device has none.
    File::open(path)
        .and_then(|file| file.take(LARGEST + 1).read_to_end(&mut bytes))
        .map_err(|error| fail(format!("cannot be read: {error}; expected a readable file")))?;
    if bytes.len() as u64 > LARGEST {
        let size = metadata.len().max(bytes.len() as u64);
        return Err(fail(format!("has {size} bytes; expected at most {LARGEST}")));
    }
    String::from_utf8(bytes).map_err(|error| {
        let valid = error.utf8_error().valid_up_to();
        let before = String::from_utf8_lossy(&error.as_bytes()[..valid]).into_owned();
        let mut faults = fail("is not UTF-8 text; expected UTF-8".to_owned());
        faults.0[0].position = Some(position(&before, before.len()));
        faults
    })
}

/// Line and column, both from 1, of a byte offset.
pub(super) fn position(text: &str, offset: usize) -> (usize, usize) {
    let before = text.get(..offset).unwrap_or(text);
    let line_start = before.rfind('\n').map_or(0, |i| i + 1);
    (before.matches('\n').count() + 1, before[line_start..].chars().count() + 1)
}
