//! The results folder of an experiment, which is a Psych-DS 1.5 data set, and the files that describe it to people and
//! programs: `dataset_description.json`, `README.md`, `CHANGES.md`, the list of files that are not data, and, as in BIDS,
//! `participants.tsv`. This table has one row for each participant with their latest answers; the sidecar of each session has
//! the answers of that session, and the definition, which describes the columns.

use std::{
    collections::{BTreeSet, HashSet},
    path::{Path, PathBuf},
    time::Duration,
};

use serde_json::{Value, json};

use crate::{
    experiment::{Answers, Column, Definition, Identity, ParticipantField, Protocol, columns},
    store::{
        FileError, FileErrors, StoreError,
        error::io,
        file::{
            ABANDONED, LOCK_SUFFIX, exists, folder_of, in_turn, make_folder, read_existing, remove_temporary,
            write_json, write_missing, write_whole,
        },
    },
    system::{entries, link_target, unless_missing},
    text::is_formula,
};

/// Suffix of a data file in a Psych-DS data set; our result files have it too.
pub const DATA_FILE: &str = "_data.csv";
/// Suffix of a sidecar.
pub(crate) const SIDECAR_SUFFIX: &str = "_data.json";

/// Suffix of a frames file.
pub(crate) const FRAMES_SUFFIX: &str = "_frames.csv";

/// Suffix of a file that contains the damaged lines of a data file. A number follows it.
pub(super) const DAMAGED: &str = ".damaged-";

/// Name of the file in which people record the changes of a data set by hand.
pub(super) const CHANGES: &str = "CHANGES.md";

/// Name of the table of the participants, which is next to the description of the data set.
pub const PARTICIPANTS: &str = "participants.tsv";
/// Name of the file that describes its columns in an export.
pub(in crate::store) const PARTICIPANTS_DESCRIBED: &str = "participants.json";

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
            frames: data.join(format!("{stem}{FRAMES_SUFFIX}")),
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
        let shared = [CHANGES, PARTICIPANTS].map(|name| self.dataset.join(name));
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
        let stem = [DATA_FILE, SIDECAR_SUFFIX, FRAMES_SUFFIX].iter().find_map(|suffix| name.strip_suffix(suffix));
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
    let new = || {
        json!({
            "@context": "https://schema.org/",
            "@type": "Dataset",
            "name": protocol.name,
            "description": protocol.title,
            "variableMeasured": [],
        })
    };
    let found = read_existing(&path, MAX_DESCRIPTION)?;
    let mut described = found.map_or_else(new, |found| serde_json::from_slice(&found).unwrap_or_default());
    match add_columns(&mut described, &columns(protocol)) {
        Some(true) => write_json(&path, &described).map(|()| None),
        Some(false) => Ok(None),
        None => Ok(Some(format!("{DESCRIPTION} is not JSON with a list variableMeasured; it was not changed"))),
    }
}

/// Adds the columns that a description lacks, and returns whether there were any; `None` if it has no list of columns.
fn add_columns(described: &mut Value, columns: &[Column]) -> Option<bool> {
    let variables = described.get_mut("variableMeasured")?.as_array_mut()?;
    // An entry is an object or only the column's name.
    let name = |variable: &Value| variable.as_str().or_else(|| variable.get("name")?.as_str()).map(str::to_owned);
    let known: HashSet<String> = variables.iter().filter_map(name).collect();
    let missing: Vec<Value> = columns.iter().filter(|column| !known.contains(&column.name)).map(variable).collect();
    variables.extend_from_slice(&missing);
    Some(!missing.is_empty())
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
        false => format!("- `{PARTICIPANTS}`: what each participant answered before the first page.\n"),
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
        frames = FRAMES_SUFFIX
    )
}

const NO_CHANGES: &str = "# Changes

Sessions are added while they are recorded and are never changed afterward. Record any manual change here with its date.
";

fn ignored() -> String {
    let [by_the_text, _] = IGNORE;
    format!(
        "# Frame intervals describe a session and are not its data.\n*{frames}\n# The participants, in the form of another standard.\n{PARTICIPANTS}\n{PARTICIPANTS_DESCRIBED}\n# Exists only while a session runs, where the file system has no locks.\n*{lock}\n# Lines that machband repair removed from a data file.\n*{DAMAGED}*\n# This list, under the name used in the text of the standard.\n{by_the_text}\n",
        frames = FRAMES_SUFFIX,
        lock = LOCK_SUFFIX,
    )
}

/// How BIDS writes a missing value.
pub(in crate::store) const MISSING: &str = "n/a";
/// The first column, which BIDS requires.
const ID: &str = "participant_id";
/// Maximum size of the table in bytes. A row has a few hundred.
const MAX_PARTICIPANTS: u64 = 64 << 20;

/// The rows of a `participants.tsv`. Columns and rows that the program does not know are kept.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(in crate::store) struct Participants {
    /// The names of the columns; the first is the participant.
    pub columns: Vec<String>,
    pub rows: Vec<Vec<String>>,
}

impl Participants {
    /// Reads the table of a data set; if there is none, it has no rows.
    ///
    /// # Errors
    /// The file cannot be read, or it is not a table of participants.
    pub fn read(dataset: &Path) -> Result<Self, StoreError> {
        let path = dataset.join(PARTICIPANTS);
        let text = read_existing(&path, MAX_PARTICIPANTS)?.unwrap_or_default();
        // The table is written again as a whole, so replacing bytes here would destroy what others entered.
        let text = String::from_utf8(text)
            .map_err(|_| FileErrors::whole(&path, "is not UTF-8 text; expected a table encoded in UTF-8"))?;
        // Old spreadsheets end lines with only a carriage return.
        let text = text.trim_start_matches('\u{feff}').replace("\r\n", "\n").replace('\r', "\n");
        let mut lines = (1..).zip(text.lines()).filter(|(_, line)| !line.is_empty());
        let cells = |line: &str| line.split('\t').map(str::to_owned).collect::<Vec<_>>();
        let columns = lines.next().map_or_else(|| vec![ID.to_owned()], |(_, line)| cells(line));
        if columns[0] != ID {
            let message = format!("the first column is {:?}; expected {ID}", columns[0]);
            return Err(FileErrors::at(&path, (1, 1), message).into());
        }
        if let Some(twice) = columns.iter().find(|name| columns.iter().filter(|other| other == name).count() > 1) {
            let message = format!("the column {twice:?} appears more than once; expected each column once");
            return Err(FileErrors::at(&path, (1, 1), message).into());
        }
        let (mut rows, mut errors) = (Vec::new(), Vec::new());
        for (number, line) in lines {
            let row = cells(line);
            if row.len() != columns.len() {
                let message = format!("the number of cells in the row is {}; expected {}", row.len(), columns.len());
                errors.push(FileError::at(&path, (number, 1), message));
            } else if row[0].starts_with('"') {
                let message =
                    format!("the participant is {}; expected cells without quotation marks, as in BIDS", row[0]);
                errors.push(FileError::at(&path, (number, 1), message));
            }
            rows.push(row);
        }
        FileErrors::none(errors)?;
        Ok(Self { columns, rows })
    }

    /// Returns the value in a participant's row; `None` if it is missing.
    pub fn get(&self, subject: &str, column: &str) -> Option<&str> {
        let row = self.rows.iter().find(|row| is_of(row, subject))?;
        let place = self.columns.iter().position(|name| name == column)?;
        row.get(place).map(String::as_str).filter(|value| is_given(value))
    }

    /// Sets values in a participant's row, and adds the row and the columns that are missing. A value that is `None`
    /// does not replace an earlier one.
    fn put<'a>(&mut self, subject: &str, values: impl IntoIterator<Item = (&'a str, Option<String>)>) {
        let at = self.rows.iter().position(|row| is_of(row, subject)).unwrap_or_else(|| {
            let mut row = vec![MISSING.to_owned(); self.columns.len()];
            row[0] = format!("sub-{subject}");
            self.rows.push(row);
            self.rows.len() - 1
        });
        for (name, value) in values {
            let place = self.columns.iter().position(|column| column == name).unwrap_or_else(|| {
                self.columns.push(name.to_owned());
                self.rows.iter_mut().for_each(|row| row.push(MISSING.to_owned()));
                self.columns.len() - 1
            });
            if let Some(value) = value {
                self.rows[at][place] = value;
            }
        }
    }

    /// Adds the rows of these participants from the table of another data set, at `path`. Earlier values are kept; returns
    /// a note for each one that differs.
    fn add(&mut self, (path, other): (&Path, &Self), subjects: &BTreeSet<&str>) -> Vec<String> {
        let mut notes = Vec::new();
        for row in &other.rows {
            let Some(subject) = subjects.iter().find(|subject| is_of(row, subject)) else { continue };
            let mut values = Vec::new();
            for (column, value) in other.columns.iter().zip(row).skip(1) {
                let (known, value) = (self.get(subject, column), Some(value).filter(|value| is_given(value)));
                if let Some((known, value)) = known.zip(value).filter(|(known, value)| known != value) {
                    let path = path.display();
                    notes.push(format!(
                        "{path}: {column} of {subject} is {value:?}, but {known:?} in an earlier row, which is used"
                    ));
                }
                values.push((column.as_str(), value.filter(|_| known.is_none()).cloned()));
            }
            self.put(subject, values);
        }
        notes
    }

    /// Returns the table as text.
    pub fn text(&self) -> String {
        let lines = std::iter::once(&self.columns).chain(&self.rows);
        lines.map(|cells| cells.join("\t") + "\n").collect()
    }
}

/// True if a cell has a value.
fn is_given(cell: &str) -> bool {
    !cell.is_empty() && cell != MISSING
}

/// True if a row is that of a participant. People who edit the table leave out `sub-` or change the case; IDs that differ
/// only in case are not allowed.
fn is_of(row: &[String], subject: &str) -> bool {
    let id = row[0].trim();
    let bare = id.get(..4).filter(|prefix| prefix.eq_ignore_ascii_case("sub-")).map_or(id, |_| &id[4..]);
    bare.eq_ignore_ascii_case(subject)
}

/// Enters the answers of a participant into the table of a data set. Other programs that do this at the same time wait for
/// each other. Rows of other participants are kept.
///
/// # Errors
/// The file cannot be read or written, or it is not a table of participants. It is then unchanged.
pub(super) fn enter(
    dataset: &Path,
    subject: &str,
    fields: &[ParticipantField],
    answers: &Answers,
) -> Result<(), StoreError> {
    // The table is replaced as a whole, so it cannot be locked itself. The program never replaces the list of changes.
    in_turn(&dataset.join(CHANGES), || {
        let mut table = Participants::read(dataset)?;
        let cell = |value: &Value| {
            value.as_str().map_or_else(|| value.to_string(), |text| text.replace(['\t', '\n', '\r'], " "))
        };
        table.put(subject, fields.iter().map(|field| (&*field.name, answers.get(&field.name).map(cell))));
        write_whole(&dataset.join(PARTICIPANTS), table.text().as_bytes(), true)
    })
}

/// Collects what several data sets say about these participants of theirs, with notes about values that differ or are
/// missing.
///
/// # Errors
/// A table cannot be read, or a spreadsheet would interpret a cell as a formula.
pub(in crate::store) fn collect<'a>(
    datasets: impl IntoIterator<Item = (PathBuf, BTreeSet<&'a str>)>,
) -> Result<(Participants, Vec<String>), StoreError> {
    let mut participants = Participants { columns: vec![ID.to_owned()], rows: Vec::new() };
    let mut notes = Vec::new();
    for (dataset, subjects) in datasets {
        let (path, table) = (dataset.join(PARTICIPANTS), Participants::read(&dataset)?);
        let cells = (2..).zip(&table.rows).flat_map(|(line, row)| row.iter().map(move |cell| (line, cell)));
        let errors = cells.filter(|(_, cell)| is_formula(cell)).map(|(line, cell)| {
            let expected = "expected text that begins with another character";
            FileError::at(&path, (line, 1), format!("spreadsheets would treat {cell:?} as a formula; {expected}"))
        });
        FileErrors::none(errors.collect())?;
        notes.extend(participants.add((&path, &table), &subjects));
        let has_no_row = |subject: &&&str| !table.rows.iter().any(|row| is_of(row, subject));
        let missing: Vec<&str> = subjects.iter().filter(has_no_row).copied().collect();
        if !missing.is_empty() && exists(&path)? {
            notes.push(format!("{}: has no row for {}", path.display(), missing.join(", ")));
        }
        subjects.iter().for_each(|subject| participants.put(subject, None));
    }
    participants.rows.sort();
    Ok((participants, notes))
}
