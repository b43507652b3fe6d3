//! Files on disk that are read as a whole, written atomically, or appended to row by row.

use std::{
    fs::{self, File, OpenOptions, TryLockError},
    io::{Error, ErrorKind, Seek as _, SeekFrom, Write as _},
    path::{Path, PathBuf},
    thread::sleep,
    time::{Duration, Instant, SystemTime},
};

use rayon::prelude::*;
use serde::de::DeserializeOwned;
use sha2::{Digest as _, Sha256};

use super::{
    FileErrors, StoreError,
    error::{NotData, io, position},
    open::{is_data, open_regular, read_at_most, read_regular},
    table::shortened,
};
use crate::system::{entries, found, remove_tree, unless_missing};

/// Maximum size in bytes of a definition, profile, observer, or table of readings or matches. The largest realistic
/// ones have a few thousand bytes; 1,000 readings have 30,000.
pub(super) const MAX_TEXT: u64 = 1 << 20;

/// Reads a whole UTF-8 file of at most 1 MiB: a definition, a profile, an observer.
///
/// # Errors
/// The same errors as [`read_bytes`]; or the text is not UTF-8, with the line and column.
pub(super) fn read_text(path: &Path) -> Result<String, FileErrors> {
    String::from_utf8(read_bytes(path, MAX_TEXT, "a readable file")?).map_err(|error| {
        let valid = error.utf8_error().valid_up_to();
        let before = String::from_utf8_lossy(&error.as_bytes()[..valid]);
        let place = position(&before, before.len());
        FileErrors::at(path, place, "is not UTF-8 text; expected UTF-8")
    })
}

/// Reads a whole file of at most `most` bytes; `expected` says what the file should be.
///
/// # Errors
/// The file is missing, is not a regular file, is too large, or is not readable.
pub(super) fn read_bytes(path: &Path, most: u64, expected: &str) -> Result<Vec<u8>, FileErrors> {
    read_regular(path, most).map_err(|error| {
        FileErrors::whole(
            path,
            match NotData::of(&error) {
                Some(NotData::Folder) => format!("is a folder; expected {expected}"),
                Some(NotData::Special) => format!("is not a regular file; expected {expected}"),
                Some(too_large) => too_large.to_string(),
                None => format!("cannot be opened: {error}; expected {expected}"),
            },
        )
    })
}

/// Reads a whole file of at most `most` bytes; `None` if it does not exist.
///
/// # Errors
/// The file is not regular, too large, or not readable.
pub(super) fn read_existing(path: &Path, most: u64) -> Result<Option<Vec<u8>>, StoreError> {
    unless_missing(read_regular(path, most)).map_err(io(path, "read"))
}

/// Parses the content of the JSON file at `path`; `what` says what it should be.
///
/// # Errors
/// It is not that, with the line and column.
pub(super) fn parse_json<T: DeserializeOwned>(path: &Path, text: &[u8], what: &str) -> Result<T, FileErrors> {
    // A list could stand for the fields of a struct.
    if text.trim_ascii_start().first().is_some_and(|first| *first != b'{') {
        return Err(FileErrors::at(path, (1, 1), format!("is not {what}; expected a JSON object")));
    }
    serde_json::from_slice(text).map_err(|error| {
        let message = format!("is not {what}: {error}; expected a JSON object");
        FileErrors::at(path, (error.line(), error.column()), message)
    })
}

/// Returns the SHA-256 in lowercase hexadecimal.
pub(super) fn sha256(bytes: &[u8]) -> String {
    hexadecimal(&Sha256::digest(bytes))
}

/// Formats bytes in lowercase hexadecimal.
pub(super) fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// The marker and the suffix in the name of a temporary file: the temporary file for `NAME` is
/// `NAME.machband-RANDOM.tmp`. Temporary files of other programs lack the marker and are never touched.
const TEMPORARY: [&str; 2] = [".machband-", ".tmp"];
/// Length of the random part; no name that people invent has it.
const RANDOM: usize = 16;

/// Returns the name of the file for which a temporary file of this program was made; `None` for any other name.
pub(super) fn temporary_for(name: &str) -> Option<&str> {
    let [marker, suffix] = TEMPORARY;
    let (name, random) = name.strip_suffix(suffix)?.rsplit_once(marker)?;
    (random.len() == RANDOM && random.bytes().all(|byte| byte.is_ascii_alphanumeric())).then_some(name)
}

/// Writes a JSON file atomically and syncs it to disk.
///
/// # Errors
/// I/O errors.
pub(super) fn write_json(path: &Path, value: &serde_json::Value) -> Result<(), StoreError> {
    let mut text = serde_json::to_vec_pretty(value).map_err(|error| io(path, "encode")(Error::other(error)))?;
    text.push(b'\n');
    write_whole(path, &text, true)
}

/// Writes a file atomically, without waiting for the disk. Use it only for files that are synced later.
///
/// # Errors
/// I/O errors.
pub(super) fn write_file(path: &Path, content: &[u8]) -> Result<(), StoreError> {
    write_whole(path, content, false)
}

/// Writes a file atomically: a reader sees either the old content or the new content, never part of it. With `durable`,
/// this also holds after a power failure; files that can be reproduced need not wait for the disk.
///
/// # Errors
/// I/O errors.
pub(super) fn write_whole(path: &Path, content: &[u8], durable: bool) -> Result<(), StoreError> {
    put(path, content, durable, true).map_err(io(path, "write"))?;
    if durable { sync_folder(path) } else { Ok(()) }
}

/// Writes a file atomically and durably if there is none. A file that another program makes at the same time stays: it may
/// be locked by now.
///
/// # Errors
/// I/O errors.
pub(super) fn write_missing(path: &Path, content: &[u8]) -> Result<(), StoreError> {
    if exists(path)? {
        return Ok(());
    }
    match put(path, content, true, false) {
        Err(error) if error.kind() == ErrorKind::AlreadyExists => {}
        written => written.map_err(io(path, "write"))?,
    }
    sync_folder(path)
}

/// Writes a file atomically, without syncing its folder. With `durable`, its content is synced. Unless it `replaces`, a file
/// that has this name is an error and stays.
///
/// # Errors
/// I/O errors; the disk stored less than it reported.
pub(super) fn put(path: &Path, content: &[u8], durable: bool, replaces: bool) -> std::io::Result<()> {
    let temporary = temporary(path, content, durable)?;
    let placed = if replaces { temporary.persist(path) } else { temporary.persist_noclobber(path) };
    let Err(failed) = placed else { return Ok(()) };
    // Some file systems can only replace.
    if !replaces && can_only_replace(&failed.error) && found(path)?.is_none() {
        return fs::rename(failed.file.path(), path);
    }
    Err(failed.error)
}

/// True if a file system can neither rename without replacing nor link.
fn can_only_replace(error: &Error) -> bool {
    /// What Linux says of links on file systems without them.
    const EPERM: i32 = 1;
    matches!(error.kind(), ErrorKind::Unsupported | ErrorKind::InvalidInput) || error.raw_os_error() == Some(EPERM)
}

/// Writes a temporary file next to `path`, and syncs it if `durable` is true. The file is removed unless it is renamed.
///
/// # Errors
/// I/O errors; the disk stored less than it reported.
fn temporary(path: &Path, content: &[u8], durable: bool) -> std::io::Result<tempfile::NamedTempFile> {
    let [marker, suffix] = TEMPORARY;
    let mut prefix = path.file_name().unwrap_or_default().to_owned();
    prefix.push(marker);
    let mut builder = tempfile::Builder::new();
    builder.prefix(&prefix).suffix(suffix).rand_bytes(RANDOM);
    // These are the permissions of a regular file; by default, only the owner could read a temporary file.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    let mut temporary = builder.tempfile_in(folder_of(path)).map_err(without_name)?;
    temporary.as_file_mut().write_all(content)?;
    if durable {
        temporary.as_file().sync_all()?;
    }
    // A disk may store less than it reports, and an incomplete file must not replace a complete one.
    let kept = temporary.as_file().metadata()?.len();
    if kept != content.len() as u64 {
        return Err(Error::other(format!("only {kept} of {} bytes were stored", content.len())));
    }
    Ok(temporary)
}

/// Returns an error without the name of the temporary file or folder, which no user knows.
fn without_name(error: Error) -> Error {
    Error::new(error.kind(), error.to_string().split(" at path ").next().unwrap_or_default())
}

/// Creates a folder and its parents, and syncs them so that they survive a power failure: if the name of a folder is
/// lost, so are the files in it.
///
/// # Errors
/// I/O errors.
pub(super) fn make_folder(path: &Path) -> Result<(), StoreError> {
    let mut missing = Vec::new();
    for folder in path.ancestors().take_while(|folder| !folder.as_os_str().is_empty()) {
        if exists(folder)? {
            break;
        }
        missing.push(folder);
    }
    fs::create_dir_all(path).map_err(io(path, "create the folder"))?;
    missing.into_iter().rev().try_for_each(sync_folder)
}

/// Returns the folder that contains a file.
pub(super) fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Returns the full path, with all links resolved, of a file or folder that may not exist yet.
///
/// # Errors
/// I/O errors; the path goes through a missing folder and back, as in `missing/../file`.
pub(super) fn full_path(path: &Path) -> std::io::Result<PathBuf> {
    let path = std::path::absolute(path)?;
    match (path.canonicalize(), path.parent(), path.file_name()) {
        (Err(error), Some(parent), Some(name)) if error.kind() == ErrorKind::NotFound => {
            Ok(full_path(parent)?.join(name))
        }
        (canonical, ..) => canonical,
    }
}

/// Syncs everything in a folder that is complete but not yet in its final place.
///
/// # Errors
/// I/O errors.
pub(super) fn sync_tree(folder: &Path) -> Result<(), StoreError> {
    // A disk serves several waiting threads at once.
    entries(folder).map_err(io(folder, "read"))?.into_par_iter().try_for_each(|path| {
        if found(&path).map_err(io(&path, "access"))?.is_some_and(|found| found.is_dir()) {
            return sync_tree(&path);
        }
        // Some systems sync only files that are open for writing.
        let opened = OpenOptions::new().append(true).open(&path);
        opened.and_then(|file| file.sync_all()).map_err(io(&path, "sync"))
    })?;
    sync_folder(&folder.join("file"))
}

/// Minimum age of a temporary file that is removed because a killed program left it. Another program may be using a newer
/// one.
pub(super) const ABANDONED: Duration = Duration::from_secs(60);
/// The same for the folder of an export.
const ABANDONED_FOLDER: Duration = Duration::from_secs(24 * 60 * 60);

/// Removes the temporary files that killed programs left in a folder, if they belong to files whose names `are_ours`, and
/// the folders of their exports. Only what has the marker of this program and is older than `age` is removed. What cannot
/// be removed does no harm.
pub(super) fn remove_temporary(folder: &Path, are_ours: impl Fn(&str) -> bool, age: Duration) {
    for path in entries(folder).into_iter().flatten() {
        let is_ours = path.file_name().and_then(|name| temporary_for(name.to_str()?)).is_some_and(&are_ours);
        // This does not follow links.
        let Some(found) = is_ours.then(|| fs::symlink_metadata(&path).ok()).flatten() else { continue };
        let age = if found.is_dir() { ABANDONED_FOLDER } else { age };
        let is_old = |time: SystemTime| age.is_zero() || time.elapsed().is_ok_and(|elapsed| elapsed > age);
        if found.modified().is_ok_and(is_old) {
            let _ = match found.file_type() {
                kind if kind.is_dir() => remove_tree(&path),
                kind if kind.is_file() => fs::remove_file(&path),
                _ => Ok(()),
            };
        }
    }
}

/// Creates a hidden temporary folder next to `path`, which only its owner can open, and removes those that killed programs
/// left there.
///
/// # Errors
/// I/O errors.
pub(super) fn temporary_folder(path: &Path) -> std::io::Result<PathBuf> {
    let (folder, [marker, suffix]) = (folder_of(path), TEMPORARY);
    let hidden = format!(".{}", path.file_name().unwrap_or_default().to_string_lossy());
    remove_temporary(folder, |name| name == hidden, ABANDONED_FOLDER);
    let prefix = format!("{hidden}{marker}");
    let made = tempfile::Builder::new().prefix(&prefix).suffix(suffix).rand_bytes(RANDOM).tempdir_in(folder);
    Ok(made.map_err(without_name)?.keep())
}

/// Makes a new or changed name in a folder survive a power failure, if the system supports this. Windows does not,
/// because it cannot open folders as files.
///
/// # Errors
/// I/O errors.
pub(super) fn sync_folder(file: &Path) -> Result<(), StoreError> {
    if !cfg!(unix) {
        return Ok(());
    }
    let folder = folder_of(file);
    let opened = match File::open(folder) {
        // Some folders accept new files but cannot be opened for reading.
        Err(error) if error.kind() == ErrorKind::PermissionDenied => return Ok(()),
        opened => opened.map_err(io(folder, "sync"))?,
    };
    match opened.sync_all() {
        // Some network shares do not support this call.
        Err(error) if matches!(error.kind(), ErrorKind::InvalidInput | ErrorKind::Unsupported) => Ok(()),
        synced => synced.map_err(io(folder, "sync")),
    }
}

/// Returns whether anything with this name exists. If the disk does not respond, this is an error and not `false`.
///
/// # Errors
/// I/O errors other than a missing file or folder.
pub(super) fn exists(path: &Path) -> Result<bool, StoreError> {
    Ok(found(path).map_err(io(path, "access"))?.is_some())
}

/// An append-only file. While it is open, it is locked against other programs.
///
/// The whole content is also kept in memory, so that nothing is lost if the disk fails or disappears: the next call
/// retries, and [`AppendFile::continue_in`] continues in a different location.
#[derive(Debug)]
pub struct AppendFile {
    path: PathBuf,
    /// The open file; `None` until the first write.
    file: Option<File>,
    content: Vec<u8>,
    /// Number of bytes of the content that are known to be in the file.
    written: usize,
    /// Number of bytes of the header.
    header: usize,
    /// True if rows are on disk when [`AppendFile::append`] returns. If false, the file is created with its first row, and a power
    /// failure may lose the last rows, because nothing waits for the disk.
    durable: bool,
    /// Keeps other programs out where the locks of the operating system do not work; `None` where they do.
    lock: Option<LockFile>,
}

impl AppendFile {
    /// Prepares a new file. The first write creates it, and never touches an existing file.
    pub(super) fn new(path: &Path, durable: bool, content: Vec<u8>) -> Self {
        let (path, header) = (path.to_owned(), content.len());
        Self { path, file: None, content, written: 0, header, durable, lock: None }
    }

    /// Opens, locks and reads a file. The file is not changed until the next write, which removes an incomplete last line; if
    /// there is no complete line yet, that write begins with `header`.
    ///
    /// # Errors
    /// [`StoreError::InUse`]; I/O errors; or the file has no complete line and does not begin with `header`.
    pub(super) fn open(path: &Path, durable: bool, header: Vec<u8>, most: u64) -> Result<Self, StoreError> {
        let mut file = OpenOptions::new().read(true).write(true).open(path).map_err(io(path, "open"))?;
        file.metadata().and_then(|found| is_data(&found)).map_err(io(path, "open"))?;
        let lock = lock(&file, path, durable)?;
        let content = read_at_most(&mut file, most).map_err(io(path, "read"))?;
        let (whole, partial_line) = split_partial_line(content);
        let (path, written, header_len) = (path.to_owned(), whole.len(), header.len());
        let content = complete_lines_or_header(&path, whole, partial_line.as_deref(), header)?;
        Ok(Self { path, file: Some(file), written, content, header: header_len, durable, lock })
    }

    /// Returns the path of the file, which may not exist yet.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Returns everything that belongs in the file, in complete lines.
    pub fn content(&self) -> &[u8] {
        &self.content
    }

    /// True if there are no rows.
    pub fn is_empty(&self) -> bool {
        self.content.len() <= self.header
    }

    /// Returns the lines that are only in memory.
    pub fn unsaved(&self) -> std::borrow::Cow<'_, str> {
        String::from_utf8_lossy(&self.content[self.written..])
    }

    /// Appends rows. They are kept in memory from now on, and they are in the file when this returns without an error.
    ///
    /// # Errors
    /// The same errors as [`AppendFile::flush`].
    pub fn append(&mut self, rows: &[u8]) -> Result<(), StoreError> {
        self.content.extend_from_slice(rows);
        self.flush()
    }

    /// Writes everything that is not in the file yet.
    ///
    /// # Errors
    /// [`StoreError::Exists`] if a new file would replace an existing one; the file is no longer the one that was written; I/O
    /// errors.
    pub fn flush(&mut self) -> Result<(), StoreError> {
        if !self.durable && self.is_empty() {
            return Ok(());
        }
        if self.file.is_some() {
            return self.write();
        }
        let made = OpenOptions::new().read(true).write(true).create_new(true).open(&self.path);
        let made = made.map_err(|error| match error.kind() {
            ErrorKind::AlreadyExists => StoreError::Exists(self.path.clone()),
            _ => io(&self.path, "create")(error),
        })?;
        // Between its creation and its lock, another program may have opened the file and written its rows.
        let locked = lock(&made, &self.path, self.durable).and_then(|lock| {
            let is_new = made.metadata().map_err(io(&self.path, "access"))?.len() == 0;
            if is_new { Ok(lock) } else { Err(StoreError::Exists(self.path.clone())) }
        });
        self.file = Some(made);
        let synced = |this: &Self| if this.durable { sync_folder(&this.path) } else { Ok(()) };
        let created = locked.map(|lock| self.lock = lock).and_then(|()| self.write()).and_then(|()| synced(self));
        if let Err(error) = &created {
            // This program has just created the file. An incomplete file must not block the next attempt, unless
            // another program uses it.
            if !matches!(error, StoreError::InUse(_) | StoreError::Exists(_)) {
                let _ = fs::remove_file(&self.path);
            }
            (self.file, self.written, self.lock) = (None, 0, None);
        }
        created
    }

    fn write(&mut self) -> Result<(), StoreError> {
        let Some(file) = &mut self.file else { return Ok(()) };
        // After a failed write, the file may contain part of a row, so return to the last known complete state.
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

    /// Checks that the file still exists with the expected length. On some systems, a program can keep writing to a
    /// file after it or its folder was deleted, and the rows are lost when the program ends. Therefore the name is
    /// looked up after each write.
    fn verify(&self) -> Result<(), StoreError> {
        let expected_file = "expected the file as this session left it";
        let changed = |what: String| FileErrors::whole(&self.path, format!("{what}; {expected_file}")).into();
        let expected = self.content.len() as u64;
        match fs::metadata(&self.path) {
            Ok(metadata) if metadata.len() == expected => Ok(()),
            Ok(metadata) => Err(changed(format!("has {} bytes instead of {expected}", metadata.len()))),
            Err(error) if error.kind() == ErrorKind::NotFound => Err(changed("no longer exists".to_owned())),
            Err(error) => Err(io(&self.path, "access")(error)),
        }
    }

    /// Writes everything that is not in the file yet, and waits until it is on disk.
    ///
    /// # Errors
    /// I/O errors.
    pub fn sync(&mut self) -> Result<(), StoreError> {
        self.flush()?;
        let synced = self.file.as_ref().map_or(Ok(()), File::sync_data);
        synced.map_err(io(&self.path, "sync"))
    }

    /// Returns what the sidecar of a session says if a lock file protects it.
    pub fn lock_incident(&self) -> Option<String> {
        let incident = "the file system of the results does not support locks; a lock file protected the session";
        self.lock.as_ref().map(|_| incident.to_owned())
    }

    /// Writes everything into a new file and continues there. The old file is not changed.
    ///
    /// # Errors
    /// The new location cannot be written. In that case, the old one stays in use.
    pub fn continue_in(&mut self, path: &Path) -> Result<(), StoreError> {
        if path == self.path {
            self.lock = None;
        }
        let mut moved = Self::new(path, self.durable, self.content.clone());
        moved.header = self.header;
        moved.flush()?;
        *self = moved;
        Ok(())
    }
}

/// Unlocks the file immediately, because a child process may still hold a copy of the open file and thus the lock.
impl Drop for AppendFile {
    fn drop(&mut self) {
        // Closing the file also unlocks it, so an error here does not matter.
        let _ = self.file.as_ref().map(File::unlock);
    }
}

/// Locks a file against other programs. Where the file system does not support locks, creates a lock file if the file is
/// `durable`.
fn lock(file: &File, path: &Path, durable: bool) -> Result<Option<LockFile>, StoreError> {
    // Another program may only be asking whether the file is locked.
    match lock_within(file, MAX_ASKING) {
        Ok(is_locked) => (durable && !is_locked).then(|| LockFile::create(path)).transpose(),
        Err(TryLockError::WouldBlock) => Err(StoreError::InUse(path.to_owned())),
        Err(TryLockError::Error(error)) => Err(io(path, "lock")(error)),
    }
}

/// Locks a file, waiting for other programs if necessary; returns false if the file system does not support locks.
fn lock_within(file: &File, most: Duration) -> Result<bool, TryLockError> {
    let started = Instant::now();
    loop {
        match file.try_lock() {
            Err(TryLockError::WouldBlock) if started.elapsed() < most => sleep(Duration::from_millis(1)),
            Err(TryLockError::Error(error)) if has_no_locks(&error) => return Ok(false),
            locked => return locked.map(|()| true),
        }
    }
}

/// How long [`held`] may keep a file locked. It needs a few microseconds.
const MAX_ASKING: Duration = Duration::from_millis(50);

/// True if an error means that the file system does not support locks, such as NFS without a lock daemon.
fn has_no_locks(error: &Error) -> bool {
    /// "No locks available".
    const ENOLCK: i32 = if cfg!(target_os = "linux") { 37 } else { 77 };
    error.kind() == ErrorKind::Unsupported || cfg!(unix) && error.raw_os_error() == Some(ENOLCK)
}

/// Suffix that is added to the name of the data file.
pub(super) const LOCK_SUFFIX: &str = ".lock";

/// That a session is being recorded.
pub(super) const RECORDING: &str = "another program is recording this session";
/// What to do about a lock file that a killed program left.
const REMEDY: &str = "if no program on any computer is writing it, remove this file";

/// The lock file of a running session, which is removed when the session ends: a file next to the rows that keeps other
/// programs from writing the same session where the locks of the operating system do not work, as on some network shares.
///
/// The file is empty. It could name the computer and the program that created it, but no program can find out whether
/// one on another computer still runs, and one on the same computer may have reused the number of a process that ended.
/// Therefore only people remove the file that a killed program left.
#[derive(Debug)]
struct LockFile(PathBuf);

impl LockFile {
    /// Creates the lock file for a data file.
    ///
    /// # Errors
    /// Another program may be writing this session; I/O errors.
    fn create(csv: &Path) -> Result<Self, StoreError> {
        let path = lock_path(csv);
        match OpenOptions::new().write(true).create_new(true).open(&path) {
            Ok(_) => Ok(Self(path)),
            Err(error) if error.kind() == ErrorKind::AlreadyExists => {
                let what = format!(
                    "means that another program is writing this session; expected it to be closed first; {REMEDY}"
                );
                Err(FileErrors::whole(path, what).into())
            }
            Err(error) => Err(io(&path, "create")(error)),
        }
    }
}

/// Returns the path of the lock file for a data file.
fn lock_path(csv: &Path) -> PathBuf {
    let mut name = csv.file_name().unwrap_or_default().to_owned();
    name.push(LOCK_SUFFIX);
    csv.with_file_name(name)
}

/// Says that another program is writing the session of a data file; `None` if none is. Where the locks of the operating
/// system work, a lock file says nothing.
///
/// # Errors
/// I/O errors.
pub(super) fn held(csv: &Path) -> Result<Option<String>, StoreError> {
    let (path, opened) = (lock_path(csv), unless_missing(open_regular(csv)).map_err(io(csv, "open"))?);
    match opened.map(|file| file.try_lock_shared().map(|()| file.unlock())) {
        None => Ok(None),
        Some(Ok(unlocked)) => unlocked.map(|()| None).map_err(io(csv, "unlock")),
        Some(Err(TryLockError::WouldBlock)) => Ok(Some(RECORDING.to_owned())),
        Some(Err(TryLockError::Error(error))) if has_no_locks(&error) => {
            Ok(exists(&path)?.then(|| format!("{RECORDING} ({} says so; {REMEDY})", path.display())))
        }
        Some(Err(TryLockError::Error(error))) => Err(io(csv, "lock")(error)),
    }
}

impl Drop for LockFile {
    fn drop(&mut self) {
        let _ = fs::remove_file(&self.0);
    }
}

/// How long to wait for other programs that use the same file. Each needs a few milliseconds.
const MAX_WAIT: Duration = Duration::from_secs(10);

/// Does something while this program holds the lock of a file that several programs share and that is never replaced.
/// Creates the file if it does not exist.
///
/// # Errors
/// The file cannot be locked; the errors of `act`.
pub(super) fn in_turn<T>(path: &Path, act: impl FnOnce() -> Result<T, StoreError>) -> Result<T, StoreError> {
    let file = OpenOptions::new().read(true).append(true).create(true).open(path).map_err(io(path, "open"))?;
    file.metadata().and_then(|found| is_data(&found)).map_err(io(path, "lock"))?;
    lock_within(&file, MAX_WAIT).map_err(|error| io(path, "lock")(error.into()))?;
    let done = act();
    // Closing the file unlocks it too, unless a child process has a copy of it.
    let _ = file.unlock();
    done
}

/// Splits the content of a row file into its complete lines and the beginning of an incomplete line.
///
/// A power failure may also leave zero bytes after or within the last line, if the system had already enlarged the file
/// but not yet filled it. Zero bytes before the last line do not come from an interrupted write, because each line was
/// on disk before the next one was written; the parser reports them.
pub(super) fn split_partial_line(mut content: Vec<u8>) -> (Vec<u8>, Option<String>) {
    let end_of_line = |content: &[u8]| content.iter().rposition(|byte| *byte == b'\n').map_or(0, |newline| newline + 1);
    let whole = end_of_line(&content);
    let last = end_of_line(&content[..whole.saturating_sub(1)]);
    let partial_line = content.split_off(if content[last..whole].contains(&0) { last } else { whole });
    let text = String::from_utf8_lossy(&partial_line).trim_end_matches('\0').to_owned();
    (content, (!partial_line.is_empty()).then_some(text))
}

/// Returns the complete lines of a row file; if there are none yet, its header.
///
/// # Errors
/// The file does not begin with this header, so it must not be truncated.
pub(super) fn complete_lines_or_header(
    path: &Path,
    whole: Vec<u8>,
    partial_line: Option<&str>,
    header: Vec<u8>,
) -> Result<Vec<u8>, FileErrors> {
    let found = partial_line.unwrap_or_default();
    if !whole.is_empty() {
        return Ok(whole);
    } else if header.starts_with(found.as_bytes()) {
        return Ok(header);
    }
    let [found, expected] = [found, &String::from_utf8_lossy(&header)].map(shortened);
    let message = format!("the file begins with {found:?} and has no line feed; expected the header {expected:?}");
    Err(FileErrors::at(path, (1, 1), message))
}
