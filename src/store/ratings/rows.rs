//! The rows of a file as columns, the errors in them, and what the text of a cell means. Each file is read once.

use std::{borrow::Cow, collections::BTreeMap};

use csv::{ByteRecord, Position};
use serde_json::{Map, Value};

use super::selection::{Columns, Input};
use crate::store::{
    FileError,
    columns::{Interner, Texts},
    error::RowErrors,
    ratings::source::Layout,
    table::{self, Row, decoded, shortened, with_point},
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
    /// A cell that is used has no exact value, or a zero byte.
    pub fn read(input: &Input) -> Result<Self, FileError> {
        let header = &input.header;
        let used = input.columns.used();
        if let Some(columns) = &header.columns {
            let texts =
                |column: usize| if used.contains(&column) { columns.texts(column).clone() } else { Texts::default() };
            let mut rows = Self {
                columns: (0..header.names.len()).map(texts).collect(),
                status: vec![Status::Counts(0); columns.rows()],
                ..Self::default()
            };
            let has_zero_byte = |column: &Texts| column.texts.iter().any(|text| text.contains('\0'));
            if let Some(column) = rows.columns.iter().position(has_zero_byte) {
                let name = &header.names[column];
                let message = format!("a cell of the column {name} contains a zero byte; expected text");
                return Err(FileError::whole(&input.name, message));
            }
            rows.unwrap_answers(input);
            return Ok(rows);
        }
        if let Some((row, column, problem)) = header.text.unusable.iter().find(|(_, column, _)| used.contains(column)) {
            return Err(FileError::at(&input.name, (row + 1, column + 1), *problem));
        }
        let mut rows = Self::default();
        let mut columns: Vec<Interner> = header.names.iter().map(|_| Interner::default()).collect();
        let mut heads = 1 + header.labels;
        table::rows_from(header.content(), header.separator, None, |row| {
            let incomplete = if input.layout == Layout::Results { interrupted(row) } else { None };
            if heads > 0 {
                heads -= 1;
                rows.foreign = rows.foreign.or(row.text().err().map(|cell| row.place(cell)));
            } else if is_blank(row, input) {
            } else if let Some(what) = incomplete {
                match &input.sidecar {
                    Some(sidecar) if !sidecar.is_sealed() => rows.interrupted = Some(row.place(0).0),
                    _ => rows.errors.add(None, None, || {
                        let expected = "expected a complete row (this one is left out)";
                        let message = format!("the last row {what}, as after an interrupted write; {expected}");
                        FileError::at(&input.name, row.place(0), message)
                    }),
                }
            } else {
                let index = rows.status.len();
                if index.is_multiple_of(MARK) {
                    rows.marks.push(row.start.clone());
                }
                let foreign = row.text().err().map(|cell| {
                    rows.foreign.get_or_insert_with(|| row.place(cell));
                    row.record.iter().map(|cell| decoded(cell).into_owned()).collect::<ByteRecord>()
                });
                let record = foreign.as_ref().unwrap_or(row.record);
                let text = match row.check(&used, header.names.len(), input.layout == Layout::Results) {
                    Ok(()) => std::str::from_utf8(record.as_slice()).ok(),
                    Err((cell, message)) => {
                        let place = || row.place(cell.unwrap_or(0));
                        rows.errors.add(None, cell, || FileError::at(&input.name, place(), message));
                        None
                    }
                };
                let cell = |column| text.and_then(|text| text.get(record.range(column)?)).unwrap_or_default().trim();
                used.iter().for_each(|&column| columns[column].push(cell(column)));
                rows.status.push(if text.is_some() { Status::Counts(0) } else { Status::Wrong });
            }
            rows.status.len() <= MAX_ROWS
        });
        rows.columns = columns.into_iter().map(Interner::finish).collect();
        rows.replace_commas(input)?;
        rows.unwrap_answers(input);
        Ok(rows)
    }

    /// Replaces decimal commas by points, except in IDs.
    ///
    /// # Errors
    /// Commas or points seem to separate thousands.
    fn replace_commas(&mut self, input: &Input) -> Result<(), FileError> {
        let Columns { subject, session, .. } = input.columns;
        let ids = [Some(subject), session];
        let separator = input.header.separator;
        let columns = self.columns.iter_mut().enumerate();
        for (index, column) in columns.filter(|(index, _)| separator != b',' && !ids.contains(&Some(*index))) {
            if let Some(grouped) = [',', '.'].into_iter().find_map(|mark| with_thousands(&column.texts, mark)) {
                let name = &input.header.names[index];
                let expected = "expected numbers without marks between thousands, or with another number of decimals";
                let message =
                    format!("it is not clear whether {grouped} in the column {name} has decimals; {expected}");
                return Err(input.error(index, message));
            }
            column.texts.iter_mut().for_each(|text| {
                if let Cow::Owned(number) = with_point(text, separator) {
                    *text = number.into();
                }
            });
        }
        Ok(())
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

    /// Adds an error to those of the file.
    pub fn report(&self, errors: &mut RowErrors, error: RowError, input: &Input, inputs: &[Input]) {
        let row = input.in_memory().then_some(error.row);
        errors.add(row, error.cell, || self.placed(&error, input, inputs));
    }

    /// Returns an error with its place.
    fn placed(&self, error: &RowError, input: &Input, inputs: &[Input]) -> FileError {
        if let Some(columns) = &input.header.columns {
            let message = error.message(input, inputs, |column| columns.texts(column).get(error.row).to_owned());
            let place = format!("{}, row {} (counted from 0)", input.name, error.row);
            return FileError { rows: vec![error.row], ..FileError::whole(place, message) };
        }
        let (header, mut skipped, mut found) = (&input.header, error.row % MARK, None);
        let from = self.marks.get(error.row / MARK);
        // The row is read again, which is acceptable because errors are rare.
        table::rows_from(header.content(), header.separator, from, |row| {
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

/// Returns one column of all files.
pub(super) fn column_of<'a>(
    inputs: &[Input],
    tables: &'a [Rows],
    column: impl Fn(&Columns) -> usize,
) -> Vec<&'a Texts> {
    inputs.iter().zip(tables).map(|(input, rows)| &rows.columns[column(&input.columns)]).collect()
}

/// Maximum count in a row. The sum of many such counts still fits in 64 bits.
const MAX_COUNT: f64 = 1e12;

/// True if a cell has no value. Words that are only sometimes written for a missing value may name a level, so they are
/// missing only if all other values of the column are numbers (`among_numbers`).
pub(super) fn is_missing(text: &str, among_numbers: bool) -> bool {
    matches!(text, "" | "NA" | "NaN" | "nan" | "NULL" | "#NULL!" | "#N/A" | "N/A" | "n/a")
        || (among_numbers && matches!(text, "." | "None" | "null"))
}

/// True if there is no response: the cell has no value, or one of the texts that are `named` as missing.
pub(super) fn is_no_response(text: &str, named: &[String], among_numbers: bool) -> bool {
    let same = |name: &String| name == text || number(name).is_some_and(|named| number(text) == Some(named));
    is_missing(text, among_numbers) || matches!(text, "." | "null") || named.iter().any(same)
}

/// Returns the value of a JSON object with a single entry, as jsPsych writes the answer to a question; empty for `null`.
pub(super) fn answer(text: &str) -> Option<String> {
    let object: Map<String, Value> =
        if text.starts_with('{') { serde_json::from_str(text).ok()? } else { return None };
    let mut values = object.into_iter().map(|(_, value)| value);
    match (values.next()?, values.next()) {
        (Value::String(text), None) => Some(text),
        (Value::Null, None) => Some(String::new()),
        (value @ (Value::Number(_) | Value::Bool(_)), None) => Some(value.to_string()),
        _ => None,
    }
}

/// Returns the groups of IDs that differ only in capitals, in zeros before a number, or in its form, such as `1.0`.
pub(super) fn alike<'a>(ids: impl Iterator<Item = &'a str>) -> Vec<Vec<&'a str>> {
    let mut groups: BTreeMap<String, Vec<&str>> = BTreeMap::new();
    for id in ids.filter(|id| !id.is_empty()) {
        let group = groups.entry(common_form(id)).or_default();
        if !group.contains(&id) {
            group.push(id);
        }
    }
    groups.into_values().filter(|group| group.len() > 1).collect()
}

fn common_form(id: &str) -> String {
    // A number with more digits would be rounded.
    if let Some(number) = number(id).filter(|_| id.len() <= 15) {
        return (number + 0.0).to_string();
    }
    let mut form = String::new();
    let lower = id.to_lowercase();
    let mut rest = lower.chars().peekable();
    while let Some(char) = rest.next() {
        let is_first = !form.ends_with(|before: char| before.is_ascii_digit() || before == '.');
        if char != '0' || !is_first || !rest.peek().is_some_and(char::is_ascii_digit) {
            form.push(char);
        }
    }
    form
}

/// Returns a number such as 1,000 if every text of a column with this mark has three digits between marks, and other numbers
/// are whole from 100, or have two marks: then the mark may separate thousands.
fn with_thousands(texts: &[Box<str>], mark: char) -> Option<&str> {
    let is_whole = |text: &str| text.bytes().all(|byte| byte.is_ascii_digit());
    let is_grouped = |text: &str| {
        let (first, others) = text.trim_start_matches('-').split_once(mark).unwrap_or_default();
        let is_first = (1..=3).contains(&first.len()) && !first.starts_with('0') && is_whole(first);
        is_first && others.split(mark).all(|part| part.len() == 3 && is_whole(part))
    };
    let is_large =
        |text: &str| text.len() > 2 && is_whole(text) && !text.starts_with('0') || text.matches(mark).count() > 1;
    let all = texts.iter().map(AsRef::as_ref);
    let mut marked = all.clone().filter(|text: &&str| text.contains(mark));
    let first = marked.clone().next()?;
    (marked.all(is_grouped) && all.into_iter().any(is_large)).then_some(first)
}

/// Returns the number in a cell; `None` for other texts and missing values.
pub(super) fn number(text: &str) -> Option<f64> {
    text.parse().ok().filter(|number: &f64| !number.is_nan())
}

/// True if all values of a column, in all files together, are numbers.
pub(super) fn are_numbers(column: &[&Texts]) -> bool {
    let mut values = column.iter().flat_map(|file| &file.texts).filter(|text| !is_missing(text, true)).peekable();
    values.peek().is_some() && values.all(|text| number(text).is_some())
}

/// True if hardly any values of a column, at most one in 50, are not numbers: these are then mistakes.
pub(super) fn are_mostly_numbers(column: &[&Texts]) -> bool {
    let rows = |is: fn(&str) -> bool| -> usize {
        column.iter().map(|file| file.map(is).iter().filter(|is| **is).count()).sum()
    };
    50 * rows(|text| !is_missing(text, true) && number(text).is_none()) <= rows(|text| !is_missing(text, true))
}

/// Returns a whole number from 1 to a million, written with digits only; a session has at most 100,000 trials.
pub(super) fn ordinal(text: &str) -> Option<u32> {
    let digits = text.len() < 10 && text.bytes().all(|byte| byte.is_ascii_digit());
    text.parse().ok().filter(|number| digits && (1..=1_000_000).contains(number))
}

/// True if a text is a rating: a number on our own scale, or on other scales anything but a missing value.
pub(super) fn is_rating(text: &str, own_scale: Option<u8>, among_numbers: bool) -> bool {
    if let Some(highest) = own_scale {
        // A spreadsheet or pandas may have written 2 as 2.0.
        text.parse().is_ok_and(|number: f64| (0..=highest).any(|rating| number == f64::from(rating)))
    } else {
        !is_missing(text, among_numbers)
    }
}

/// Returns a level as the definition writes it, so that a level that a spreadsheet or pandas wrote as `0.40` or `1.0` is
/// the level `0.4` or `1`; otherwise as it is written. A missing value is empty.
pub(super) fn level<'a>(text: &'a str, defined: &'a [String], among_numbers: bool) -> &'a str {
    if is_missing(text, among_numbers) {
        return "";
    }
    let is_exact = defined.iter().any(|level| level == text);
    let number = if is_exact { None } else { text.parse::<f64>().ok() };
    let same = number.and_then(|number| defined.iter().find(|level| level.parse() == Ok(number)));
    same.map_or(text, String::as_str)
}

/// Returns how many trials a row represents. A count of 3 may be written as `3.0`, because pandas does so.
///
/// # Errors
/// Says what was expected.
pub(super) fn count(text: &str) -> Result<u64, &'static str> {
    let count = text.parse::<f64>().ok().filter(|count| (0.0..=MAX_COUNT).contains(count) && count.fract() == 0.0);
    count.map(|count| count as u64).ok_or("a count, a whole number from 0 to 10^12")
}

/// Returns the value of a cell, which may be missing.
///
/// # Errors
/// Says what was expected, if there is no value although the cell is not missing.
pub(super) fn optional<T>(text: &str, value: Option<T>, expected: &'static str) -> Result<Option<T>, &'static str> {
    if is_missing(text, true) { Ok(None) } else { value.map(Some).ok_or(expected) }
}

/// True if a cell of the column `simulated` says that a program answered: anything but no value, 0, false and no.
pub(super) fn is_mark(text: &str) -> bool {
    let denies = |word: &str| text.eq_ignore_ascii_case(word);
    !is_missing(text, true) && number(text) != Some(0.0) && !denies("false") && !denies("no")
}
