//! One row of a file: its cells, its trial, and its errors.

use std::borrow::Cow;

use super::{
    selection::{Columns, RecordColumns},
    survey::is_missing,
    trials::{Identity, Trial},
};
use crate::{
    experiment::MAX_RATING,
    store::table::{Row, shortened},
};

/// Maximum count in a row. The sum of many such counts still fits in 64 bits.
const MAX_COUNT: f64 = 1e12;

/// The cells of a row, which are all valid text.
pub(super) struct Cells<'a> {
    /// All cells, with a point in every number.
    text: Cow<'a, str>,
    row: &'a Row<'a>,
    names: &'a [String],
}

impl<'a> Cells<'a> {
    /// Checks the cells of a row in a table with these column names.
    ///
    /// # Errors
    /// The row is not UTF-8, a quote is not closed, or the number of cells differs from the header's.
    pub fn new(row: &'a Row<'a>, names: &'a [String]) -> Result<Self, RowError> {
        let error = |cell, message: String| RowError { cell, message };
        let text = row.text().map_err(|_| error(None, "the row is not UTF-8 text; expected UTF-8".to_owned()))?;
        if row.is_open() {
            let message = "a quote is never closed; expected a closing quote".to_owned();
            return Err(error(Some(row.record.len() - 1), message));
        }
        let (found, width) = (row.record.len(), names.len());
        if found != width {
            let cells = if found == 1 { "cell" } else { "cells" };
            return Err(error(None, format!("the row has {found} {cells}; expected {width}, as in the header")));
        }
        Ok(Self { text: with_points(text, row), row, names })
    }

    /// Returns a cell without surrounding white space.
    pub fn get(&self, index: usize) -> &str {
        self.row.record.range(index).and_then(|range| self.text.get(range)).unwrap_or_default().trim()
    }

    /// Returns an ID exactly as written, without surrounding white space.
    pub fn id(&self, index: usize) -> &'a str {
        let text = self.row.text().unwrap_or_default();
        self.row.record.range(index).and_then(|range| text.get(range)).unwrap_or_default().trim()
    }

    /// Returns a level or a number as written; empty for a missing value.
    pub fn optional(&self, index: usize, among_numbers: bool) -> &str {
        Some(self.get(index)).filter(|text| !is_missing(text, among_numbers)).unwrap_or_default()
    }

    /// Returns an ID, which must not be empty.
    ///
    /// # Errors
    /// The cell is empty.
    pub fn present(&self, index: usize, expected: &str) -> Result<&'a str, RowError> {
        Some(self.id(index)).filter(|text| !text.is_empty()).ok_or_else(|| self.error(index, expected))
    }

    /// Creates the error for a cell with an unexpected value.
    fn error(&self, index: usize, expected: &str) -> RowError {
        let name = &self.names[index];
        let written = self.row.record.get(index).map(String::from_utf8_lossy).unwrap_or_default();
        let message = match written.trim() {
            "" => format!("{name} is empty; expected {expected}"),
            text => format!("{name} is {:?}; expected {expected}", shortened(text)),
        };
        RowError { cell: Some(index), message }
    }
}

/// Replaces the decimal comma of every number. If cells are not separated by commas, a comma in a number is a decimal
/// comma, as in spreadsheets from many countries.
fn with_points<'a>(text: &'a str, row: &Row<'_>) -> Cow<'a, str> {
    let mut text = Cow::Borrowed(text);
    if row.separator == b',' || !text.contains(',') {
        return text;
    }
    for range in (0..row.record.len()).filter_map(|index| row.record.range(index)) {
        // One comma, so that `1,234,567` stays text.
        if text[range.clone()].matches(',').count() == 1 {
            let number = text[range.clone()].replace(',', ".");
            if number.trim().parse::<f64>().is_ok() {
                text.to_mut().replace_range(range, &number);
            }
        }
    }
    text
}

/// Returns the trial that a row of a result file records.
///
/// # Errors
/// The first cell that is wrong.
pub(super) fn identity<'a>(
    cells: &'a Cells<'_>,
    subject: usize,
    columns: &RecordColumns,
    experiment: Option<&str>,
) -> Result<Identity<'a>, RowError> {
    if let Some((column, expected)) = columns.experiment.zip(experiment)
        && cells.get(column) != expected
    {
        return Err(cells.error(column, &format!("{expected}, as in the first row")));
    }
    let phase = cells.get(columns.phase).parse().map_err(|_| cells.error(columns.phase, "practice or main"))?;
    // Only digits, and a number from 1 to a million; a session has at most 100,000 trials.
    let number = |column: usize, expected: &str| {
        let text = cells.get(column);
        let digits = text.len() < 10 && text.bytes().all(|byte| byte.is_ascii_digit());
        let number = text.parse().ok().filter(|number| digits && (1..=1_000_000).contains(number));
        number.ok_or_else(|| cells.error(column, expected))
    };
    let trial = number(columns.trial, "the number of a trial, from 1 to 1000000")?;
    let attempt = number(columns.attempt, "the number of an attempt, from 1 to 1000000")?;
    Ok(Identity {
        subject: cells.present(subject, "a participant")?,
        session: cells.present(columns.session, "a session")?,
        trial: Trial::new(phase, trial, attempt),
    })
}

/// True if a string is a rating: a number on our own scale, or on other scales anything but a missing value.
pub(super) fn is_rating(text: &str, own_scale: bool, among_numbers: bool) -> bool {
    if own_scale {
        // A spreadsheet or pandas may have written 2 as 2.0.
        text.parse().is_ok_and(|number: f64| (0..=MAX_RATING).any(|rating| number == f64::from(rating)))
    } else {
        !is_missing(text, among_numbers)
    }
}

/// Returns the rating as written.
///
/// # Errors
/// The rating is missing or not on the scale.
pub(super) fn rating<'a>(
    cells: &'a Cells<'_>,
    columns: &Columns,
    own_scale: bool,
    among_numbers: bool,
) -> Result<&'a str, RowError> {
    match cells.get(columns.response) {
        text if is_rating(text, own_scale, among_numbers) => Ok(text),
        text if own_scale => {
            // Any scale is possible in a table from elsewhere.
            let is_other = columns.record.is_none() && !is_missing(text, among_numbers);
            let hint = if is_other { ", or the option response with this column for another scale" } else { "" };
            Err(cells.error(columns.response, &format!("a rating from 0 to {MAX_RATING}{hint}")))
        }
        _ => Err(cells.error(columns.response, "a rating")),
    }
}

/// Returns a level as the definition writes it, so that a level that a spreadsheet or pandas wrote as `0.40` or `1.0` is
/// the level `0.4` or `1`; otherwise as it is written.
pub(super) fn level<'a>(text: &'a str, defined: &'a [String]) -> &'a str {
    let is_exact = defined.is_empty() || text.is_empty() || defined.iter().any(|level| level == text);
    let number = if is_exact { None } else { text.parse::<f64>().ok() };
    let same = number.and_then(|number| defined.iter().find(|level| level.parse() == Ok(number)));
    same.map_or(text, String::as_str)
}

/// Returns how many trials a row represents. A count of 3 may be written as `3.0`, because pandas does so.
///
/// # Errors
/// The cell is not a count.
pub(super) fn count(cells: &Cells<'_>, columns: &Columns) -> Result<u64, RowError> {
    let Some(column) = columns.count else { return Ok(1) };
    let expected = match cells.get(column).parse::<f64>() {
        Ok(count) if (0.0..=MAX_COUNT).contains(&count) && count.fract() == 0.0 => return Ok(count as u64),
        Ok(number) if number < 0.0 => "a count, 0 or more",
        Ok(number) if number > MAX_COUNT => "a count of at most 10^12",
        Ok(_) => "a count without a fraction",
        Err(_) => "a count, a whole number",
    };
    Err(cells.error(column, expected))
}

/// Returns the session and the repetition; `None` if the file does not have them or the repetition is missing.
///
/// # Errors
/// The repetition is not a number.
pub(super) fn place<'a>(cells: &'a Cells<'_>, columns: &Columns) -> Result<Option<(&'a str, u32)>, RowError> {
    let Some((session, column)) = columns.session.zip(columns.repetition) else { return Ok(None) };
    match (cells.optional(column, true), cells.get(column).parse()) {
        ("", _) => Ok(None),
        (_, Ok(repetition)) => Ok(Some((cells.get(session), repetition))),
        (_, Err(_)) => Err(cells.error(column, "the number of a repetition, 1 or more")),
    }
}

/// Returns the response time in seconds; `None` if the file does not have it or it is missing.
///
/// # Errors
/// The cell is not a time.
pub(super) fn response_time(cells: &Cells<'_>, columns: &Columns) -> Result<Option<f64>, RowError> {
    let Some(column) = columns.time else { return Ok(None) };
    match (cells.optional(column, true), cells.get(column).parse()) {
        ("", _) => Ok(None),
        (_, Ok(seconds)) if f64::is_finite(seconds) && seconds >= 0.0 => Ok(Some(seconds)),
        _ => Err(cells.error(column, "seconds, 0 or more")),
    }
}

/// An error in a row.
#[derive(Clone, Debug)]
pub(super) struct RowError {
    /// Index of the cell; `None` if the error is about the row as a whole.
    pub cell: Option<usize>,
    /// What is wrong; what is expected.
    pub message: String,
}
