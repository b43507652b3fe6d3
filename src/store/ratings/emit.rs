//! From the rows of a file to those that count.

use std::collections::HashSet;

use super::{
    FileRead, Row, Sink,
    faults::{Kind, Place, RowFault, RowFaults},
    identity::{Bad, Identity},
    ledger::{Fate, Ledger},
    plan::{Input, RecordColumns},
    record::{self, Cells, Record},
};
use crate::experiment::RATING_MAX;

/// Largest count of a row; the sum of many such still is a number of 64 bits.
const COUNT_MAX: f64 = 1e12;

/// What the rows of all files are held against.
#[derive(Debug)]
pub(super) struct Rules<'a> {
    /// The experiment that they must be of.
    pub experiment: Option<&'a str>,
    /// Which rows of result files count.
    pub ledger: &'a Ledger,
    /// Indices of sessions that are left out.
    pub unfinished: &'a HashSet<usize>,
    /// Whether ratings are 0…3.
    pub scale: bool,
}

/// What became of the rows of a file, or of a part of it.
#[derive(Debug, Default)]
pub(super) struct Tally {
    pub rows: u64,
    pub counted: u64,
    pub ratings: u64,
    pub practice: u64,
    pub superseded: u64,
    pub faulty: u64,
    pub unfinished: u64,
    /// Rows that stand in another file already, and one such place.
    pub elsewhere: u64,
    pub copied: Option<Place>,
    pub faults: RowFaults,
}

impl Tally {
    /// Adds that of the part that follows after so many lines.
    pub fn append(&mut self, later: Self, lines: u64) {
        self.rows += later.rows;
        self.counted += later.counted;
        self.ratings += later.ratings;
        self.practice += later.practice;
        self.superseded += later.superseded;
        self.faulty += later.faulty;
        self.unfinished += later.unfinished;
        self.elsewhere += later.elsewhere;
        self.copied = self.copied.or(later.copied);
        self.faults.append(later.faults, lines);
    }

    /// The report of a file.
    pub fn report(&self, input: &Input, sha256: Option<String>) -> FileRead {
        FileRead {
            path: input.path.clone(),
            layout: input.layout,
            rows: self.rows,
            counted: self.counted,
            ratings: self.ratings,
            practice: self.practice,
            superseded: self.superseded,
            faulty: self.faulty,
            unfinished: self.unfinished,
            sha256,
        }
    }
}

/// Gives the rows of one file to a sink.
pub(super) struct Emitter<'a, S> {
    pub input: &'a Input,
    /// Index of the file.
    pub file: usize,
    pub rules: &'a Rules<'a>,
    pub sink: &'a mut S,
    pub tally: Tally,
}

/// Why a row does not count.
enum Out {
    Bad(Bad),
    Repeated(Place),
    Practice,
    Superseded,
    Unfinished,
}

impl From<Bad> for Out {
    fn from(bad: Bad) -> Self {
        Self::Bad(bad)
    }
}

impl<S: Sink> Emitter<'_, S> {
    /// Takes the next row.
    pub fn take(&mut self, record: &Record<'_>) {
        self.tally.rows += 1;
        match self.try_take(record) {
            Ok(count) => {
                self.tally.counted += 1;
                self.tally.ratings += count;
            }
            Err(Out::Practice) => self.tally.practice += 1,
            Err(Out::Superseded) => self.tally.superseded += 1,
            Err(Out::Unfinished) => self.tally.unfinished += 1,
            Err(Out::Bad(bad)) => {
                self.tally.faulty += 1;
                self.fault(record, bad);
            }
            Err(Out::Repeated(first)) => {
                self.tally.faulty += 1;
                if first.file as usize != self.file {
                    self.tally.elsewhere += 1;
                    self.tally.copied = self.tally.copied.or(Some(first));
                }
                self.repeated(record, first);
            }
        }
    }

    fn try_take(&mut self, record: &Record<'_>) -> Result<u64, Out> {
        let columns = &self.input.columns;
        let cells = record.cells.ok_or(Bad::new(Kind::Text, 0))?;
        if cells.len() != self.input.header.names.len() {
            return Err(Bad::new(Kind::Cells, 0).into());
        }
        let subject = match &columns.record {
            Some(own) => self.own(record, &cells, own)?,
            None => cells.get(columns.subject),
        };
        if subject.is_empty() {
            return Err(Bad::new(Kind::Subject, columns.subject).into());
        }
        let rating = cells.get(columns.response);
        if !is_rating(rating, self.rules.scale) {
            return Err(Bad::new(Kind::Rating, columns.response).into());
        }
        let count = match columns.count {
            Some(column) => count(cells.get(column)).ok_or(Bad::new(Kind::Count, column))?,
            None => 1,
        };
        let place = self.place(record, &cells);
        let response_time_s = self.time(record, &cells);
        let columns = &self.input.columns;
        let mut few = [""; 12];
        let mut many = Vec::new();
        let values = if let Some(few) = few.get_mut(..columns.factors.len()) {
            few
        } else {
            many.resize(columns.factors.len(), "");
            &mut many[..]
        };
        for (value, &column) in values.iter_mut().zip(&columns.factors) {
            *value = level(cells.get(column));
        }
        let row = Row { subject, values, rating, count, place, response_time_s };
        let refused = |said| Bad { kind: Kind::Rating, cell: columns.response, said: Some(said) };
        self.sink.row(&row).map_err(refused)?;
        Ok(count)
    }

    /// The subject of a result file's row, if the row counts.
    fn own<'r>(&self, record: &Record<'_>, cells: &Cells<'r>, own: &RecordColumns) -> Result<&'r str, Out> {
        let Rules { experiment, ledger, unfinished, .. } = self.rules;
        let row = Identity::new(cells, self.input.columns.subject, own, *experiment)?;
        let row_id = own.row_id.map_or("", |column| cells.get(column));
        let fate = ledger.fate(&row, row_id, Place { file: self.file as u32, offset: record.offset });
        if let Fate::Repeated(first) = fate {
            return Err(Out::Repeated(first));
        }
        if !row.main {
            return Err(Out::Practice);
        }
        if fate == Fate::Superseded {
            return Err(Out::Superseded);
        }
        let left_out = !unfinished.is_empty()
            && ledger.find(row.subject, row.session).is_some_and(|session| unfinished.contains(&session));
        if left_out { Err(Out::Unfinished) } else { Ok(row.subject) }
    }

    /// Session and repetition. One that cannot be read is a fault, but the rating counts.
    fn place<'r>(&mut self, record: &Record<'_>, cells: &Cells<'r>) -> Option<(&'r str, u32)> {
        let (session, column) = self.input.columns.session.zip(self.input.columns.repetition)?;
        match cells.get(column) {
            "" => None,
            text => {
                let number = text.parse().ok();
                if number.is_none() {
                    self.fault(record, Bad::new(Kind::Repetition, column));
                }
                Some((cells.get(session), number?))
            }
        }
    }

    /// The response time. One that cannot be read is a fault, but the rating counts.
    fn time(&mut self, record: &Record<'_>, cells: &Cells<'_>) -> Option<f64> {
        let column = self.input.columns.time?;
        let text = level(cells.get(column));
        if text.is_empty() {
            return None;
        }
        let seconds = text.parse().ok().filter(|seconds: &f64| seconds.is_finite() && *seconds >= 0.0);
        if seconds.is_none() {
            self.fault(record, Bad::new(Kind::Time, column));
        }
        seconds
    }

    fn fault(&mut self, record: &Record<'_>, bad: Bad) {
        let torn = is_torn(record, &bad);
        let kind = if torn { Kind::Torn } else { bad.kind };
        let Self { input, rules, tally, .. } = self;
        tally.faults.add(kind, || {
            let column = if torn || kind == Kind::Text {
                first_bad_column(record)
            } else {
                record::column(record.raw, input.header.separator, bad.cell)
            };
            let message = if torn { torn_message(record) } else { message(input, rules, record, &bad) };
            RowFault { kind, line: record.line, column, message, first: None }
        });
    }

    fn repeated(&mut self, record: &Record<'_>, first: Place) {
        let input = self.input;
        self.tally.faults.add(Kind::Repeated, || {
            let name = match (record.cells, input.columns.record) {
                (Some(cells), Some(RecordColumns { row_id: Some(column), .. })) => {
                    format!("row_id {:?}", cells.get(column))
                }
                _ => "the trial and attempt of this row".to_owned(),
            };
            let message = format!("{name} stands in {{}} already; expected every row once (this one is left out)");
            RowFault { kind: Kind::Repeated, line: record.line, column: 1, message, first: Some(first) }
        });
    }
}

/// Whether a row is what an interrupted writing left: nothing ends it, and its last cell, or a number of cells, is
/// wrong; or it has zero bytes where the file was enlarged and not filled.
fn is_torn(record: &Record<'_>, bad: &Bad) -> bool {
    let ends_badly = || match (bad.kind, &record.cells) {
        (Kind::Cells | Kind::Text, _) | (_, None) => true,
        (_, Some(cells)) => bad.cell + 1 == cells.len(),
    };
    record.last && (record.raw.contains(&0) || (!record.terminated && ends_badly()))
}

fn torn_message(record: &Record<'_>) -> String {
    let what = if record.raw.contains(&0) { "has zero bytes" } else { "is cut in the middle" };
    format!("the last row {what}, as after an interrupted writing; expected a whole row (it is left out)")
}

/// Column of the first byte that is not text; 1 where all are.
fn first_bad_column(record: &Record<'_>) -> usize {
    match std::str::from_utf8(record.raw) {
        Err(error) => String::from_utf8_lossy(&record.raw[..error.valid_up_to()]).chars().count() + 1,
        Ok(_) => 1,
    }
}

/// What is wrong with a row; what is expected.
fn message(input: &Input, rules: &Rules<'_>, record: &Record<'_>, bad: &Bad) -> String {
    let name = input.header.names.get(bad.cell).map_or("", String::as_str);
    let cell = record.cells.filter(|cells| bad.cell < cells.len()).map_or("", |cells| cells.get(bad.cell));
    let is = |expected: &str| {
        if cell.is_empty() {
            format!("{name} is empty; expected {expected}")
        } else {
            format!("{name} is {:?}; expected {expected}", clipped(cell))
        }
    };
    if let Some(said) = &bad.said {
        return said.clone();
    }
    match bad.kind {
        Kind::Cells => {
            let found = record.cells.map_or(0, |cells| cells.len());
            let cells = if found == 1 { "cell" } else { "cells" };
            format!("the row has {found} {cells}; expected {}, as the header has", input.header.names.len())
        }
        Kind::Text | Kind::Torn | Kind::Repeated => "the row is not UTF-8 text; expected UTF-8".to_owned(),
        Kind::Experiment => is(&format!("{}, as in the first row", rules.experiment.unwrap_or_default())),
        Kind::Subject => is("a participant"),
        Kind::Session => is("a session"),
        Kind::Phase => is("practice or main"),
        Kind::Trial => is("the number of a trial, from 1 to 1000000"),
        Kind::Attempt => is("the number of an attempt, 1 or more"),
        Kind::Rating if rules.scale => is(&format!("a rating from 0 to {RATING_MAX}")),
        Kind::Rating => is("a rating"),
        Kind::Count => is(count_expected(cell)),
        Kind::Repetition => is("the number of a repetition, 1 or more"),
        Kind::Time => is("seconds, 0 or more"),
    }
}

/// The beginning of what may be anything.
fn clipped(text: &str) -> String {
    const SHOWN: usize = 40;
    let shown: String = text.chars().take(SHOWN).collect();
    if shown.len() < text.len() { shown + "…" } else { shown }
}

/// A level as it is written; `NA`, as R writes a missing value, is one.
fn level(text: &str) -> &str {
    if text == "NA" { "" } else { text }
}

/// Whether a text is a rating: of our own scale, or else anything but a missing value.
pub(super) fn is_rating(text: &str, scale: bool) -> bool {
    match text.as_bytes() {
        [b'0'..=b'9'] if !scale => true,
        &[digit @ b'0'..=b'9'] => digit - b'0' <= RATING_MAX,
        // A spreadsheet or pandas may have written 2 as 2.0.
        _ if scale => text.parse().is_ok_and(|number: f64| (0..=RATING_MAX).any(|rating| number == f64::from(rating))),
        _ => !matches!(text, "" | "NA" | "NaN" | "nan"),
    }
}

/// A whole number of trials; pandas may have written it as `3.0`.
fn count(text: &str) -> Option<u64> {
    if let Some(count) = super::identity::small_number(text.as_bytes()) {
        return Some(count.into());
    }
    let count: f64 = text.parse().ok()?;
    ((0.0..=COUNT_MAX).contains(&count) && count.fract() == 0.0).then_some(count as u64)
}

/// What is expected instead of a text that is no count.
fn count_expected(text: &str) -> &'static str {
    match text.parse::<f64>() {
        Ok(number) if number < 0.0 => "a count, 0 or more",
        Ok(number) if number > COUNT_MAX => "a count of at most 10^12",
        Ok(_) => "a count without fraction",
        Err(_) => "a count, a whole number",
    }
}
