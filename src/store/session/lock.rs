//! A file next to the rows that names the program that is writing them. It protects a session on network shares where
//! the locks of the operating system do not work, or work only within one computer.

use std::{
    fs::{self, OpenOptions},
    io::{ErrorKind, Write as _},
    path::{Path, PathBuf},
};

use crate::store::{StoreError, open::read_regular};

/// Suffix that is added to the name of the data file.
pub(super) const SUFFIX: &str = ".lock";

/// The lock file of a running session, which is removed when the session ends.
#[derive(Debug)]
pub(super) struct LockFile {
    /// `None` if the file could not be created.
    path: Option<PathBuf>,
}

impl LockFile {
    /// Creates the lock file for a data file; `is_locked` says whether the operating system also locks the data file.
    /// Replaces a lock file that a killed program left. Also returns incidents, which say which protection of the
    /// session does not work.
    ///
    /// # Errors
    /// Another program is writing this session.
    pub fn create(csv: &Path, is_locked: bool) -> Result<(Self, Vec<String>), StoreError> {
        let path = path(csv);
        let mut incidents = Vec::new();
        if !is_locked {
            incidents.push(
                "the file system of the results does not support locks; expected only one program to write this session"
                    .to_owned(),
            );
        }
        let refused = match Self::write(&path) {
            Ok(()) => return Ok((Self { path: Some(path) }, incidents)),
            Err(error) if error.kind() == ErrorKind::AlreadyExists => match writer(&path) {
                Some(writer) if writer.may_be_running(is_locked) => {
                    let what = format!(
                        "process {} on {} is writing this session; expected it to be closed first. If it is no longer running, remove this file",
                        writer.process, writer.host
                    );
                    return Err(StoreError::Mismatch { path, what });
                }
                _ => fs::remove_file(&path).and_then(|()| Self::write(&path)).err(),
            },
            Err(error) => Some(error),
        };
        let created = refused.is_none();
        // The session can continue without this second protection.
        incidents.extend(refused.map(|error| format!("{}: could not be created: {error}", path.display())));
        Ok((Self { path: created.then_some(path) }, incidents))
    }

    fn write(path: &Path) -> std::io::Result<()> {
        let mut file = OpenOptions::new().write(true).create_new(true).open(path)?;
        file.write_all(Writer::this().line().as_bytes())
    }
}

impl Drop for LockFile {
    fn drop(&mut self) {
        if let Some(path) = &self.path
            && writer(path) == Some(Writer::this())
        {
            let _ = fs::remove_file(path);
        }
    }
}

/// Removes the lock file that a killed program left next to a data file that is complete.
pub(super) fn remove_left(csv: &Path, is_locked: bool) {
    if path(csv).exists() {
        // Creating the lock replaces the leftover file, and dropping it removes the file. If its program may still be
        // running, nothing changes.
        let _ = LockFile::create(csv, is_locked);
    }
}

/// Returns the path of the lock file for a data file.
fn path(csv: &Path) -> PathBuf {
    let mut name = csv.file_name().unwrap_or_default().to_owned();
    name.push(SUFFIX);
    csv.with_file_name(name)
}

/// The program that a lock file names.
#[derive(Debug, PartialEq, Eq)]
struct Writer {
    host: String,
    process: u32,
}

impl Writer {
    fn this() -> Self {
        let host = gethostname::gethostname().to_string_lossy().split_whitespace().collect::<Vec<_>>().join("-");
        Self { host, process: std::process::id() }
    }

    fn line(&self) -> String {
        format!("{} {}\n", self.host, self.process)
    }

    /// True if the program may still be running. If this program holds the operating system's lock, no other program on
    /// the same computer is writing the session.
    fn may_be_running(&self, is_locked: bool) -> bool {
        let this = Self::this();
        if self.host != this.host {
            return true;
        }
        let is_known_to_have_ended =
            cfg!(target_os = "linux") && !Path::new("/proc").join(self.process.to_string()).exists();
        !is_locked && self.process != this.process && !is_known_to_have_ended
    }
}

/// Maximum length of a lock file in bytes; the name of a computer has at most 255 bytes.
const MAX_LENGTH: u64 = 1024;

/// Reads a lock file; `None` if it cannot be read or names no program.
fn writer(path: &Path) -> Option<Writer> {
    let text = String::from_utf8(read_regular(path, MAX_LENGTH).ok()?).ok()?;
    let (host, process) = text.trim_end().rsplit_once(' ')?;
    Some(Writer { host: host.to_owned(), process: process.parse().ok()? })
}
