//! The rows of a file as columns, and the errors in them. Each file is read once.

use std::{borrow::Cow, collections::BTreeSet, ops::Range};

use csv::Position;

use super::{
    selection::{Columns, Input},
    values::{answer, seconds, with_point},
};
use crate::store::{
    FileError,
    columns::{Interner, Texts},
    error::RowErrors,
    ratings::Layout,
    table::{self, Row, decoded, shortened},
};

/// Maximum number of rows of a study; 100 million take about 4 GB.
pub(super) const MAX_ROWS: usize = 100_000_000;

/// Number of rows between positions that are kept, so that a row with an error can be read again.
const MARK: usize = 64;

/// The rows of a file below its header.
#[derive(Debug, Default)]
pub(super) struct Rows {
    /// The columns, as in the file; those that are not needed are empty. An unreadable row has empty texts.
    pub columns: Vec<Texts>,
    /// The response times in seconds: NaN if missing, and negative if unreadable. Empty if they are not needed.
    pub times: Vec<f64>,
    /// How each row is used.
    pub status: Vec<Status>,
    pub errors: RowErrors,
    /// Line and column of the first text that is not UTF-8.
    pub foreign: Option<(usize, usize)>,
    /// The incomplete last line of a session that did not end.
    pub interrupted: Option<usize>,
    /// The position of every 64th row.
    marks: Vec<Position>,
}

/// How a row is used.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Status {
    /// It counts, as part of the session with this index if it is in a result file.
    Counts(u32),
    Practice,
    /// A later attempt counts.
    Superseded,
    /// The trial and attempt also occur in the file with this index, and that row counts.
    Repeated(u32),
    /// It has an error.
    Wrong,
}

/// An error in a row.
#[derive(Debug)]
pub(super) struct RowError {
    /// Index of the row, which is readable.
    pub row: usize,
    /// Index of the cell; `None` if the error is about the row as a whole.
    pub cell: Option<usize>,
    pub what: What,
}

/// What is wrong with a row.
#[derive(Debug)]
pub(super) enum What {
    /// The value of the cell is not what is expected.
    Unexpected(Cow<'static, str>),
    /// The row also occurs in the file with this index, and that one counts.
    Repeated(usize),
    /// What is wrong; what is expected.
    Said(String),
}

impl RowError {
    /// Creates the error for a cell with an unexpected value.
    pub fn new(row: usize, cell: usize, expected: impl Into<Cow<'static, str>>) -> Self {
        Self { row, cell: Some(cell), what: What::Unexpected(expected.into()) }
    }
}

impl Rows {
    /// Reads the rows of a file, or takes those of a table in memory.
    ///
    /// # Errors
    /// The file cannot be read to its end.
    pub fn read(input: &Input) -> Result<Self, FileError> {
        let header = &input.header;
        let needed = input.columns.texts();
        let used: BTreeSet<usize> = needed.iter().copied().chain(input.columns.time).collect();
        if let Some(columns) = &header.columns {
            let texts = |column: usize| if needed.contains(&column) { columns.texts(column) } else { Texts::default() };
            if let Some(&column) = needed.iter().find(|column| columns.has_zero_byte(**column)) {
                let name = &header.names[column];
                let message = format!("a cell of the column {name} contains a zero byte; expected text");
                return Err(FileError::whole(&input.name, message));
            }
            let mut rows = Self {
                columns: (0..header.names.len()).map(texts).collect(),
                times: input.columns.time.map_or_else(Vec::new, |column| columns.numbers(column, seconds)),
                status: vec![Status::Counts(0); columns.rows()],
                ..Self::default()
            };
            rows.unwrap_answers(input);
            return Ok(rows);
        }
        let mut unusable = header.converted.iter().flat_map(|converted| &converted.unusable);
        if let Some((row, column, problem)) = unusable.find(|(_, column, _)| used.contains(column)) {
            return Err(FileError::at(&input.name, (row + 1, column + 1), *problem));
        }
        let mut rows = Self { foreign: header.foreign, ..Self::default() };
        let mut columns: Vec<Interner> = header.names.iter().map(|_| Interner::default()).collect();
        let mut is_header = true;
        let read = table::rows_from(header.content(&input.path), header.separator, header.start.as_ref(), |row| {
            let incomplete = if input.layout == Layout::Results { interrupted(row) } else { None };
            if std::mem::take(&mut is_header) || is_blank(row, input) {
            } else if let Some(what) = incomplete {
                match &input.sidecar {
                    Some(sidecar) if !sidecar.is_sealed() => rows.interrupted = Some(row.place(0).0),
                    _ => rows.errors.add(&input.name, None, left_behind(what), || row.place(0)),
                }
            } else {
                let index = rows.status.len();
                if index.is_multiple_of(MARK) {
                    rows.marks.push(row.position());
                }
                let foreign = row.text().err().map(|cell| {
                    rows.foreign.get_or_insert_with(|| row.place(cell));
                    row.decoded()
                });
                let record = foreign.as_ref().unwrap_or(row.record);
                let text = match row.check(&used, header.names.len(), input.layout == Layout::Results) {
                    Ok(()) => std::str::from_utf8(record.as_slice()).ok(),
                    Err((cell, message)) => {
                        rows.errors.add(&input.name, cell, message, || row.place(cell.unwrap_or(0)));
                        None
                    }
                };
                let cell = |column| text.and_then(|text| text.get(record.range(column)?)).unwrap_or_default().trim();
                let value = |column| with_point(cell(column), header.separator);
                for &column in &needed {
                    match input.columns.is_id(column) {
                        true => columns[column].push(cell(column)),
                        false => columns[column].push(&value(column)),
                    }
                }
                rows.times.extend(input.columns.time.map(|column| seconds(&value(column))));
                rows.status.push(if text.is_some() { Status::Counts(0) } else { Status::Wrong });
            }
            rows.status.len() <= MAX_ROWS
        });
        read.map_err(|error| {
            FileError::whole(&input.name, format!("cannot be read completely: {error}; expected a readable file"))
        })?;
        rows.columns = columns.into_iter().map(Interner::finish).collect();
        rows.unwrap_answers(input);
        Ok(rows)
    }

    /// Replaces responses in JSON by their values.
    fn unwrap_answers(&mut self, input: &Input) {
        for &column in &input.columns.responses {
            for text in &mut self.columns[column].texts {
                if let Some(answer) = answer(text) {
                    *text = answer.trim().into();
                }
            }
        }
    }

    /// Returns the indices of all rows.
    pub fn all(&self) -> Range<usize> {
        0..self.status.len()
    }

    /// Adds an error to those of the file.
    pub fn report(&self, errors: &mut RowErrors, error: RowError, input: &Input, inputs: &[Input]) {
        let row = input.in_memory().then_some(error.row);
        errors.add_with(row, error.cell, || self.placed(&error, input, inputs));
    }

    /// Returns an error with its place.
    fn placed(&self, error: &RowError, input: &Input, inputs: &[Input]) -> FileError {
        if let Some(columns) = &input.header.columns {
            let message = error.message(input, inputs, |column| columns.cell(error.row, column));
            let place = format!("{}, row {} (counted from 0)", input.name, error.row);
            return FileError { rows: vec![error.row], ..FileError::whole(place, message) };
        }
        let (header, mut skipped, mut found) = (&input.header, error.row % MARK, None);
        let from = self.marks.get(error.row / MARK);
        // The row is read again, which is acceptable because errors are rare.
        let _ = table::rows_from(header.content(&input.path), header.separator, from, |row| {
            if is_blank(row, input) {
                return true;
            }
            if skipped == 0 {
                let written = |column| row.record.get(column).map(decoded).unwrap_or_default().into_owned();
                let place = row.place(error.cell.unwrap_or(0));
                found = Some(FileError::at(&input.name, place, error.message(input, inputs, written)));
            }
            skipped = skipped.saturating_sub(1);
            found.is_none()
        });
        found.unwrap_or_else(|| FileError::whole(&input.name, error.message(input, inputs, |_| String::new())))
    }
}

impl RowError {
    /// Says what is wrong; `written` returns the cell in a column of the row.
    fn message(&self, input: &Input, inputs: &[Input], written: impl Fn(usize) -> String) -> String {
        match (&self.what, self.cell) {
            (What::Said(message), _) => message.clone(),
            (What::Unexpected(expected), cell) => {
                let cell = cell.unwrap_or_default();
                let name = &input.header.names[cell];
                match written(cell).trim() {
                    "" => format!("{name} is empty; expected {expected}"),
                    text => format!("{name} is {:?}; expected {expected}", shortened(text)),
                }
            }
            (What::Repeated(file), _) => {
                let row_id = input.header.position("row_id").map(written).unwrap_or_default();
                let name = match row_id.trim() {
                    "" => "the trial and attempt of this row".to_owned(),
                    row_id => format!("row_id {row_id:?}"),
                };
                let other = &inputs[*file].name;
                let place = if *other == input.name { "above".to_owned() } else { format!("in {other}") };
                format!("{name} already appears {place}; expected each row only once (this one is left out)")
            }
        }
    }
}

/// True if no cell of a table from elsewhere has a value: spreadsheets write such rows as separators.
fn is_blank(row: &Row<'_>, input: &Input) -> bool {
    input.layout != Layout::Results && row.record.iter().all(|cell| cell.trim_ascii().is_empty())
}

/// Returns what looks like an interrupted write, if this is the last row: a file may have been enlarged but not filled.
fn interrupted(row: &Row<'_>) -> Option<&'static str> {
    if !row.last {
        return None;
    }
    let raw = row.raw();
    let is_ended = raw.ends_with(b"\n") || raw.ends_with(b"\r");
    if raw.contains(&0) { Some("contains zero bytes") } else { (!is_ended).then_some("is cut off") }
}

fn left_behind(what: &str) -> String {
    format!("the last row {what}, as after an interrupted write; expected a complete row (this one is left out)")
}

/// Returns one column of all files.
pub(super) fn column_of<'a>(
    inputs: &[Input],
    tables: &'a [Rows],
    column: impl Fn(&Columns) -> usize,
) -> Vec<&'a Texts> {
    inputs.iter().zip(tables).map(|(input, rows)| &rows.columns[column(&input.columns)]).collect()
}
