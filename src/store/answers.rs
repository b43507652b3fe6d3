//! Reads answers at levels from a table of any program: level, number of right answers, number of trials.

use std::path::Path;

use super::{
    Columns, FileError, FileErrors, StoreError,
    error::RowErrors,
    ratings::{Header, Layout, checked, has_session_rows, is_mark, is_missing, with_point},
    table::{decoded, rows_from},
};
use crate::{experiment::SIMULATED, text::names::expected_one_of};

/// The columns of a table of answers.
#[derive(Clone, Debug, Default)]
pub struct AnswerColumns {
    /// The level.
    pub level: String,
    /// The number of right answers, or of yes answers.
    pub correct: String,
    /// The number of trials; without it, each row is one trial.
    pub total: Option<String>,
    /// The participant [default: as in a table of ratings]; without such a column, all rows are those of one.
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
    /// Whether a program answered, as the column `simulated` says, if there is one.
    pub is_simulated: bool,
}

/// The rows of a table of answers.
#[derive(Clone, Debug, PartialEq)]
pub struct AnswersRead {
    /// The rows.
    pub rows: Vec<AnswerRow>,
    /// Number of rows without a level or an answer, which are left out.
    pub missing: usize,
    /// Which column has the participants, if that is not plain.
    pub note: Option<FileError>,
}

/// Maximum number of rows.
const MAX_ROWS: usize = 10_000_000;

/// Reads a table: CSV with any usual separator and encoding, or the first sheet of a workbook.
///
/// # Errors
/// The file cannot be read, a column is missing, or a row has an unexpected value. Every row with an error is told.
pub fn read(path: &Path, columns: &AnswerColumns) -> Result<AnswersRead, StoreError> {
    let header = Header::read(path)?;
    let name = path.display().to_string();
    let places = Places::new(&name, &header, columns)?;
    let used = places.all().collect();
    let (mut rows, mut errors, mut is_header) = (Vec::new(), RowErrors::default(), true);
    let outcome = rows_from(header.content(path), header.separator, header.start.as_ref(), |row| {
        if !std::mem::take(&mut is_header) {
            let text = |cell: usize| row.record.get(cell).map(decoded).unwrap_or_default().trim().to_owned();
            let found = checked(row, &used, header.names.len(), Layout::Long);
            let found = found
                .and_then(|()| places.row(text, header.separator).map_err(|(cell, message)| (Some(cell), message)));
            match found {
                Ok(row) => rows.push(row),
                Err((cell, message)) => errors.add(&name, cell, message, || row.place(cell.unwrap_or(0))),
            }
        }
        rows.len() <= MAX_ROWS
    });
    outcome.map_err(|error| StoreError::io(path, "read", error))?;
    finish(rows, errors.finish(&name, &header.names), &name, places.note)
}

/// Takes the rows of a table in memory; `name` stands for it in messages.
///
/// # Errors
/// As for [`read`].
pub fn of_columns(name: &str, table: &Columns, columns: &AnswerColumns) -> Result<AnswersRead, StoreError> {
    table.check(name)?;
    let header = Header::of(table.clone());
    let places = Places::new(name, &header, columns)?;
    let (mut rows, mut errors) = (Vec::new(), RowErrors::default());
    for row in 0..table.rows() {
        match places.row(|cell| table.cell(row, cell).trim().to_owned(), header.separator) {
            Ok(row) => rows.push(row),
            Err((cell, message)) => {
                let file = format!("{name}, row {row} (counted from 0)");
                errors.add_with(Some(row), Some(cell), || {
                    FileError::whole(file, format!("{}: {message}", header.names[cell]))
                });
            }
        }
    }
    finish(rows, errors.finish(name, &header.names), name, places.note)
}

fn finish(
    rows: Vec<Option<AnswerRow>>,
    errors: Vec<FileError>,
    name: &str,
    note: Option<FileError>,
) -> Result<AnswersRead, StoreError> {
    FileErrors::none(errors)?;
    let all = rows.len();
    let rows: Vec<AnswerRow> = rows.into_iter().flatten().collect();
    if rows.is_empty() || rows.len() > MAX_ROWS {
        let message = format!("has {} rows; expected 1 to {MAX_ROWS}", rows.len());
        return Err(FileErrors::whole(name, message).into());
    }
    Ok(AnswersRead { missing: all - rows.len(), rows, note })
}

/// Where the columns are.
struct Places {
    level: usize,
    correct: usize,
    total: Option<usize>,
    subject: Option<usize>,
    factors: Vec<usize>,
    simulated: Option<usize>,
    note: Option<FileError>,
}

impl Places {
    fn new(name: &str, header: &Header, columns: &AnswerColumns) -> Result<Self, FileErrors> {
        if has_session_rows(header) {
            let message = "has the rows of a session, among them practice, catch trials and corrected answers; expected the folder \
                           of the sessions, without the names of columns";
            return Err(FileErrors::whole(name, message));
        }
        let place = |column: &String| {
            header.position(column).ok_or_else(|| {
                let message = format!("has no column {column:?}; {}", expected_one_of(column, &header.names));
                FileErrors::whole(name, message)
            })
        };
        let subject = columns.subject.clone().or_else(|| header.subject().map(str::to_owned));
        let given = [&columns.level, &columns.correct];
        let all = given.into_iter().chain(&columns.total).chain(&subject).chain(&columns.factors);
        let mut names: Vec<&String> = all.collect();
        names.sort();
        if let Some(twice) = names.windows(2).find(|pair| pair[0] == pair[1]) {
            let message = format!("the column {} has two uses; expected one for each column", twice[0]);
            return Err(FileErrors::whole(name, message));
        }
        let subject = subject.as_ref().map(place).transpose()?;
        Ok(Self {
            level: place(&columns.level)?,
            correct: place(&columns.correct)?,
            total: columns.total.as_ref().map(place).transpose()?,
            subject,
            factors: columns.factors.iter().map(place).collect::<Result<_, _>>()?,
            simulated: header.position(SIMULATED),
            note: subject.filter(|_| columns.subject.is_none()).and_then(|index| header.note_of_subject(name, index)),
        })
    }

    fn all(&self) -> impl Iterator<Item = usize> {
        let further = [self.total, self.subject, self.simulated].into_iter().flatten();
        [self.level, self.correct].into_iter().chain(further).chain(self.factors.iter().copied())
    }

    /// Reads a row; `None` if it has no level or no answer. An error has its cell.
    fn row(&self, text: impl Fn(usize) -> String, separator: u8) -> Result<Option<AnswerRow>, (usize, String)> {
        if [Some(self.level), Some(self.correct), self.total]
            .into_iter()
            .flatten()
            .any(|cell| is_missing(&text(cell), true))
        {
            return Ok(None);
        }
        let wrong = |cell: usize, expected: &str| (cell, format!("is {:?}; expected {expected}", text(cell)));
        let point = |cell: usize| with_point(&text(cell), separator).into_owned();
        let count = |cell: usize, expected: &str| {
            let number = match point(cell) {
                truth if truth.eq_ignore_ascii_case("true") => Some(1.0),
                truth if truth.eq_ignore_ascii_case("false") => Some(0.0),
                number => number.parse().ok(),
            };
            let number = number.filter(|number: &f64| number.fract() == 0.0 && (0.0..=1e9).contains(number));
            number.map(|number| number as u32).ok_or_else(|| wrong(cell, expected))
        };
        let named = |cell: usize, expected: &str| {
            Some(text(cell)).filter(|name| !name.is_empty()).ok_or_else(|| wrong(cell, expected))
        };
        let (total, expected) = match self.total {
            Some(cell) => (count(cell, "a number of trials")?, "a number of right answers"),
            None => (1, "1 for a right answer, or 0"),
        };
        let correct = count(self.correct, expected)?;
        if correct > total {
            let expected = if self.total.is_some() { "no more right answers than trials" } else { expected };
            return Err(wrong(self.correct, expected));
        }
        let level = point(self.level).parse().ok().filter(|level: &f64| level.is_finite());
        Ok(Some(AnswerRow {
            subject: self.subject.map_or(Ok("all".to_owned()), |cell| named(cell, "a participant"))?,
            factors: self.factors.iter().map(|cell| named(*cell, "a level")).collect::<Result<_, _>>()?,
            level: level.ok_or_else(|| wrong(self.level, "a level, which is a number"))?,
            correct,
            total,
            is_simulated: self.simulated.is_some_and(|cell| is_mark(&text(cell))),
        }))
    }
}
