//! Folders: what is in them, and the one that belongs to the user.

use std::{
    ffi::OsString,
    fs::{self, DirBuilder, OpenOptions},
    io,
    path::{Path, PathBuf},
};

use etcetera::{BaseStrategy as _, base_strategy::choose_native_strategy};

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
#[must_use]
pub fn data_folder() -> Option<PathBuf> {
    choose_native_strategy().ok().map(|user| user.data_dir().join("machband"))
}

/// Returns the program's folder in the user's folder for configuration, which may not exist yet:
/// `$XDG_CONFIG_HOME/machband` or `~/.config/machband` on Linux, and the platform's own folder elsewhere. `None` if the
/// user has no home folder.
#[must_use]
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
