//! Folders and files: whether they exist, what is in them, and the folders that belong to the user.

use std::{
    ffi::OsString,
    fs::{self, DirBuilder, Metadata, OpenOptions},
    io::{self, ErrorKind},
    path::{Path, PathBuf},
};

use etcetera::{BaseStrategy as _, base_strategy::choose_native_strategy};

/// Returns the metadata of a file or folder, with links followed; `None` only if there is nothing with this name. A disk
/// that does not respond is an error, and so is a folder that may not be searched.
///
/// # Errors
/// I/O errors other than a missing file or folder.
pub fn found(path: &Path) -> io::Result<Option<Metadata>> {
    unless_missing(fs::metadata(path))
}

/// Identifies a file or folder by its device and inode number, which are the same for all paths that lead to it,
/// including links and hard links.
#[cfg(unix)]
type FileId = (u64, u64);
/// The full path. Replacing one of several hard links does not change the content under the other names.
#[cfg(not(unix))]
type FileId = PathBuf;

/// Returns the identity of a file or folder; `None` if it does not exist.
///
/// # Errors
/// I/O errors other than a missing file or folder.
pub fn identified(path: &Path) -> io::Result<Option<FileId>> {
    let metadata = found(path)?;
    #[cfg(unix)]
    return Ok(metadata.map(|found| {
        use std::os::unix::fs::MetadataExt as _;
        (found.dev(), found.ino())
    }));
    #[cfg(not(unix))]
    return metadata.map(|_| path.canonicalize()).transpose();
}

/// Returns where a link leads; `None` if there is no link with this name.
///
/// # Errors
/// I/O errors other than a missing file or folder.
pub fn link_target(path: &Path) -> io::Result<Option<PathBuf>> {
    match unless_missing(fs::symlink_metadata(path))? {
        // The file is known to be a link.
        #[allow(clippy::disallowed_methods)]
        Some(metadata) if metadata.is_symlink() => fs::read_link(path).map(Some),
        _ => Ok(None),
    }
}

/// Returns what was found; `None` if there is nothing with this name.
///
/// # Errors
/// Any other error.
pub fn unless_missing<T>(result: io::Result<T>) -> io::Result<Option<T>> {
    match result {
        Err(error) if matches!(error.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory) => Ok(None),
        result => result.map(Some),
    }
}

/// True if a file or folder is known to belong to another user.
pub fn is_of_another_user(path: &Path) -> bool {
    #[cfg(unix)]
    return fs::symlink_metadata(path)
        .is_ok_and(|found| std::os::unix::fs::MetadataExt::uid(&found) != rustix::process::geteuid().as_raw());
    #[cfg(not(unix))]
    return false;
}

/// Returns whether this user may create files in a folder, as far as can be known without writing to it.
pub fn may_write(folder: &Path) -> bool {
    #[cfg(unix)]
    return rustix::fs::access(folder, rustix::fs::Access::WRITE_OK | rustix::fs::Access::EXEC_OK).is_ok();
    #[cfg(not(unix))]
    return fs::metadata(folder).is_ok_and(|found| !found.permissions().readonly());
}

/// Returns the paths of everything in a folder, sorted.
///
/// # Errors
/// The folder does not exist or cannot be read, or this is not a folder.
pub fn entries(folder: &Path) -> io::Result<Vec<PathBuf>> {
    let mut paths: Vec<PathBuf> = names(folder)?.into_iter().map(|name| folder.join(name)).collect();
    paths.sort();
    Ok(paths)
}

#[cfg(unix)]
fn names(folder: &Path) -> io::Result<Vec<OsString>> {
    use std::os::unix::{ffi::OsStringExt as _, fs::OpenOptionsExt as _};

    use rustix::fs::{Dir, OFlags};

    let flags = (OFlags::DIRECTORY | OFlags::NONBLOCK).bits().cast_signed();
    let opened = OpenOptions::new().read(true).custom_flags(flags).open(folder)?;
    let mut names = Vec::new();
    for entry in Dir::new(opened)? {
        names.push(OsString::from_vec(entry?.file_name().to_bytes().to_vec()));
    }
    names.retain(|name| name != "." && name != "..");
    Ok(names)
}

#[cfg(not(unix))]
fn names(folder: &Path) -> io::Result<Vec<OsString>> {
    fs::read_dir(folder)?.map(|entry| entry.map(|entry| entry.file_name())).collect()
}

/// Removes a folder and everything in it. Links are removed, not followed.
///
/// # Errors
/// I/O errors. The standard library's function ends the program if a folder cannot be closed.
pub fn remove_tree(folder: &Path) -> io::Result<()> {
    for path in entries(folder)? {
        if fs::symlink_metadata(&path)?.is_dir() { remove_tree(&path)? } else { fs::remove_file(&path)? }
    }
    fs::remove_dir(folder)
}

/// Returns the program's folder in the user's folder for data, which may not exist yet: `$XDG_DATA_HOME/machband` or
/// `~/.local/share/machband` on Linux, and the platform's own folder elsewhere. `None` if the user has no home folder.
pub fn data_folder() -> Option<PathBuf> {
    choose_native_strategy().ok().map(|user| user.data_dir().join("machband"))
}

/// Returns the program's folder in the user's folder for configuration, which may not exist yet:
/// `$XDG_CONFIG_HOME/machband` or `~/.config/machband` on Linux, and the platform's own folder elsewhere. `None` if the
/// user has no home folder.
pub fn config_folder() -> Option<PathBuf> {
    choose_native_strategy().ok().map(|user| user.config_dir().join("machband"))
}

/// Creates a folder and its parents. Only the user can open the folders that it creates (mode 700).
///
/// # Errors
/// I/O errors.
pub fn make_private_folder(path: &Path) -> io::Result<()> {
    let mut builder = DirBuilder::new();
    builder.recursive(true);
    #[cfg(unix)]
    std::os::unix::fs::DirBuilderExt::mode(&mut builder, 0o700);
    builder.create(path)
}
