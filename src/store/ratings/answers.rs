//! Reads answers at levels from a table of any program: level, number of correct answers, number of trials.

use std::path::Path;

use super::{
    files::Header,
    reader::{about_ids, alike, how_read},
    rows::{MAX_ROWS, RowError, Rows, Status, is_mark, is_missing},
    selection::{Columns as Places, Input, has_session_rows},
    source::Layout,
};
use crate::{
    experiment::SIMULATED,
    store::{Columns, FileError, FileErrors, StoreError, table::with_point},
};

/// The columns of a table of answers.
#[derive(Clone, Debug, Default)]
pub struct AnswerColumns {
    /// The level.
    pub level: String,
    /// The number of correct answers, or of yes answers.
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
    /// Number of correct answers.
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
    /// What a user should know about how the table was read.
    pub notes: Vec<FileError>,
    /// What is wrong with the rows that are left out because of it.
    pub errors: Vec<FileError>,
}

/// Reads a table: CSV with any usual separator and encoding, or the first sheet of a workbook.
///
/// # Errors
/// The file cannot be read, a column is missing, or a row has an unexpected value. Every row with an error is told.
pub fn read(path: &Path, columns: &AnswerColumns) -> Result<AnswersRead, StoreError> {
    let mut read = answers(Input::plain(path.to_owned(), Header::read(path)?, Layout::Long), columns)?;
    FileErrors::none(std::mem::take(&mut read.errors))?;
    Ok(read)
}

/// Takes the rows of a table in memory; `name` stands for it in messages. Rows with an unexpected value are among the errors
/// that were found.
///
/// # Errors
/// The columns differ in length, one is missing, or every row has an error.
pub fn of_columns(name: &str, table: &Columns, columns: &AnswerColumns) -> Result<AnswersRead, StoreError> {
    table.check(name)?;
    answers(Input::plain(name.into(), Header::of(table.clone()), Layout::Long), columns)
}

fn answers(mut input: Input, columns: &AnswerColumns) -> Result<AnswersRead, StoreError> {
    let used = Used::new(&input, columns)?;
    input.columns = used.places();
    let mut rows = Rows::read(&input).map_err(|error| FileErrors(vec![error]))?;
    let (mut found, mut errors) = (Vec::new(), std::mem::take(&mut rows.errors));
    for row in (0..rows.status.len()).filter(|row| rows.status[*row] != Status::Wrong) {
        match used.row(|cell| rows.columns[cell].get(row), input.header.separator) {
            Ok(answer) => found.push(answer),
            Err((cell, expected)) => rows.report(&mut errors, RowError::new(row, cell, expected), &input, &[]),
        }
    }
    rows.errors = errors;
    let mut notes: Vec<FileError> = how_read(&input, &rows).collect();
    if let Some(subject) = used.subject {
        notes.extend(input.header.note_of_subject(&input.name, subject).filter(|_| columns.subject.is_none()));
        notes.extend(about_ids(&input.name, &[&rows.columns[subject]]));
    }
    let factors = columns.factors.iter().zip(&used.factors);
    notes.extend(factors.filter_map(|(name, cell)| alike(&input.name, Some(name), &[&rows.columns[*cell]])));
    notes.extend(used.pooled(&input, &rows));
    let errors = rows.errors.finish(&input.name, &input.header.names);
    let all = found.len();
    let rows: Vec<AnswerRow> = found.into_iter().flatten().collect();
    let answers = rows.iter().map(|row| u64::from(row.total)).sum::<u64>();
    for (what, found, most) in [("rows", rows.len() as u64, MAX_ROWS as u64), ("answers", answers, u32::MAX.into())] {
        if !(1..=most).contains(&found) {
            FileErrors::none(errors)?;
            return Err(FileErrors::whole(&input.name, format!("has {found} {what}; expected 1 to {most}")).into());
        }
    }
    Ok(AnswersRead { missing: all - rows.len(), rows, notes, errors })
}

/// Where the columns are.
struct Used {
    level: usize,
    correct: usize,
    total: Option<usize>,
    subject: Option<usize>,
    factors: Vec<usize>,
    simulated: Option<usize>,
    /// If no factors were named, the columns that may tell conditions apart.
    unused: Vec<usize>,
}

/// Maximum number of these columns, and of the levels of one.
const MAX_UNUSED: usize = 20;

impl Used {
    fn new(input: &Input, columns: &AnswerColumns) -> Result<Self, FileErrors> {
        let (name, header) = (&input.name, &input.header);
        if has_session_rows(header) {
            let message = "has the rows of a session, among them practice, catch trials and corrected answers; expected the folder \
                           of the sessions, without the names of columns";
            return Err(FileErrors::whole(name, message));
        }
        let place = |column: &String| input.place(column).map_err(|error| FileErrors(vec![error]));
        let subject = columns.subject.clone().or_else(|| header.subject().map(str::to_owned));
        let given = [&columns.level, &columns.correct];
        let all = given.into_iter().chain(&columns.total).chain(&subject).chain(&columns.factors);
        let mut names: Vec<&String> = all.collect();
        names.sort();
        if let Some(twice) = names.windows(2).find(|pair| pair[0] == pair[1]) {
            let message = format!("the column {} has two uses; expected one for each column", twice[0]);
            return Err(FileErrors::whole(name, message));
        }
        let is_unused = |name: &String| names.binary_search(&name).is_err() && name != SIMULATED;
        let unused = (0..header.names.len()).filter(|at| columns.factors.is_empty() && is_unused(&header.names[*at]));
        Ok(Self {
            unused: unused.take(MAX_UNUSED).collect(),
            level: place(&columns.level)?,
            correct: place(&columns.correct)?,
            total: columns.total.as_ref().map(place).transpose()?,
            subject: subject.as_ref().map(place).transpose()?,
            factors: columns.factors.iter().map(place).collect::<Result<_, _>>()?,
            simulated: header.position(SIMULATED),
        })
    }

    /// Returns a note if rows that may be of several people or conditions are taken together, because no columns were
    /// named.
    fn pooled(&self, input: &Input, rows: &Rows) -> Option<FileError> {
        let has_levels = |column: &&usize| (2..=MAX_UNUSED).contains(&rows.columns[**column].texts.len());
        let unused = self.unused.iter().filter(has_levels).map(|column| input.header.names[*column].as_str());
        let unused: Vec<&str> = unused.collect();
        let people = if self.subject.is_some() { "" } else { " and are those of one participant" };
        let message = format!(
            "all rows are of one condition{people}, because no column was named; expected --factors if conditions differ in {}",
            unused.join(", ")
        );
        (!unused.is_empty()).then(|| FileError::whole(&input.name, message))
    }

    /// Returns the columns that are read.
    fn places(&self) -> Places {
        Places {
            subject: self.subject.unwrap_or(self.level),
            responses: vec![self.correct],
            count: self.total,
            factors: self.factors.iter().chain(&self.unused).copied().chain([self.level]).collect(),
            simulated: self.simulated,
            ..Places::default()
        }
    }

    /// Reads a row; `None` if it has no level or no answer. An error has its cell.
    fn row<'a>(
        &self,
        text: impl Fn(usize) -> &'a str,
        separator: u8,
    ) -> Result<Option<AnswerRow>, (usize, &'static str)> {
        let needed = [Some(self.level), Some(self.correct), self.total];
        if needed.into_iter().flatten().any(|cell| is_missing(text(cell), true)) {
            return Ok(None);
        }
        let number = |cell: usize| with_point(text(cell), separator).parse::<f64>().ok();
        let count = |cell: usize, expected: &'static str| {
            let number = match text(cell) {
                truth if truth.eq_ignore_ascii_case("true") => Some(1.0),
                truth if truth.eq_ignore_ascii_case("false") => Some(0.0),
                _ => number(cell),
            };
            let number = number.filter(|number| number.fract() == 0.0 && (0.0..=1e9).contains(number));
            number.map(|number| number as u32).ok_or((cell, expected))
        };
        let named = |cell: usize, expected: &'static str| {
            Some(text(cell).to_owned()).filter(|name| !is_missing(name, false)).ok_or((cell, expected))
        };
        let (total, expected) = match self.total {
            Some(cell) => (count(cell, "a number of trials")?, "a number of correct answers"),
            None => (1, "1 for a correct answer, or 0"),
        };
        let correct = count(self.correct, expected)?;
        if correct > total {
            let expected = if self.total.is_some() { "no more correct answers than trials" } else { expected };
            return Err((self.correct, expected));
        }
        let level = number(self.level).filter(|level| level.is_finite());
        Ok(Some(AnswerRow {
            subject: self.subject.map_or(Ok("all".to_owned()), |cell| named(cell, "a participant"))?,
            factors: self.factors.iter().map(|cell| named(*cell, "a level")).collect::<Result<_, _>>()?,
            level: level.ok_or((self.level, "a level, which is a number"))?,
            correct,
            total,
            is_simulated: self.simulated.is_some_and(|cell| is_mark(text(cell))),
        }))
    }
}
