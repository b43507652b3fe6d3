//! Writes every file that the user named, in a command or on a page, without destroying anything.

use std::{
    collections::BTreeSet,
    fs, io,
    path::{Path, PathBuf},
};

use rayon::prelude::*;

use super::{
    StoreError,
    dataset::{DATA_FILE, DESCRIPTION, FRAMES_SUFFIX, SIDECAR_SUFFIX, identity},
    error::io,
    file::{ABANDONED, exists, folder_of, full_path, make_folder, put, remove_temporary, sync_folder},
};
use crate::system::{found, identified};

/// Writes the outputs of one command or page.
///
/// It never writes over an input of the same call, a file of a session, a file in a data set, or anything that is not a
/// regular file. It replaces other files only if it is allowed to.
#[derive(Clone, Debug, Default)]
pub struct Writer {
    inputs: Vec<PathBuf>,
    pub(super) force: bool,
}

impl Writer {
    /// Creates a writer for a call that reads the files and folders `inputs`; with `force`, it replaces existing files.
    pub fn new(inputs: impl IntoIterator<Item = PathBuf>, force: bool) -> Self {
        Self { inputs: inputs.into_iter().collect(), force }
    }

    /// Returns a writer that replaces existing files.
    pub(super) fn replacing(&self) -> Self {
        Self { force: true, ..self.clone() }
    }

    /// Checks before work starts that the files can be written. Another program may still change this, so
    /// [`Writer::write`] checks it again.
    ///
    /// # Errors
    /// [`StoreError::Occupied`] for an existing file; [`StoreError::Protected`] for a file that is never replaced, or
    /// two outputs that are the same file; I/O errors, such as a missing folder.
    pub fn check<'a>(&self, paths: impl IntoIterator<Item = &'a Path>) -> Result<(), StoreError> {
        let mut seen = BTreeSet::new();
        for path in paths {
            if !seen.insert(self.target(path)?) {
                let what = "is another output of this command; expected a different file";
                return Err(StoreError::protected(path, what));
            }
        }
        Ok(())
    }

    /// Checks before work starts that files may be written into this folder, which need not exist yet.
    ///
    /// # Errors
    /// [`StoreError::Protected`] if it is an input, belongs to the data of a data set, or is not a folder; I/O errors.
    pub fn check_folder(&self, folder: &Path) -> Result<(), StoreError> {
        let target = full_path(folder).map_err(io(folder, "access"))?;
        if found(&target).map_err(io(folder, "access"))?.is_some_and(|found| !found.is_dir()) {
            return Err(StoreError::protected(folder, "is not a folder; expected a folder for the files to write"));
        }
        if self.reads(&target)? {
            return Err(StoreError::protected(folder, "is an input of this command; expected a different folder"));
        }
        data_set(&target)?.filter(|(_, is_data)| *is_data).map_or(Ok(()), |(root, _)| Err(in_data(folder, &root)))
    }

    /// Creates a folder and its parents.
    ///
    /// # Errors
    /// The same errors as [`Writer::check_folder`].
    pub fn make_folder(&self, folder: &Path) -> Result<(), StoreError> {
        self.check_folder(folder)?;
        make_folder(folder)
    }

    /// Writes a file. When this returns, the file survives a power failure; at any moment, the path has either its old
    /// content or the new content. Removes what killed programs left when they wrote this file.
    ///
    /// # Errors
    /// The same errors as [`Writer::check`]; I/O errors.
    pub fn write(&self, path: &Path, content: &[u8]) -> Result<(), StoreError> {
        self.put(path, content)?;
        settle(&[path])
    }

    /// Writes several files like [`Writer::write`]. Writes none of them if one of them cannot be written according to
    /// [`Writer::check`].
    ///
    /// # Errors
    /// The same errors as [`Writer::write`].
    pub fn write_all(&self, files: &[(PathBuf, Vec<u8>)]) -> Result<(), StoreError> {
        self.check(files.iter().map(|(path, _)| path.as_path()))?;
        // A disk serves several waiting threads at once.
        files.par_iter().try_for_each(|(path, content)| self.put(path, content))?;
        settle(&files.iter().map(|(path, _)| path.as_path()).collect::<Vec<_>>())
    }

    /// Writes and syncs a file but not its folder, so a power failure may lose the name of a new file.
    ///
    /// # Errors
    /// The same errors as [`Writer::write`].
    pub(super) fn put(&self, path: &Path, content: &[u8]) -> Result<(), StoreError> {
        let target = self.target(path)?;
        put(&target, content, true, self.force).map_err(|error| match error.kind() {
            io::ErrorKind::AlreadyExists if !self.force => StoreError::Occupied(path.to_owned()),
            _ => io(path, "write")(error),
        })
    }

    /// Returns the file that a path leads to, with all links resolved, if it can be written.
    fn target(&self, path: &Path) -> Result<PathBuf, StoreError> {
        let refuse = |what: &str| Err(StoreError::protected(path, what));
        if let Some(ending) = path.extension().and_then(|ending| ending.to_str()).filter(|ending| is_foreign(ending)) {
            let what = "which is never written; expected a name ending in .png or, for a chart, .svg";
            return refuse(&format!("ends in .{ending}, {what}"));
        }
        let target = full_path(path).map_err(io(path, "write"))?;
        fs::metadata(folder_of(&target)).map_err(io(path, "write"))?;
        let found = match fs::symlink_metadata(&target) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => None,
            found => Some(found.map_err(io(path, "write"))?),
        };
        if let Some((root, is_data)) = data_set(&target)? {
            if is_data {
                return Err(in_data(path, &root));
            } else if found.is_some() {
                return refuse(&format!("belongs to the data set {}; expected a new file", root.display()));
            }
        }
        if let Some(session) = session_of(&target)? {
            return refuse(&format!("belongs to the session of {}; expected a different file", session.display()));
        }
        match found {
            None => Ok(target),
            // The output of the program may lead to a regular file.
            Some(found) if !found.is_file() || ["/dev/stdout", "/dev/stderr"].map(Path::new).contains(&path) => {
                refuse("is not a regular file; expected a new file or an existing regular file")
            }
            Some(_) if self.reads(&target)? => refuse("is an input of this command; expected a different file"),
            Some(_) if !self.force => Err(StoreError::Occupied(path.to_owned())),
            Some(_) => Ok(target),
        }
    }

    /// True if this file or folder is an input.
    fn reads(&self, target: &Path) -> Result<bool, StoreError> {
        let identified = |path: &Path| identified(path).map_err(io(path, "access"));
        let Some(own) = identified(target)? else { return Ok(false) };
        for input in &self.inputs {
            if identified(input)?.as_ref() == Some(&own) {
                return Ok(true);
            }
        }
        Ok(false)
    }
}

/// Syncs the folders of files that were written, and removes the temporary files of killed programs that wrote them.
fn settle(paths: &[&Path]) -> Result<(), StoreError> {
    let folders: BTreeSet<&Path> = paths.iter().map(|path| folder_of(path)).collect();
    let names: BTreeSet<_> = paths.iter().filter_map(|path| path.file_name()?.to_str()).collect();
    folders.into_iter().try_for_each(|folder| {
        remove_temporary(folder, |name| names.contains(name), ABANDONED);
        sync_folder(&folder.join("file"))
    })
}

/// Returns whether a name with this ending promises a picture in a format that nothing here writes.
fn is_foreign(ending: &str) -> bool {
    const FOREIGN: [&str; 8] = ["jpg", "jpeg", "gif", "bmp", "tif", "tiff", "webp", "exr"];
    FOREIGN.iter().any(|foreign| ending.eq_ignore_ascii_case(foreign))
}

fn in_data(path: &Path, root: &Path) -> StoreError {
    let root = root.display();
    StoreError::protected(path, format!("is inside the data folder of the data set {root}; expected a path outside it"))
}

/// Returns the folder of the data set that contains `target`, and whether `target` is in its `data` folder.
fn data_set(target: &Path) -> Result<Option<(PathBuf, bool)>, StoreError> {
    let mut nearest = None;
    for root in target.ancestors().skip(1) {
        if exists(&root.join(DESCRIPTION))? {
            let is_data = target.strip_prefix(root).is_ok_and(|path| path.starts_with("data"));
            // One data set may contain another, as an export does in `sourcedata`.
            if is_data {
                return Ok(Some((root.to_owned(), true)));
            }
            nearest.get_or_insert_with(|| (root.to_owned(), false));
        }
    }
    Ok(nearest)
}

/// Returns the file of a session next to which `target` belongs: its sidecar or, if `target` is named like a file of a
/// session, any of its files.
fn session_of(target: &Path) -> Result<Option<PathBuf>, StoreError> {
    let name = target.file_name().and_then(|name| name.to_str()).unwrap_or_default();
    let suffixes = [SIDECAR_SUFFIX, DATA_FILE, FRAMES_SUFFIX];
    let Some(stem) = suffixes.iter().find_map(|suffix| name.strip_suffix(suffix)) else { return Ok(None) };
    let [sidecar, csv, frames] = suffixes.map(|suffix| target.with_file_name(format!("{stem}{suffix}")));
    let is_named = identity(&csv).is_ok();
    for path in [sidecar].into_iter().chain([csv, frames].into_iter().filter(|_| is_named)) {
        if exists(&path)? {
            return Ok(Some(path));
        }
    }
    Ok(None)
}
