//! The results folder of an experiment, which is a Psych-DS 1.5 data set, and the files that describe it to people and
//! programs: `dataset_description.json`, `README.md`, `CHANGES.md` and the list of files that are not data.

use std::{
    collections::{BTreeSet, HashSet},
    path::{Path, PathBuf},
    time::Duration,
};

use serde_json::{Value, json};

use super::frames;
use crate::{
    experiment::{Column, Definition, Identity, Protocol, columns},
    store::{
        FileError, FileErrors, StoreError,
        error::io,
        file::{ABANDONED, LOCK_SUFFIX, exists, folder_of, make_folder, remove_temporary, write_json, write_missing},
        open::read_regular,
    },
    system::{entries, link_target, unless_missing},
};

/// Suffix of a data file in a Psych-DS data set; our result files have it too.
pub const DATA_FILE: &str = "_data.csv";
/// Suffix of a sidecar.
pub(crate) const SIDECAR_SUFFIX: &str = "_data.json";

/// Suffix of a file that contains the damaged lines of a data file. A number follows it.
pub(super) const DAMAGED: &str = ".damaged-";

/// Name of the file in which people record the changes of a data set by hand.
pub(super) const CHANGES: &str = "CHANGES.md";

/// Name of the table of the participants, which is next to the description of the data set.
pub const PARTICIPANTS: &str = "participants.tsv";
/// Name of the file that describes its columns.
pub const PARTICIPANTS_DESCRIBED: &str = "participants.json";

/// The paths of the files of one session.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SessionPaths {
    /// The data set, `RESULTS/NAME`.
    pub dataset: PathBuf,
    /// The result file with the rows.
    pub csv: PathBuf,
    /// The sidecar with everything else about the session.
    pub sidecar: PathBuf,
    /// The frames file with every frame interval.
    pub frames: PathBuf,
}

impl SessionPaths {
    /// Returns the paths of a session's files in a results folder. These names are documented and stable.
    pub fn new(results: &Path, protocol: &Protocol, identity: &Identity) -> Self {
        let dataset = results.join(&protocol.name);
        let stem =
            format!("subject-{}_session-{}_task-{}", identity.subject(), identity.session(), protocol.file_task());
        let data = dataset.join("data");
        Self {
            csv: data.join(format!("{stem}{DATA_FILE}")),
            sidecar: data.join(format!("{stem}{SIDECAR_SUFFIX}")),
            frames: data.join(format!("{stem}{}", frames::SUFFIX)),
            dataset,
        }
    }

    /// Creates the folders and the description of the data set, if they do not exist. If the existing description
    /// cannot be extended, returns a sentence that says so.
    ///
    /// # Errors
    /// The folder cannot be created or written, or there is a link.
    pub fn prepare(&self, protocol: &Protocol) -> Result<Option<String>, StoreError> {
        self.refuse_links()?;
        let data = self.dataset.join("data");
        make_folder(&data)?;
        self.remove_temporary(false);
        describe(&self.dataset, protocol)
    }

    /// Removes the temporary files that killed programs left. Another program may be writing the description of the data
    /// set, but not the sidecar if the session is locked.
    pub fn remove_temporary(&self, is_locked: bool) {
        if is_locked {
            let own = [&self.csv, &self.sidecar].map(|path| path.file_name().unwrap_or_default().to_string_lossy());
            // Also of the damaged lines, whose file is named after the data file.
            let is_own = |name: &str| own.iter().any(|own| name.starts_with(&**own));
            remove_temporary(&self.dataset.join("data"), is_own, Duration::ZERO);
        }
        remove_temporary(&self.dataset, |_| true, ABANDONED);
    }

    /// Refuses links inside the results folder. Nothing in it may lead out of it, because anyone who puts a link there
    /// could redirect where a session is written, or expose other files. The results folder itself may be a link.
    ///
    /// # Errors
    /// Reports the first link.
    pub(crate) fn refuse_links(&self) -> Result<(), StoreError> {
        let data = self.dataset.join("data");
        let shared = [CHANGES, PARTICIPANTS, PARTICIPANTS_DESCRIBED].map(|name| self.dataset.join(name));
        for path in [&self.dataset, &data, &self.csv, &self.sidecar, &self.frames].into_iter().chain(&shared) {
            refuse_link(path)?;
        }
        Ok(())
    }
}

/// Refuses a link.
///
/// # Errors
/// This is a link, or the disk does not say whether it is one.
pub(crate) fn refuse_link(path: &Path) -> Result<(), StoreError> {
    let Some(target) = link_target(path).map_err(io(path, "access"))? else { return Ok(()) };
    let expected = "expected a regular file or folder (only the results folder itself can be a link)";
    Err(FileErrors::whole(path, format!("is a link to {}; {expected}", target.display())).into())
}

/// Returns the data set of a data file: the folder that contains its `data` folder, whatever the path calls that folder.
///
/// # Errors
/// The folder cannot be accessed.
pub(crate) fn of(csv: &Path) -> Result<Option<PathBuf>, StoreError> {
    let folder = folder_of(csv);
    if folder.file_name().is_some_and(|name| name == "data") {
        return Ok(Some(folder_of(folder).to_owned()));
    }
    // The folder may be called `.`, or be a link.
    let full = unless_missing(folder.canonicalize()).map_err(io(folder, "access"))?;
    let is_data = full.as_deref().and_then(Path::file_name).is_some_and(|name| name == "data");
    Ok(is_data.then(|| folder.join("..")))
}

/// Returns the data set of a data file; `None` if its folder has no description of a data set.
///
/// # Errors
/// I/O errors.
pub(crate) fn described(csv: &Path) -> Result<Option<PathBuf>, StoreError> {
    let Some(folder) = of(csv)? else { return Ok(None) };
    Ok(exists(&folder.join(DESCRIPTION))?.then_some(folder))
}

/// Returns the participant and the session that the name of a data file says.
///
/// # Errors
/// It is not named like a data file.
pub(crate) fn identity(csv: &Path) -> Result<Identity, FileErrors> {
    let name = csv.file_name().unwrap_or_default().to_string_lossy();
    let fail = |what: &str| {
        let expected = "expected a data file such as subject-S001_session-1_task-quick_data.csv";
        FileErrors::whole(csv, format!("{what}; {expected}"))
    };
    let stem = name.strip_suffix(DATA_FILE).ok_or_else(|| fail("is not named like a data file"))?;
    let part = |key: &str| stem.split('_').find_map(|part| part.strip_prefix(key)?.strip_prefix('-'));
    let (Some(subject), Some(session)) = (part("subject"), part("session")) else {
        return Err(fail("its name lacks the subject or the session"));
    };
    Identity::new(subject, session).map_err(|error| FileErrors::whole(csv, error))
}

/// Returns the path of another file of the session with this data file.
pub(in crate::store) fn beside(csv: &Path, suffix: &str) -> PathBuf {
    let name = csv.file_name().unwrap_or_default().to_string_lossy();
    csv.with_file_name(format!("{}{suffix}", name.strip_suffix(DATA_FILE).unwrap_or(&name)))
}

/// Reports the tables and sidecars in the `data` folder of a data set that do not belong to a session: sidecars and
/// frames without rows, and files with other names, such as packed files and the conflicted copies of a cloud service.
/// A folder that exists but cannot be read is an error too.
pub fn unexpected_files(dataset: &Path) -> Vec<FileError> {
    let data = dataset.join("data");
    let listed = match unless_missing(entries(&data)).map_err(io(&data, "read")) {
        Ok(listed) => listed.unwrap_or_default(),
        Err(error) => return error.errors(dataset),
    };
    let files: BTreeSet<PathBuf> = listed.into_iter().collect();
    let error = |path: &PathBuf| {
        let name = path.file_name()?.to_string_lossy().into_owned();
        let unpacked = name.to_ascii_lowercase().trim_end_matches(".gz").to_owned();
        let is_text = [".csv", ".json"].iter().any(|extension| unpacked.ends_with(extension));
        if name.starts_with('.') || !is_text {
            return None;
        }
        let stem = [DATA_FILE, SIDECAR_SUFFIX, frames::SUFFIX].iter().find_map(|suffix| name.strip_suffix(suffix));
        let csv = stem.map(|stem| path.with_file_name(format!("{stem}{DATA_FILE}")));
        match csv.filter(|csv| identity(csv).is_ok()) {
            None => Some(FileError::whole(path, "is not named like a file of a session; expected only such files")),
            Some(csv) if !files.contains(&csv) => {
                Some(FileError::whole(path, "has no data file next to it; expected the rows of its session"))
            }
            Some(_) => None,
        }
    };
    files.iter().filter_map(error).collect()
}

/// Returns the first of `P001`, `P002`, … that has no file in this experiment's results.
///
/// # Errors
/// The folder cannot be read, so participants in it are not known.
pub fn free_participant(results: &Path, protocol: &Protocol) -> Result<String, StoreError> {
    let data = results.join(&protocol.name).join("data");
    let files = unless_missing(entries(&data)).map_err(io(&data, "list"))?.unwrap_or_default();
    let participant = |path: PathBuf| {
        let name = path.file_name()?.to_str()?;
        Some(name.strip_prefix("subject-")?.split('_').next()?.to_ascii_uppercase())
    };
    let taken: HashSet<String> = files.into_iter().filter_map(participant).collect();
    Ok((1..).map(|number| format!("P{number:03}")).find(|id| !taken.contains(id)).unwrap_or_default())
}

/// Maximum size of the description of a data set in bytes; a typical one has 10,000 bytes.
pub(in crate::store) const MAX_DESCRIPTION: u64 = 16 << 20;

/// Name of the file that describes a data set.
pub const DESCRIPTION: &str = "dataset_description.json";

/// Both names for the list of files that are not data: the one in the standard and the one in its validator.
const IGNORE: [&str; 2] = [".psychds-ignore", ".psychdsignore"];

/// Writes missing files, and adds missing columns to the description. Manual entries are kept. A description without a list of
/// columns stays as it is, which a sentence says: the session is worth more.
///
/// # Errors
/// I/O errors.
pub(crate) fn describe(dataset: &Path, protocol: &Protocol) -> Result<Option<String>, StoreError> {
    let [by_text, by_validator] = IGNORE;
    for (name, text) in [
        ("README.md", readme(protocol)),
        (CHANGES, NO_CHANGES.to_owned()),
        (by_text, ignored()),
        (by_validator, ignored()),
    ] {
        write_missing(&dataset.join(name), text.as_bytes())?;
    }
    let path = dataset.join(DESCRIPTION);
    if !exists(&path)? {
        return write_json(&path, &description(protocol)).map(|()| None);
    }
    let found = read_regular(&path, MAX_DESCRIPTION).map_err(io(&path, "read"))?;
    let mut described = serde_json::from_slice::<Value>(&found).unwrap_or_default();
    match add_columns(&mut described, &columns(protocol)) {
        Some(true) => write_json(&path, &described).map(|()| None),
        Some(false) => Ok(None),
        None => Ok(Some(format!("{DESCRIPTION} is not JSON with a list variableMeasured; it was not changed"))),
    }
}

/// Returns a data set's description: its name, its title, and every column.
fn description(protocol: &Protocol) -> Value {
    json!({
        "@context": "https://schema.org/",
        "@type": "Dataset",
        "name": protocol.name,
        "description": protocol.title,
        "variableMeasured": columns(protocol).iter().map(variable).collect::<Vec<_>>(),
    })
}

/// Adds the columns that a description lacks, and returns whether there were any; `None` if it has no list of columns.
fn add_columns(described: &mut Value, columns: &[Column]) -> Option<bool> {
    let variables = described.get_mut("variableMeasured")?.as_array_mut()?;
    let missing: Vec<Value> =
        columns.iter().filter(|column| !variables.iter().any(|v| names(v, column))).map(variable).collect();
    variables.extend_from_slice(&missing);
    Some(!missing.is_empty())
}

/// True if an entry describes this column. The entry may be an object or only the column's name.
fn names(variable: &Value, column: &Column) -> bool {
    variable.as_str().or_else(|| variable.get("name")?.as_str()) == Some(&column.name)
}

fn variable(column: &Column) -> Value {
    let levels: Vec<String> = column
        .levels
        .iter()
        .map(|(level, meaning)| format!("{level}: {}", meaning.as_str().unwrap_or_default()))
        .collect();
    let description = if levels.is_empty() {
        column.description.clone()
    } else {
        format!("{} ({})", column.description, levels.join("; "))
    };
    let mut variable = json!({ "@type": "PropertyValue", "name": column.name, "description": description });
    if !column.unit.is_empty() {
        variable["unitText"] = column.unit.as_str().into();
    }
    variable
}

fn readme(protocol: &Protocol) -> String {
    let Definition { name, title, participant, .. } = &**protocol;
    let participants = match participant.is_empty() {
        true => String::new(),
        false => format!(
            "- `{PARTICIPANTS}`: what each participant answered before the first page, with the columns described in
  `{PARTICIPANTS_DESCRIBED}`.\n"
        ),
    };
    let version = env!("CARGO_PKG_VERSION");
    format!(
        "# {title}

Ratings recorded with machband {version}, using the definition `{name}`.

- `data/subject-…_session-…_task-…_data.csv`: one row per trial. `row_id` is unique within the data set.
- `data/…_data.json`, next to each data file: everything else that is known about the session, such as the
  definition and the seed that determine the order of its trials, the program, the screen, the geometry, and the meaning
  of each column.
- `data/…{frames}`: every frame interval, if a screen was used.
{participants}
Missing values are empty. A corrected response is a separate row with `attempt` + 1; the last attempt of a trial
counts. Rows with the `phase` practice are not data.

`machband verify` checks the rows and the pictures against the sidecars; `machband analyze` analyzes the ratings.
Add the author, license and similar information to `{DESCRIPTION}`; machband keeps your entries.
",
        frames = frames::SUFFIX
    )
}

const NO_CHANGES: &str = "# Changes

Sessions are added while they are recorded and are never changed afterward. Record any manual change here with its date.
";

fn ignored() -> String {
    let [by_the_text, _] = IGNORE;
    format!(
        "# Frame intervals describe a session and are not its data.\n*{frames}\n# The participants, in the form of another standard.\n{PARTICIPANTS}\n{PARTICIPANTS_DESCRIBED}\n# Exists only while a session runs, where the file system has no locks.\n*{lock}\n# Lines that machband repair removed from a data file.\n*{DAMAGED}*\n# This list, under the name used in the text of the standard.\n{by_the_text}\n",
        frames = frames::SUFFIX,
        lock = LOCK_SUFFIX,
    )
}
