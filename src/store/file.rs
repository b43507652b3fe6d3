//! Files on disk: read as a whole, written atomically, or appended to row by row.

use std::{
    fs::{self, File, OpenOptions, TryLockError},
    io::{Error, ErrorKind, Read as _, Seek as _, SeekFrom, Write as _},
    path::{Path, PathBuf},
    time::Duration,
};

use sha2::{Digest as _, Sha256};

use super::{
    FileFault, FileFaults, StoreError,
    fault::{io, position},
    table::shortened,
};

/// Maximum size of a text file in bytes. The largest sensible one has a few thousand.
const LARGEST_TEXT: u64 = 1 << 20;

/// Reads a whole UTF-8 file of at most 1 MiB: a definition, a profile, an observer.
///
/// # Errors
/// As for [`read_bytes`]; text that is not UTF-8, with the line and column.
pub(super) fn read_text(path: &Path) -> Result<String, FileFaults> {
    String::from_utf8(read_bytes(path, LARGEST_TEXT, "a readable file")?).map_err(|error| {
        let valid = error.utf8_error().valid_up_to();
        let before = String::from_utf8_lossy(&error.as_bytes()[..valid]);
        let place = position(&before, before.len());
        FileFaults(vec![FileFault::at(path, place, "is not UTF-8 text; expected UTF-8")])
    })
}

/// Reads a whole file of at most `most` bytes; `expected` says what it should be.
///
/// # Errors
/// The file is missing, a folder, too large, or not readable.
pub(super) fn read_bytes(path: &Path, most: u64, expected: &str) -> Result<Vec<u8>, FileFaults> {
    let fail = |message: String| FileFaults::whole(path, message);
    let refused = |error: std::io::Error| fail(format!("cannot be opened: {error}; expected {expected}"));
    let metadata = std::fs::metadata(path).map_err(refused)?;
    if metadata.is_dir() {
        return Err(fail(format!("is a folder; expected {expected}")));
    }
    let mut bytes = Vec::new();
    // The limit applies while reading, since a pipe or a device has no length.
    File::open(path).and_then(|file| file.take(most + 1).read_to_end(&mut bytes)).map_err(refused)?;
    if bytes.len() as u64 > most {
        let size = metadata.len().max(bytes.len() as u64);
        return Err(fail(format!("has {size} bytes; expected at most {most}")));
    }
    Ok(bytes)
}

/// SHA-256 in lower-case hexadecimal.
pub(super) fn sha256(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}

/// Suffix of a temporary file.
pub(super) const TEMPORARY: &str = ".tmp";

/// Writes a JSON file atomically and syncs it to disk.
///
/// # Errors
/// The system's refusal.
pub fn write_json(path: &Path, value: &serde_json::Value) -> Result<(), StoreError> {
    let mut text = serde_json::to_vec_pretty(value).map_err(|error| io(path, "describe")(Error::other(error)))?;
    text.push(b'\n');
    write_whole(path, &text, true)
}

/// Writes a reproducible file atomically.
///
/// # Errors
/// The system's refusal.
pub fn write_file(path: &Path, content: &[u8]) -> Result<(), StoreError> {
    write_whole(path, content, false)
}

/// Writes a file so that a reader sees either the old one or the new one, never part of one. With `durable`, this also
/// holds after a power failure; reproducible files need not wait for the disk.
///
/// # Errors
/// The system's refusal.
pub(super) fn write_whole(path: &Path, content: &[u8], durable: bool) -> Result<(), StoreError> {
    write_beside(path, content, durable).map_err(io(path, "write"))?;
    if durable { sync_folder(path) } else { Ok(()) }
}

/// Writes a temporary file next to `path` and renames it. The temporary file is removed if anything fails.
fn write_beside(path: &Path, content: &[u8], durable: bool) -> std::io::Result<()> {
    let mut prefix = path.file_name().unwrap_or_default().to_owned();
    prefix.push(".");
    let mut builder = tempfile::Builder::new();
    builder.prefix(&prefix).suffix(TEMPORARY);
    // Permissions of a regular file; only the owner could read a temporary file.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    let mut temporary = builder.tempfile_in(folder_of(path))?;
    temporary.write_all(content)?;
    if durable {
        temporary.as_file().sync_all()?;
    }
    // A disk may store less than it reports: half a file must not replace a whole one.
    let kept = temporary.as_file().metadata()?.len();
    if kept != content.len() as u64 {
        return Err(Error::other(format!("only {kept} of {} bytes were stored", content.len())));
    }
    fs::rename(temporary.path(), path)
}

/// Creates a folder and its parents.
///
/// # Errors
/// The system's refusal.
pub(super) fn make_folder(path: &Path) -> Result<(), StoreError> {
    fs::create_dir_all(path).map_err(io(path, "make the folder"))
}

/// The folder that a file is in.
pub(super) fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Removes the temporary files with this `prefix` that killed programs left in a folder. Only files of at least this age
/// are removed, since another program may still be using its own. A file that cannot be removed does no harm.
pub(super) fn remove_temporary(folder: &Path, prefix: &str, age: Duration) {
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let name = entry.file_name();
        let is_temporary = name.to_str().is_some_and(|name| name.starts_with(prefix) && name.ends_with(TEMPORARY));
        let modified = entry.metadata().and_then(|metadata| metadata.modified());
        let is_old = age.is_zero() || modified.ok().and_then(|time| time.elapsed().ok()).is_some_and(|a| a > age);
        if is_temporary && is_old {
            let _ = fs::remove_file(entry.path());
        }
    }
}

/// Makes a new or changed name in a folder survive a power failure, if the system supports it: Windows does not open
/// folders as files.
///
/// # Errors
/// The system's refusal.
pub(super) fn sync_folder(file: &Path) -> Result<(), StoreError> {
    if !cfg!(unix) {
        return Ok(());
    }
    let folder = folder_of(file);
    let opened = match File::open(folder) {
        // A folder may accept files but not list them.
        Err(error) if error.kind() == ErrorKind::PermissionDenied => return Ok(()),
        opened => opened.map_err(io(folder, "sync"))?,
    };
    match opened.sync_all() {
        // Some network shares do not support this call.
        Err(error) if matches!(error.kind(), ErrorKind::InvalidInput | ErrorKind::Unsupported) => Ok(()),
        synced => synced.map_err(io(folder, "sync")),
    }
}

/// Whether something with this name exists. A disk that does not respond does not mean that nothing exists.
///
/// # Errors
/// The system does not answer.
pub(super) fn is_there(path: &Path) -> Result<bool, StoreError> {
    match fs::metadata(path) {
        Ok(_) => Ok(true),
        Err(error) if matches!(error.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory) => Ok(false),
        Err(error) => Err(io(path, "look for")(error)),
    }
}

/// A file that only grows, locked against a second program while it is open.
///
/// Its whole content is also kept in memory, so that nothing is lost if the disk fails or disappears: the next call
/// retries, and [`AppendFile::move_to`] continues in another location.
#[derive(Debug)]
pub(super) struct AppendFile {
    path: PathBuf,
    /// `None` until the first write.
    file: Option<File>,
    content: Vec<u8>,
    /// How many bytes of the content are known to be in the file.
    written: usize,
    /// The beginning of a line whose write was interrupted. The next write removes it.
    torn: Option<String>,
    /// Whether rows are on disk when [`AppendFile::append`] returns; if not, a power failure may lose the last ones.
    durable: bool,
}

impl AppendFile {
    /// A file that does not exist yet; the first write creates it, and never touches an existing one.
    pub fn new(path: &Path, durable: bool, content: Vec<u8>) -> Self {
        Self { path: path.to_owned(), file: None, content, written: 0, torn: None, durable }
    }

    /// Opens, locks and reads a file. It is not changed until the next write, which starts an empty file with `header`.
    ///
    /// # Errors
    /// [`StoreError::InUse`], the system's refusal, or a file without a whole line that begins otherwise.
    pub fn open(path: &Path, durable: bool, header: Vec<u8>) -> Result<Self, StoreError> {
        let mut file = OpenOptions::new().read(true).write(true).open(path).map_err(io(path, "open"))?;
        lock(&file, path)?;
        let mut content = Vec::new();
        file.read_to_end(&mut content).map_err(io(path, "read"))?;
        let (whole, torn) = split_torn(content);
        let written = whole.len();
        let content = begun(path, whole, torn.as_deref(), header)?;
        Ok(Self { path: path.to_owned(), file: Some(file), written, content, torn, durable })
    }

    /// Where the file is, or will be.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Everything that belongs in the file, as complete lines.
    pub fn content(&self) -> &[u8] {
        &self.content
    }

    /// The beginning of an interrupted line, if the file ended within one when it was opened.
    pub fn torn(&self) -> Option<&str> {
        self.torn.as_deref()
    }

    /// SHA-256 of everything that belongs in the file.
    pub fn sha256(&self) -> String {
        sha256(&self.content)
    }

    /// Adds rows. They are kept in memory from now on, and are in the file when this returns without an error.
    ///
    /// # Errors
    /// As for [`AppendFile::flush`].
    pub fn append(&mut self, rows: &[u8]) -> Result<(), StoreError> {
        self.content.extend_from_slice(rows);
        self.flush()
    }

    /// Writes what is not in the file yet.
    ///
    /// # Errors
    /// [`StoreError::Exists`] if a new file would replace another; [`StoreError::Changed`] if it is no longer the file that
    /// was written; I/O errors.
    pub fn flush(&mut self) -> Result<(), StoreError> {
        if self.file.is_some() {
            return self.write();
        }
        let made = OpenOptions::new().read(true).write(true).create_new(true).open(&self.path);
        let made = made.map_err(|error| match error.kind() {
            ErrorKind::AlreadyExists => StoreError::Exists(self.path.clone()),
            _ => io(&self.path, "create")(error),
        })?;
        let locked = lock(&made, &self.path);
        self.file = Some(made);
        let synced = |this: &Self| if this.durable { sync_folder(&this.path) } else { Ok(()) };
        let begun = locked.and_then(|()| self.write()).and_then(|()| synced(self));
        if begun.is_err() {
            // This program has just created it: half a file must not block the next attempt.
            let _ = fs::remove_file(&self.path);
            (self.file, self.written) = (None, 0);
        }
        begun
    }

    fn write(&mut self) -> Result<(), StoreError> {
        let Some(file) = &mut self.file else { return Ok(()) };
        // After a failed write, the file may contain part of a row: return to the last known complete state.
        let from = self.written as u64;
        let mut write = || {
            file.set_len(from)?;
            file.seek(SeekFrom::Start(from))?;
            file.write_all(&self.content[self.written..])?;
            if self.durable { file.sync_data() } else { Ok(()) }
        };
        write().map_err(io(&self.path, "write"))?;
        self.verify()?;
        self.written = self.content.len();
        Ok(())
    }

    /// On some systems, a file can still be written to after it or its folder was deleted, and the rows are lost when
    /// the program ends. Therefore its name is looked up after each write.
    fn verify(&self) -> Result<(), StoreError> {
        let changed = |what: String| StoreError::Changed { path: self.path.clone(), what };
        let expected = self.content.len() as u64;
        match fs::metadata(&self.path) {
            Ok(metadata) if metadata.len() == expected => Ok(()),
            Ok(metadata) => Err(changed(format!("has {} bytes instead of {expected}", metadata.len()))),
            Err(error) => Err(changed(format!("no longer exists ({error})"))),
        }
    }

    /// Writes everything into a new file and continues there. The old file is not changed.
    ///
    /// # Errors
    /// The new location cannot be written; the old one is then kept.
    pub fn move_to(&mut self, path: &Path) -> Result<(), StoreError> {
        let mut moved = Self::new(path, self.durable, self.content.clone());
        moved.flush()?;
        *self = moved;
        Ok(())
    }
}

/// Unlocks at once: a child process may still hold a copy of the open file, and with it the lock.
impl Drop for AppendFile {
    fn drop(&mut self) {
        // Closing also unlocks, so an error changes nothing.
        let _ = self.file.as_ref().map(File::unlock);
    }
}

fn lock(file: &File, path: &Path) -> Result<(), StoreError> {
    match file.try_lock() {
        Ok(()) => Ok(()),
        Err(TryLockError::WouldBlock) => Err(StoreError::InUse(path.to_owned())),
        // A file system without locks (some network shares) is no reason to refuse the session.
        Err(TryLockError::Error(error)) if error.kind() == ErrorKind::Unsupported => Ok(()),
        Err(TryLockError::Error(error)) => Err(io(path, "lock")(error)),
    }
}

/// Splits the content of a file of rows into its complete lines and the beginning of an interrupted line.
///
/// A power failure may also leave zero bytes, after or within the last line, if the system had enlarged the file but not
/// yet filled it. Zeros before the last line are not from an interrupted write, since each line was on disk before the
/// next; the parser reports them.
pub(super) fn split_torn(mut content: Vec<u8>) -> (Vec<u8>, Option<String>) {
    let end_of_line = |content: &[u8]| content.iter().rposition(|byte| *byte == b'\n').map_or(0, |newline| newline + 1);
    let whole = end_of_line(&content);
    let last = end_of_line(&content[..whole.saturating_sub(1)]);
    let torn = content.split_off(if content[last..whole].contains(&0) { last } else { whole });
    let text = String::from_utf8_lossy(&torn).trim_end_matches('\0').to_owned();
    (content, (!torn.is_empty()).then_some(text))
}

/// The complete lines of a file of rows; if there are none yet, its header.
///
/// # Errors
/// The file does not begin with this header, and so must not be truncated.
pub(super) fn begun(path: &Path, whole: Vec<u8>, torn: Option<&str>, header: Vec<u8>) -> Result<Vec<u8>, FileFaults> {
    let found = torn.unwrap_or_default();
    if !whole.is_empty() {
        return Ok(whole);
    } else if header.starts_with(found.as_bytes()) {
        return Ok(header);
    }
    let [found, expected] = [found, &String::from_utf8_lossy(&header)].map(shortened);
    let message = format!("the file begins with {found:?}; expected the header {expected:?}");
    Err(FileFaults(vec![FileFault::at(path, (1, 1), message)]))
}
