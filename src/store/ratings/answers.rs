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
    let subject = columns.subject.clone().or_else(|| input.header.subject().map(str::to_owned));
    input.columns = places(&input, columns, subject.as_ref())?;
    let mut rows = Rows::read(&input).map_err(|error| FileErrors(vec![error]))?;
    let (mut found, mut errors) = (Vec::new(), std::mem::take(&mut rows.errors));
    let used = Used { has_subject: subject.is_some(), factors: columns.factors.len(), places: &input.columns };
    for row in (0..rows.status.len()).filter(|row| rows.status[*row] != Status::Wrong) {
        match used.row(|cell| rows.columns[cell].get(row), input.header.separator) {
            Ok(answer) => found.push(answer),
            Err((cell, expected)) => rows.report(&mut errors, RowError::new(row, cell, expected), &input, &[]),
        }
    }
    rows.errors = errors;
    let mut notes: Vec<FileError> = how_read(&input, &rows).collect();
    if used.has_subject {
        let place = used.places.subject;
        notes.extend(input.header.note_of_subject(&input.name, place).filter(|_| columns.subject.is_none()));
        notes.extend(about_ids(&input.name, &[&rows.columns[place]]));
    }
    let factors = columns.factors.iter().zip(&used.places.factors);
    notes.extend(factors.filter_map(|(name, cell)| alike(&input.name, Some(name), &[&rows.columns[*cell]])));
    notes.extend(used.pooled(&input, &rows));
    let all = found.len();
    let found: Vec<AnswerRow> = found.into_iter().flatten().collect();
    let missing = all - found.len();
    if missing > 0 {
        let (have, were) = if missing == 1 { ("has", "was") } else { ("have", "were") };
        let message = format!("{missing} of {all} rows {have} no level or no answer, and {were} left out");
        notes.push(FileError::whole(&input.name, message));
    }
    let errors = rows.errors.finish(&input.name, &input.header.names);
    let answers = found.iter().map(|row| u64::from(row.total)).sum::<u64>();
    for (what, count, most) in [("rows", found.len() as u64, MAX_ROWS as u64), ("answers", answers, u32::MAX.into())] {
        if !(1..=most).contains(&count) {
            FileErrors::none(errors)?;
            return Err(FileErrors::whole(&input.name, format!("has {count} {what}; expected 1 to {most}")).into());
        }
    }
    Ok(AnswersRead { rows: found, notes, errors })
}

/// Maximum number of unused columns that may tell conditions apart, and of the levels of one.
const MAX_UNUSED: usize = 20;

/// Returns the columns that are read. After the factors, there are those that may tell conditions apart if no factors were
/// named, and the level.
fn places(input: &Input, columns: &AnswerColumns, subject: Option<&String>) -> Result<Places, FileErrors> {
    let (name, header) = (&input.name, &input.header);
    if has_session_rows(header) {
        let message = "has the rows of a session, among them practice, catch trials and corrected answers; expected the folder \
                       of the sessions, without the names of columns";
        return Err(FileErrors::whole(name, message));
    }
    let place = |column: &String| input.place(column).map_err(|error| FileErrors(vec![error]));
    let given = [&columns.level, &columns.correct];
    let all = given.into_iter().chain(&columns.total).chain(subject).chain(&columns.factors);
    let mut names: Vec<&String> = all.collect();
    names.sort();
    if let Some(twice) = names.windows(2).find(|pair| pair[0] == pair[1]) {
        let message = format!("the column {} has two uses; expected one for each column", twice[0]);
        return Err(FileErrors::whole(name, message));
    }
    let level = place(&columns.level)?;
    let mut factors = columns.factors.iter().map(place).collect::<Result<Vec<_>, _>>()?;
    if factors.is_empty() {
        let is_unused = |name: &String| names.binary_search(&name).is_err() && name != SIMULATED;
        factors.extend((0..header.names.len()).filter(|at| is_unused(&header.names[*at])).take(MAX_UNUSED));
    }
    factors.push(level);
    Ok(Places {
        subject: subject.map_or(Ok(level), place)?,
        responses: vec![place(&columns.correct)?],
        count: columns.total.as_ref().map(place).transpose()?,
        factors,
        simulated: header.position(SIMULATED),
        ..Places::default()
    })
}

/// How columns are used.
struct Used<'a> {
    /// Whether one has the participants.
    has_subject: bool,
    /// The number of factors.
    factors: usize,
    places: &'a Places,
}

impl Used<'_> {
    /// Returns a note if rows that may be of several people or conditions are taken together, because no columns were
    /// named.
    fn pooled(&self, input: &Input, rows: &Rows) -> Option<FileError> {
        let unused = self.places.factors.split_last()?.1.iter().filter(|_| self.factors == 0);
        let has_levels = |column: &&usize| (2..=MAX_UNUSED).contains(&rows.columns[**column].texts.len());
        let unused: Vec<&str> = unused.filter(has_levels).map(|column| input.header.names[*column].as_str()).collect();
        let people = if self.has_subject { "" } else { " and are those of one participant" };
        let message = format!(
            "all rows are of one condition{people}, because no column was named; expected --factors if conditions differ in {}",
            unused.join(", ")
        );
        (!unused.is_empty()).then(|| FileError::whole(&input.name, message))
    }

    /// Reads a row; `None` if it has no level or no answer. An error has its cell.
    fn row<'t>(
        &self,
        text: impl Fn(usize) -> &'t str,
        separator: u8,
    ) -> Result<Option<AnswerRow>, (usize, &'static str)> {
        let Places { subject, ref responses, count: trials, ref factors, simulated, .. } = *self.places;
        let (level, correct) = (factors[factors.len() - 1], responses[0]);
        if [Some(level), Some(correct), trials].into_iter().flatten().any(|cell| is_missing(text(cell), true)) {
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
        let (total, expected) = match trials {
            Some(cell) => (count(cell, "a number of trials")?, "a number of correct answers"),
            None => (1, "1 for a correct answer, or 0"),
        };
        let right = count(correct, expected)?;
        if right > total {
            let expected = if trials.is_some() { "no more correct answers than trials" } else { expected };
            return Err((correct, expected));
        }
        let value = number(level).filter(|level| level.is_finite());
        Ok(Some(AnswerRow {
            subject: if self.has_subject { named(subject, "a participant")? } else { "all".to_owned() },
            factors: factors[..self.factors].iter().map(|cell| named(*cell, "a level")).collect::<Result<_, _>>()?,
            level: value.ok_or((level, "a level, which is a number"))?,
            correct: right,
            total,
            is_simulated: simulated.is_some_and(|cell| is_mark(text(cell))),
        }))
    }
}
