//! What the cells of a table mean, row by row.

use std::collections::HashMap;

use super::{
    rows::{self, RowError, Rows, Status, What, column_of},
    selection::{Columns as Used, Input, Selection},
    source::{FileRead, Reason},
};
use crate::{
    experiment::RatingRow,
    store::{columns::Mapped, error::RowErrors},
};

/// What is known before rows are added.
pub(super) struct Known<'a> {
    /// For each factor, whether its column has only numbers, in all files together.
    factors: Vec<bool>,
    /// The same for each column with responses; also if hardly any value is something else and the categories are not named.
    responses: Vec<bool>,
    /// Texts that mean a missing response.
    missing: &'a [String],
    /// For each session, whether it is excluded because it is unfinished.
    unfinished: Vec<bool>,
}

impl<'a> Known<'a> {
    pub fn new(selection: &Selection, tables: &[Rows], missing: &'a [String], unfinished: Vec<bool>) -> Self {
        let are_numbers =
            |column: &dyn Fn(&Used) -> usize| rows::are_numbers(&column_of(&selection.inputs, tables, column));
        let first = &selection.inputs[0].columns;
        Self {
            factors: (0..first.factors.len()).map(|i| are_numbers(&|columns| columns.factors[i])).collect(),
            responses: (0..first.responses.len())
                .map(|i| {
                    let column = column_of(&selection.inputs, tables, |columns| columns.responses[i]);
                    let are_mostly = || selection.shape.categories.is_none() && rows::are_mostly_numbers(&column);
                    selection.own_scale.is_none() && (rows::are_numbers(&column) || are_mostly())
                })
                .collect(),
            missing,
            unfinished,
        }
    }
}

/// The index of a column, if there is one, and the value in each cell or what is expected there instead.
type Values<'a, T> = Option<(usize, Mapped<'a, Result<T, &'static str>>)>;

/// Returns the value in a row of a column; `None` if there is no such column.
fn value<T: Copy>(values: &Values<'_, T>, row: usize) -> Result<Option<T>, RowError> {
    let value =
        values.as_ref().map(|(column, cells)| (*cells.get(row)).map_err(|text| RowError::new(row, *column, text)));
    value.transpose()
}

/// The cells of a file. Each different text of a column is read once.
struct Cells<'a> {
    selection: &'a Selection,
    known: &'a Known<'a>,
    input: &'a Input,
    rows: &'a Rows,
    /// For each column with responses, the rating, if there is one, or whether it is missing.
    responses: Vec<Mapped<'a, Result<&'a str, bool>>>,
    factors: Vec<Mapped<'a, &'a str>>,
    counts: Values<'a, u64>,
    repetitions: Values<'a, Option<u32>>,
    orders: Values<'a, Option<f64>>,
    times: Values<'a, Option<f64>>,
    /// Whether the rating is marked as simulated.
    marks: Option<Mapped<'a, bool>>,
}

impl<'a> Cells<'a> {
    fn new(selection: &'a Selection, known: &'a Known<'_>, input: &'a Input, rows: &'a Rows) -> Self {
        let columns = &input.columns;
        let texts = |column: usize| &rows.columns[column];
        let is_own = columns.of_results();
        // A session records every answer; an option may still take some as missing.
        let may_lack = !is_own || !known.missing.is_empty();
        let responses = columns.responses.iter().zip(&known.responses).map(|(&column, &among_numbers)| {
            texts(column).map(|text| match rows::is_rating(text, selection.own_scale, among_numbers) {
                _ if may_lack && rows::is_no_response(text, known.missing, among_numbers) => Err(true),
                true if !among_numbers || rows::number(text).is_some() => Ok(text),
                _ => Err(false),
            })
        });
        let factors = columns.factors.iter().zip(&selection.levels).zip(&known.factors);
        let factors = factors.map(|((&column, defined), &among_numbers)| {
            let defined = if is_own { &defined[..] } else { &[] };
            texts(column).map(|text| rows::level(text, defined, among_numbers))
        });
        let repetition = |text: &str| rows::optional(text, text.parse().ok(), "the number of a repetition, 1 or more");
        let number = |text: &str| rows::number(text).filter(|number| number.is_finite());
        let order = |text: &str| rows::optional(text, number(text), "a number that increases from trial to trial");
        let seconds = |text: &str| number(text).filter(|seconds| *seconds >= 0.0);
        let seconds = |text: &str| rows::optional(text, seconds(text), "seconds, 0 or more");
        let has_session = |_: &usize| columns.session.is_some();
        Self {
            responses: responses.collect(),
            factors: factors.collect(),
            counts: columns.count.map(|column| (column, texts(column).map(rows::count))),
            repetitions: columns.repetition.filter(has_session).map(|column| (column, texts(column).map(repetition))),
            orders: columns.order.map(|column| (column, texts(column).map(order))),
            times: columns.time.map(|column| (column, texts(column).map(seconds))),
            marks: columns.simulated.map(|column| texts(column).map(rows::is_mark)),
            selection,
            known,
            input,
            rows,
        }
    }

    fn subject(&self, row: usize) -> &'a str {
        self.rows.columns[self.input.columns.subject].get(row)
    }

    /// Returns the session; empty if there is no column with it.
    fn session(&self, row: usize) -> &'a str {
        self.input.columns.session.map_or("", |session| self.rows.columns[session].get(row))
    }

    /// Returns the participant, the rating and its number, or why the rating is left out. It is in column `which` of the
    /// columns with responses.
    fn rating(&self, row: usize, which: usize) -> Result<Result<(&'a str, &'a str, u64), Reason>, RowError> {
        let (columns, own_scale) = (&self.input.columns, self.selection.own_scale);
        let (subject, is_own) = (self.subject(row), columns.of_results());
        if matches!(self.rows.status[row], Status::Counts(session) if is_own && self.known.unfinished[session as usize])
        {
            return Ok(Err(Reason::Unfinished));
        }
        if !is_own && rows::is_missing(subject, false) {
            return Ok(Err(Reason::NoParticipant));
        } else if subject.is_empty() {
            return Err(RowError::new(row, columns.subject, "a participant"));
        }
        let rating = match *self.responses[which].get(row) {
            Ok(rating) => rating,
            Err(true) => return Ok(Err(Reason::NoResponse)),
            Err(false) => {
                // Any scale is possible in a table from elsewhere.
                let unless =
                    if is_own { "" } else { ", unless this column is named as the response or this value as missing" };
                let rating = |highest| format!("a rating from 0 to {highest}{unless}");
                let number = || "a number, as in other rows, unless this value is named as missing".to_owned();
                let expected = own_scale.map_or_else(number, rating);
                return Err(RowError::new(row, columns.responses[which], expected));
            }
        };
        Ok(Ok((subject, rating, value(&self.counts, row)?.unwrap_or(1))))
    }
}

/// Calls `add` for every row of a file that counts. Collects the errors in the rows.
pub(super) fn add_rows(
    selection: &Selection,
    known: &Known<'_>,
    input: &Input,
    rows: &mut Rows,
    mut add: impl FnMut(&RatingRow<'_>) -> Result<(), String>,
) -> FileRead {
    let mut errors = std::mem::take(&mut rows.errors);
    let report = |errors: &mut RowErrors, error| rows.report(errors, error, input, &selection.inputs);
    let cells = Cells::new(selection, known, input, rows);
    let limits @ (least, most) = selection.shape.time_limits;
    let (mut levels, mut without_level) = (Vec::new(), vec![0; selection.shape.factors.len()]);
    let mut without_time = 0;
    // For each participant, the ratings that are marked as simulated, and all.
    let mut simulated = HashMap::<&str, [u64; 2]>::new();
    let mut add_rating = |row: usize, which: usize, errors: &mut RowErrors| -> Result<Result<u64, Reason>, RowError> {
        let (subject, rating, count) = match cells.rating(row, which)? {
            Ok(found) => found,
            Err(reason) => return Ok(Err(reason)),
        };
        // An unreadable position or time is an error, but the rating still counts, unless its time decides that.
        let repetition = known_or(value(&cells.repetitions, row), |error| report(errors, error));
        let position = known_or(value(&cells.orders, row), |error| report(errors, error));
        let response_time_s = match value(&cells.times, row) {
            Err(error) if limits != (None, None) => return Err(error),
            found => known_or(found, |error| report(errors, error)),
        };
        without_time += if response_time_s.is_none() { count } else { 0 };
        match response_time_s {
            Some(seconds) if least.is_some_and(|least| seconds < least) => return Ok(Err(Reason::TooFast)),
            Some(seconds) if most.is_some_and(|most| seconds > most) => return Ok(Err(Reason::TooSlow)),
            _ => {}
        }
        levels.clear();
        levels.extend(cells.factors.iter().map(|levels| *levels.get(row)));
        levels.extend(selection.wide.get(which).map(String::as_str));
        let cell = Some(input.columns.responses[which]);
        let (values, session) = (&levels[..], cells.session(row));
        add(&RatingRow { subject, values, rating, count, session, repetition, position, response_time_s })
            .map_err(|message| RowError { row, cell, what: What::Said(message) })?;
        if let Some(marks) = &cells.marks {
            let [marked, all] = simulated.entry(subject).or_default();
            *marked += if *marks.get(row) { count } else { 0 };
            *all += count;
        }
        levels.iter().zip(&mut without_level).filter(|(level, _)| level.is_empty()).for_each(|(_, n)| *n += count);
        Ok(Ok(count))
    };
    let mut read = FileRead { path: input.path.clone(), ..FileRead::default() };
    let each = input.columns.responses.len();
    read.rows = (rows.status.len() * each) as u64;
    for (row, which) in (0..rows.status.len()).flat_map(|row| (0..each).map(move |which| (row, which))) {
        let place = match rows.status[row] {
            Status::Counts(_) => match add_rating(row, which, &mut errors) {
                Ok(Ok(count)) => {
                    read.ratings += count;
                    &mut read.counted
                }
                Ok(Err(reason)) => {
                    if reason == Reason::NoParticipant && input.in_memory() {
                        read.nobodys.push(row);
                    }
                    let by_participant = read.left_out.entry(reason).or_default();
                    let id = if reason == Reason::NoParticipant { "" } else { cells.subject(row) };
                    by_participant.entry(id.to_owned()).or_default()
                }
                Err(error) => {
                    report(&mut errors, error);
                    &mut read.erroneous
                }
            },
            Status::Practice => &mut read.practice,
            Status::Superseded => &mut read.superseded,
            Status::Repeated(file) => {
                report(&mut errors, RowError { row, cell: None, what: What::Repeated(file as usize) });
                read.repeated += 1;
                &mut read.erroneous
            }
            Status::Wrong => &mut read.erroneous,
        };
        *place += 1;
    }
    let marked = simulated.into_iter().filter(|(_, [marked, _])| *marked > 0);
    read.simulated = marked.map(|(subject, counts)| (subject.to_owned(), counts)).collect();
    rows.errors = errors;
    FileRead { without_level, without_time, ..read }
}

/// Returns what a cell says; without it if it cannot be read, which is reported.
fn known_or<T>(found: Result<Option<Option<T>>, RowError>, report: impl FnOnce(RowError)) -> Option<T> {
    found.map_err(report).ok().flatten().flatten()
}
