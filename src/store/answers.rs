//! Reads answers at levels from a table of any program: level, number of right answers, number of trials.

use std::path::Path;

use super::{
    FileError, FileErrors, StoreError,
    error::RowErrors,
    ratings::Header,
    table::{Row, decoded, rows_from},
};
use crate::text::names::expected_one_of;

/// The columns of a table of answers.
#[derive(Clone, Debug, Default)]
pub struct AnswerColumns {
    /// The level.
    pub level: String,
    /// The number of right answers, or of answers yes.
    pub correct: String,
    /// The number of trials; without it, each row is one trial.
    pub total: Option<String>,
    /// The participant; without it, all rows are those of one.
    pub subject: Option<String>,
    /// The factors.
    pub factors: Vec<String>,
}

/// A row of a table of answers.
#[derive(Clone, Debug, PartialEq)]
pub struct AnswerRow {
    /// The participant.
    pub subject: String,
    /// The level of each factor.
    pub factors: Vec<String>,
    /// The level.
    pub level: f64,
    /// Number of right answers.
    pub correct: u32,
    /// Number of trials.
    pub total: u32,
}

/// Maximum number of rows.
const MAX_ROWS: usize = 10_000_000;

/// Reads a table: CSV with any usual separator and encoding, or the first sheet of a workbook.
///
/// # Errors
/// The file cannot be read, a column is missing, or a row has an unexpected value. Every row with an error is told.
pub fn read(path: &Path, columns: &AnswerColumns) -> Result<Vec<AnswerRow>, StoreError> {
    let header = Header::read(path)?;
    let place = |name: &String| {
        header.position(name).ok_or_else(|| {
            let message = format!("has no column {name:?}; {}", expected_one_of(name, &header.names));
            FileErrors(vec![FileError::at(path, (header.line, 1), message)])
        })
    };
    let (level, correct) = (place(&columns.level)?, place(&columns.correct)?);
    let (total, subject) =
        (columns.total.as_ref().map(place).transpose()?, columns.subject.as_ref().map(place).transpose()?);
    let factors = columns.factors.iter().map(place).collect::<Result<Vec<usize>, _>>()?;
    let read = |row: &Row<'_>| -> Result<AnswerRow, (usize, &'static str)> {
        let text = |cell: usize| row.record.get(cell).map(decoded).unwrap_or_default().trim().to_owned();
        // In a table with semicolons, numbers may have decimal commas.
        let point = |cell: usize| if header.separator == b';' { text(cell).replace(',', ".") } else { text(cell) };
        let count = |cell: usize, expected| {
            let number =
                point(cell).parse().ok().filter(|number: &f64| number.fract() == 0.0 && (0.0..=1e9).contains(number));
            number.map(|number| number as u32).ok_or((cell, expected))
        };
        let x = point(level).parse().ok().filter(|level: &f64| level.is_finite());
        let trials = match total {
            Some(cell) => count(cell, "a number of trials")?,
            None => 1,
        };
        let expected = if total.is_some() { "a number of right answers" } else { "1 for a right answer, or 0" };
        let right = count(correct, expected)?;
        if right > trials {
            return Err((correct, "no more right answers than trials"));
        }
        let named = |cell: usize, expected| Some(text(cell)).filter(|name| !name.is_empty()).ok_or((cell, expected));
        Ok(AnswerRow {
            subject: subject.map_or(Ok("all".to_owned()), |cell| named(cell, "a participant"))?,
            factors: factors.iter().map(|cell| named(*cell, "a level")).collect::<Result<_, _>>()?,
            level: x.ok_or((level, "a level, which is a number"))?,
            correct: right,
            total: trials,
        })
    };
    let name = path.display().to_string();
    let (mut rows, mut errors, mut is_header) = (Vec::new(), RowErrors::default(), true);
    let outcome = rows_from(header.content(path), header.separator, header.start.as_ref(), |row| {
        if !std::mem::take(&mut is_header) {
            match read(row) {
                Ok(row) => rows.push(row),
                Err((cell, expected)) => {
                    let given = row.record.get(cell).map(decoded).unwrap_or_default().into_owned();
                    let message = format!("is {given:?}; expected {expected}");
                    errors.add(&name, Some(cell), message, || row.place(cell));
                }
            }
        }
        rows.len() <= MAX_ROWS
    });
    outcome.map_err(|error| StoreError::io(path, "read", error))?;
    FileErrors::none(errors.finish(&name, &header.names))?;
    if rows.is_empty() || rows.len() > MAX_ROWS {
        let message = format!("has {} rows; expected 1 to {MAX_ROWS}", rows.len());
        return Err(FileErrors::whole(path, message).into());
    }
    Ok(rows)
}
