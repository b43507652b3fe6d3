//! A file next to the rows that keeps other programs from writing the same session where the locks of the operating system
//! do not work, as on some network shares.
//!
//! The file is empty. It could name the computer and the program that created it, but no program can find out whether
//! one on another computer still runs, and one on the same computer may have reused the number of a process that ended.
//! Therefore only people remove the file that a killed program left.

use std::{
    fs::{self, OpenOptions},
    io::ErrorKind,
    path::{Path, PathBuf},
};

use crate::store::{
    FileErrors, StoreError,
    file::{self, exists},
};

/// Suffix that is added to the name of the data file.
pub(super) const SUFFIX: &str = ".lock";

/// That a session is being recorded.
pub(in crate::store) const RECORDING: &str = "another program is recording this session";
/// What to do about a lock file that a killed program left.
const REMEDY: &str = "if no program on any computer is writing it, remove this file";

/// The lock file of a running session, which is removed when the session ends.
#[derive(Debug)]
pub(super) struct LockFile(PathBuf);

impl LockFile {
    /// Creates the lock file for a data file, unless the operating system already locks the data file (`is_locked`). Also
    /// returns an incident that says how the session is protected without that lock.
    ///
    /// # Errors
    /// Another program may be writing this session.
    pub fn create(csv: &Path, is_locked: bool) -> Result<(Option<Self>, Option<String>), StoreError> {
        if is_locked {
            return Ok((None, None));
        }
        let path = path(csv);
        let unlocked = "the file system of the results does not support locks";
        match OpenOptions::new().write(true).create_new(true).open(&path) {
            Ok(_) => Ok((Some(Self(path)), Some(format!("{unlocked}; a lock file protected the session")))),
            Err(error) if error.kind() == ErrorKind::AlreadyExists => {
                let what = format!(
                    "means that another program is writing this session; expected it to be closed first; {REMEDY}"
                );
                Err(FileErrors::whole(path, what).into())
            }
            Err(error) => {
                let path = path.display();
                Ok((
                    None,
                    Some(format!(
                        "{unlocked}, and {path} could not be created: {error}; expected only one program to write this session"
                    )),
                ))
            }
        }
    }
}

/// Returns the path of the lock file for a data file.
fn path(csv: &Path) -> PathBuf {
    let mut name = csv.file_name().unwrap_or_default().to_owned();
    name.push(SUFFIX);
    csv.with_file_name(name)
}

/// Says that another program is writing the session of a data file; `None` if none is. Where the locks of the operating
/// system work, a lock file says nothing.
///
/// # Errors
/// I/O errors.
pub(super) fn held(csv: &Path) -> Result<Option<String>, StoreError> {
    let path = path(csv);
    Ok(match file::is_locked(csv)? {
        Some(is_locked) => is_locked.then(|| RECORDING.to_owned()),
        None => exists(&path)?.then(|| format!("{RECORDING} ({} says so; {REMEDY})", path.display())),
    })
}

impl Drop for LockFile {
    fn drop(&mut self) {
        let _ = fs::remove_file(&self.0);
    }
}
