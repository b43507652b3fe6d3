//! The participants of a data set, `participants.tsv` and its description `participants.json`, as in BIDS: one row for
//! each participant with their latest answers. The sidecar of each session has the answers of that session.

use std::{
    collections::BTreeSet,
    path::{Path, PathBuf},
};

use serde_json::{Map, Value, json};

use super::dataset::{CHANGES, PARTICIPANTS, PARTICIPANTS_DESCRIBED};
use crate::{
    experiment::{Answers, FieldKind, ParticipantFields},
    store::{
        FileError, FileErrors, StoreError,
        file::{exists, in_turn, parse_json, read_existing, write_json, write_whole},
    },
    text::is_formula,
};

/// How BIDS writes a missing value.
pub(in crate::store) const MISSING: &str = "n/a";
/// The first column, which BIDS requires.
const ID: &str = "participant_id";
/// Maximum size of the table in bytes. A row has a few hundred.
const MAX_FILE: u64 = 64 << 20;

/// The rows of a `participants.tsv`. Columns and rows that the program does not know are kept.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(in crate::store) struct Participants {
    columns: Vec<String>,
    rows: Vec<Vec<String>>,
}

impl Participants {
    /// Reads the table of a data set; if there is none, it has no rows.
    ///
    /// # Errors
    /// The file cannot be read, or it is not a table of participants.
    pub fn read(dataset: &Path) -> Result<Self, StoreError> {
        let path = dataset.join(PARTICIPANTS);
        let text = read_existing(&path, MAX_FILE)?.unwrap_or_default();
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

    /// Returns the columns other than the participant.
    pub fn columns(&self) -> &[String] {
        self.columns.get(1..).unwrap_or_default()
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

    /// True if there is no row.
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
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

/// Enters the answers of a participant into the table of a data set, and describes its columns. Other programs that do
/// this at the same time wait for each other. Rows of other participants are kept.
///
/// # Errors
/// The files cannot be read or written, or they are not a table of participants and its description. The table is then
/// unchanged.
pub(super) fn enter(
    dataset: &Path,
    subject: &str,
    fields: &ParticipantFields,
    answers: &Answers,
) -> Result<(), StoreError> {
    // The table is replaced as a whole, so it cannot be locked itself. The program never replaces the list of changes.
    in_turn(&dataset.join(CHANGES), || {
        let mut table = Participants::read(dataset)?;
        let cell = |value: &Value| {
            value.as_str().map_or_else(|| value.to_string(), |text| text.replace(['\t', '\n', '\r'], " "))
        };
        table.put(subject, fields.0.iter().map(|field| (&*field.name, answers.get(&field.name).map(cell))));
        describe(dataset, fields)?;
        write_whole(&dataset.join(PARTICIPANTS), table.text().as_bytes(), true)
    })
}

/// Reads the description of the columns; if there is none, it is empty.
///
/// # Errors
/// The file cannot be read, or it is not an object in JSON.
fn described(dataset: &Path) -> Result<Map<String, Value>, StoreError> {
    let path = dataset.join(PARTICIPANTS_DESCRIBED);
    let found = read_existing(&path, MAX_FILE)?;
    found.map_or_else(|| Ok(Map::new()), |text| Ok(parse_json(&path, &text, "a description of columns")?))
}

/// Collects what several data sets say about these participants of theirs: a row for each, the description of the columns, and
/// notes about values that differ.
///
/// # Errors
/// The files cannot be read; a spreadsheet would interpret a cell as a formula; or data sets describe a column with
/// different units or levels.
pub(in crate::store) fn collect<'a>(
    datasets: impl IntoIterator<Item = (PathBuf, BTreeSet<&'a str>)>,
) -> Result<(Participants, Map<String, Value>, Vec<String>), StoreError> {
    let mut participants = Participants { columns: vec![ID.to_owned()], rows: Vec::new() };
    let (mut descriptions, mut notes) = (Map::new(), Vec::new());
    for (dataset, subjects) in datasets {
        let table = Participants::read(&dataset)?;
        let cells = || table.rows.iter().zip(2..).flat_map(|(row, line)| row.iter().map(move |cell| (line, cell)));
        let errors = cells().filter(|(_, cell)| is_formula(cell)).map(|(line, cell)| {
            let expected = "expected text that begins with another character";
            let message = format!("spreadsheets would treat {cell:?} as a formula; {expected}");
            FileError::at(dataset.join(PARTICIPANTS), (line, 1), message)
        });
        FileErrors::none(errors.collect())?;
        let path = dataset.join(PARTICIPANTS);
        notes.extend(participants.add((&path, &table), &subjects));
        let missing: Vec<&str> =
            subjects.iter().filter(|subject| !table.rows.iter().any(|row| is_of(row, subject))).copied().collect();
        if !missing.is_empty() && exists(&path)? {
            notes.push(format!("{}: has no row for {}", path.display(), missing.join(", ")));
        }
        let path = dataset.join(PARTICIPANTS_DESCRIBED);
        for (column, description) in described(&dataset)? {
            let known = descriptions.entry(column.clone()).or_insert_with(|| description.clone());
            // Other words may mean the same, but the same value in another unit or of other levels does not.
            if ["Units", "Levels"].iter().any(|key| known.get(key) != description.get(key)) {
                let message = format!(
                    "describes other units or levels of {column:?} than another data set does; expected the same, or one export for each folder"
                );
                return Err(FileErrors::whole(path, message).into());
            }
        }
    }
    Ok((participants, descriptions, notes))
}

/// Describes the columns that are not described yet. Manual entries are kept.
fn describe(dataset: &Path, fields: &ParticipantFields) -> Result<(), StoreError> {
    let mut all = described(dataset)?;
    let before = all.len();
    all.entry(ID).or_insert_with(|| json!({ "Description": "Participant." }));
    for field in &fields.0 {
        let (description, unit) = field.description();
        let mut entry = json!({ "Description": description });
        if let Some(unit) = unit {
            entry["Units"] = unit.into();
        }
        if let Some(text) = &field.spec.text {
            entry["Text"] = text.as_str().into();
        }
        if field.kind() == FieldKind::Choice {
            entry["Levels"] = field.options().into_iter().map(|(choice, label)| (choice, Value::from(label))).collect();
        }
        all.entry(&field.name).or_insert(entry);
    }
    if all.len() == before { Ok(()) } else { write_json(&dataset.join(PARTICIPANTS_DESCRIBED), &all.into()) }
}
