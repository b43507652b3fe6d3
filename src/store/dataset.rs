//! The results folder of an experiment: a Psych-DS data set.

use std::{
    fs::{self, File},
    io::Write as _,
    path::{Path, PathBuf},
    time::Duration,
};

use super::{StoreError, description, fault::io, frames, ratings::DATA_FILE};
use crate::experiment::{Identity, Protocol};

/// Ends the name of a sidecar.
pub(super) const SIDECAR_SUFFIX: &str = "_data.json";

/// Where the files of one session are.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SessionPaths {
    /// `RESULTS/NAME`, the data set.
    pub dataset: PathBuf,
    /// The rows.
    pub csv: PathBuf,
    /// Everything else that is known of the session.
    pub sidecar: PathBuf,
    /// Every frame interval.
    pub frames: PathBuf,
}

impl SessionPaths {
    /// The contract's names below a results folder.
    pub fn new(results: &Path, protocol: &Protocol, identity: &Identity) -> Self {
        let dataset = results.join(&protocol.name);
        let stem = format!("subject-{}_session-{}_task-{}", identity.subject(), identity.session(), protocol.task());
        let data = dataset.join("data");
        Self {
            csv: data.join(format!("{stem}{DATA_FILE}")),
            sidecar: data.join(format!("{stem}{SIDECAR_SUFFIX}")),
            frames: data.join(format!("{stem}{}", frames::SUFFIX)),
            dataset,
        }
    }

    /// Makes the folders and describes the data set, if nobody has yet. Gives what of its description cannot be read,
    /// as a sentence.
    ///
    /// # Errors
    /// The folder cannot be made or written; a link.
    pub fn prepare(&self, protocol: &Protocol) -> Result<Option<String>, StoreError> {
        self.refuse_links()?;
        let data = self.dataset.join("data");
        fs::create_dir_all(&data).map_err(io(&data, "make the folder"))?;
        remove_abandoned(&self.dataset);
        description::describe(&self.dataset, protocol)
    }

    /// Nothing below the results folder may lead out of it: who has put a link there decides where a session is
    /// written, or reads what it must not. The results folder itself may be one.
    ///
    /// # Errors
    /// The first link.
    pub(super) fn refuse_links(&self) -> Result<(), StoreError> {
        let data = self.dataset.join("data");
        for path in [&self.dataset, &data, &self.csv, &self.sidecar, &self.frames] {
            if let Ok(target) = fs::read_link(path) {
                return Err(StoreError::Link { path: path.clone(), target });
            }
        }
        Ok(())
    }
}

/// The first of `P001`, `P002`, … that has no file in this experiment's results.
pub fn free_participant(results: &Path, protocol: &Protocol) -> String {
    let taken: Vec<String> = fs::read_dir(results.join(&protocol.name).join("data"))
        .into_iter()
        .flatten()
        .flatten()
        .filter_map(|entry| {
            let name = entry.file_name().into_string().ok()?;
            Some(name.strip_prefix("subject-")?.split('_').next()?.to_ascii_uppercase())
        })
        .collect();
    (1..).map(|number| format!("P{number:03}")).find(|id| !taken.contains(id)).unwrap_or_default()
}

/// Writes a JSON file, whole or not at all.
pub fn write_json(path: &Path, value: &serde_json::Value) -> Result<(), StoreError> {
    let mut text =
        serde_json::to_vec_pretty(value).map_err(|error| io(path, "describe")(std::io::Error::other(error)))?;
    text.push(b'\n');
    write_whole(path, &text, true)
}

/// Writes a file that can be made again, whole or not at all.
///
/// # Errors
/// The system's refusal.
pub fn write_file(path: &Path, content: &[u8]) -> Result<(), StoreError> {
    write_whole(path, content, false)
}

/// Writes a file so that a reader sees the old one or the new one and never half of either. `durable`: a power cut too
/// leaves one of them; what can be made again need not wait for the disk.
pub(super) fn write_whole(path: &Path, content: &[u8], durable: bool) -> Result<(), StoreError> {
    let (temporary, mut file) = create_temporary(path).map_err(io(path, "write"))?;
    let written = file
        .write_all(content)
        .and_then(|()| if durable { file.sync_all() } else { Ok(()) })
        .and_then(|()| whole(&file, content.len()))
        .and_then(|()| fs::rename(&temporary, path));
    if let Err(error) = written {
        // The temporary file is of no use; that it may stay behind on a broken disk changes nothing.
        let _ = fs::remove_file(&temporary);
        return Err(io(path, "write")(error));
    }
    if durable { sync_folder(path) } else { Ok(()) }
}

/// A disk may take less than it says: half a file must not replace a whole one.
fn whole(file: &File, length: usize) -> std::io::Result<()> {
    match file.metadata()?.len() {
        found if found == length as u64 => Ok(()),
        found => Err(std::io::Error::other(format!("{found} of {length} bytes were kept"))),
    }
}

/// A new file beside `path`, named after the process: two programs that describe the same data set do not meet in one
/// temporary file. A name that a killed program of the same number left behind is passed over.
fn create_temporary(path: &Path) -> std::io::Result<(PathBuf, File)> {
    use std::sync::atomic::{AtomicU32, Ordering};
    static COUNT: AtomicU32 = AtomicU32::new(0);
    loop {
        let mut name = path.file_name().unwrap_or_default().to_owned();
        name.push(format!(".{}-{}.tmp", std::process::id(), COUNT.fetch_add(1, Ordering::Relaxed)));
        let temporary = path.with_file_name(name);
        match File::create_new(&temporary) {
            Err(error) if error.kind() == std::io::ErrorKind::AlreadyExists => {}
            created => return created.map(|file| (temporary, file)),
        }
    }
}

/// Removes what killed programs left in a data set's folder of their tries to describe it. Other programs may be about
/// to, so only what is old.
fn remove_abandoned(dataset: &Path) {
    const OLD: Duration = Duration::from_secs(60);
    for entry in fs::read_dir(dataset).into_iter().flatten().flatten() {
        let ours = entry.file_name().to_str().is_some_and(|name| name.ends_with(".tmp"));
        let age = entry.metadata().and_then(|metadata| metadata.modified()).ok().and_then(|time| time.elapsed().ok());
        if ours && age.is_some_and(|age| age > OLD) {
            // It is in nobody's way if it stays.
            let _ = fs::remove_file(entry.path());
        }
    }
}

/// Removes what a killed program left of its tries to write the JSON file `path`. Only for who holds the session's lock.
pub(super) fn remove_leftovers(path: &Path) {
    let Some((folder, name)) = path.parent().zip(path.file_name().and_then(|name| name.to_str())) else { return };
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let left = entry
            .file_name()
            .to_str()
            .and_then(|found| found.strip_prefix(name))
            .is_some_and(|rest| rest.ends_with(".tmp"));
        if left {
            // It is in nobody's way if it stays.
            let _ = fs::remove_file(entry.path());
        }
    }
}

/// Makes a new or renamed name in a folder survive a power cut, where the system knows the notion: Windows does not open
/// folders as files.
///
/// # Errors
/// The system's refusal.
pub(super) fn sync_folder(file: &Path) -> Result<(), StoreError> {
    use std::io::ErrorKind::{InvalidInput, PermissionDenied, Unsupported};
    let folder = file.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    if !cfg!(unix) {
        return Ok(());
    }
    let opened = match File::open(folder) {
        // A folder may take files and show none.
        Err(error) if error.kind() == PermissionDenied => return Ok(()),
        opened => opened.map_err(io(folder, "sync"))?,
    };
    match opened.sync_all() {
        // Some network shares know no such call.
        Err(error) if matches!(error.kind(), InvalidInput | Unsupported) => Ok(()),
        synced => synced.map_err(io(folder, "sync")),
    }
}

/// Whether there is something of this name. A disk that does not answer has not said no.
///
/// # Errors
/// The system's refusal to say.
pub(super) fn is_there(path: &Path) -> Result<bool, StoreError> {
    use std::io::ErrorKind::{NotADirectory, NotFound};
    match fs::metadata(path) {
        Ok(_) => Ok(true),
        Err(error) if matches!(error.kind(), NotFound | NotADirectory) => Ok(false),
        Err(error) => Err(io(path, "look for")(error)),
    }
}
