//! One row of a file: its cells, which trial it records, and what is wrong with it.

use std::borrow::Cow;

use super::{
    selection::{Columns, Input, RecordColumns},
    trials::{Identity, Trial, number},
};
use crate::{
    experiment::RATING_MAX,
    store::{
        FileFault,
        table::{Row, shortened},
    },
};

/// Largest count of a row; the sum of many such still is a number of 64 bits.
const COUNT_MAX: f64 = 1e12;

/// The cells of a row, all of them text.
pub(super) struct Cells<'a> {
    text: &'a str,
    row: &'a Row<'a>,
}

impl<'a> Cells<'a> {
    /// The cells of a row.
    ///
    /// # Errors
    /// Not UTF-8, or another number of cells than the header has.
    pub fn new(row: &'a Row<'a>, width: usize) -> Result<Self, RowFault> {
        let fault = |cell, message: String| RowFault { cell, message };
        let text = row.text().map_err(|_| fault(None, "the row is not UTF-8 text; expected UTF-8".to_owned()))?;
        if row.is_open() {
            let message = "a quote is never closed; expected a closing quote".to_owned();
            return Err(fault(Some(row.record.len() - 1), message));
        }
        match row.record.len() {
            found if found == width => Ok(Self { text, row }),
            1 => Err(fault(None, format!("the row has 1 cell; expected {width}, as the header has"))),
            found => Err(fault(None, format!("the row has {found} cells; expected {width}, as the header has"))),
        }
    }

    /// A cell, without white space around it.
    pub fn get(&self, index: usize) -> &'a str {
        self.row.record.range(index).and_then(|range| self.text.get(range)).unwrap_or_default().trim()
    }

    /// A level or a time as it is written; `NA`, as R writes a missing value, is one.
    pub fn optional(&self, index: usize) -> &'a str {
        match self.get(index) {
            "NA" => "",
            text => text,
        }
    }
}

/// What is wrong with a cell: its index, and what is expected there.
pub(super) type CellFault = (usize, Cow<'static, str>);

/// Words the fault of a cell.
pub(super) fn fault(input: &Input, cells: &Cells<'_>, (cell, expected): CellFault) -> RowFault {
    let name = input.header.names.get(cell).map_or("", String::as_str);
    let message = match cells.get(cell) {
        "" => format!("{name} is empty; expected {expected}"),
        text => format!("{name} is {:?}; expected {expected}", shortened(text)),
    };
    RowFault { cell: Some(cell), message }
}

/// Which trial a row of a result file records.
///
/// # Errors
/// The first cell that is wrong.
pub(super) fn identity<'a>(
    cells: &Cells<'a>,
    subject: usize,
    columns: &RecordColumns,
    experiment: Option<&str>,
) -> Result<Identity<'a>, CellFault> {
    if let Some((column, expected)) = columns.experiment.zip(experiment)
        && cells.get(column) != expected
    {
        return Err((column, format!("{expected}, as in the first row").into()));
    }
    let phase = cells.get(columns.phase).parse().map_err(|_| (columns.phase, "practice or main".into()))?;
    let trial =
        number(cells.get(columns.trial)).ok_or((columns.trial, "the number of a trial, from 1 to 1000000".into()))?;
    let attempt = number(cells.get(columns.attempt))
        .ok_or((columns.attempt, "the number of an attempt, from 1 to 1000000".into()))?;
    Ok(Identity {
        subject: present(cells, subject, "a participant")?,
        session: present(cells, columns.session, "a session")?,
        trial: Trial::new(phase, trial, attempt),
    })
}

/// A cell that must not be empty.
///
/// # Errors
/// It is.
pub(super) fn present<'a>(cells: &Cells<'a>, column: usize, expected: &'static str) -> Result<&'a str, CellFault> {
    Some(cells.get(column)).filter(|text| !text.is_empty()).ok_or((column, expected.into()))
}

/// Whether a text is a rating: of our own scale, or else anything but a missing value.
pub(super) fn is_rating(text: &str, own_scale: bool) -> bool {
    if !own_scale {
        return !matches!(text, "" | "NA" | "NaN" | "nan");
    }
    match text.as_bytes() {
        &[digit @ b'0'..=b'9'] => digit - b'0' <= RATING_MAX,
        // A spreadsheet or pandas may have written 2 as 2.0.
        _ => text.parse().is_ok_and(|number: f64| (0..=RATING_MAX).any(|rating| number == f64::from(rating))),
    }
}

/// The rating as it is written.
///
/// # Errors
/// There is none, or not one of the scale.
pub(super) fn rating<'a>(cells: &Cells<'a>, columns: &Columns, own_scale: bool) -> Result<&'a str, CellFault> {
    match cells.get(columns.response) {
        text if is_rating(text, own_scale) => Ok(text),
        _ => {
            let expected = if own_scale { format!("a rating from 0 to {RATING_MAX}") } else { "a rating".to_owned() };
            Err((columns.response, expected.into()))
        }
    }
}

/// How many trials a row stands for; pandas may have written 3 as `3.0`.
///
/// # Errors
/// No count.
pub(super) fn count(cells: &Cells<'_>, columns: &Columns) -> Result<u64, CellFault> {
    let Some(column) = columns.count else { return Ok(1) };
    let expected = match cells.get(column).parse::<f64>() {
        Ok(count) if (0.0..=COUNT_MAX).contains(&count) && count.fract() == 0.0 => return Ok(count as u64),
        Ok(number) if number < 0.0 => "a count, 0 or more",
        Ok(number) if number > COUNT_MAX => "a count of at most 10^12",
        Ok(_) => "a count without fraction",
        Err(_) => "a count, a whole number",
    };
    Err((column, expected.into()))
}

/// Session and repetition; none where the file has none.
///
/// # Errors
/// A repetition that is no number.
pub(super) fn place<'a>(cells: &Cells<'a>, columns: &Columns) -> Result<Option<(&'a str, u32)>, CellFault> {
    let Some((session, column)) = columns.session.zip(columns.repetition) else { return Ok(None) };
    match cells.get(column) {
        "" => Ok(None),
        text => match text.parse() {
            Ok(repetition) => Ok(Some((cells.get(session), repetition))),
            Err(_) => Err((column, "the number of a repetition, 1 or more".into())),
        },
    }
}

/// The response time in seconds; none where the file has none.
///
/// # Errors
/// One that is no time.
pub(super) fn response_time(cells: &Cells<'_>, columns: &Columns) -> Result<Option<f64>, CellFault> {
    let Some(column) = columns.time else { return Ok(None) };
    match cells.optional(column) {
        "" => Ok(None),
        text => match text.parse() {
            Ok(seconds) if f64::is_finite(seconds) && seconds >= 0.0 => Ok(Some(seconds)),
            _ => Err((column, "seconds, 0 or more".into())),
        },
    }
}

/// How many faults in one column are kept of one file.
const KEPT: usize = 10;

/// What is wrong with a row.
#[derive(Clone, Debug)]
pub(super) struct RowFault {
    /// Index of the cell; none where it is the row as a whole.
    pub cell: Option<usize>,
    /// What is wrong; what is expected.
    pub message: String,
}

/// The faulty rows of a file.
#[derive(Clone, Debug, Default)]
pub(super) struct RowFaults {
    kept: Vec<FileFault>,
    /// How many there are in each column, kept or not.
    cells: Vec<(Option<usize>, usize)>,
}

impl RowFaults {
    /// Adds a fault; its place is asked for only if it is kept.
    pub fn add(&mut self, file: &str, fault: RowFault, place: impl FnOnce() -> (usize, usize)) {
        let index = self.cells.iter().position(|(cell, _)| *cell == fault.cell).unwrap_or_else(|| {
            self.cells.push((fault.cell, 0));
            self.cells.len() - 1
        });
        self.cells[index].1 += 1;
        if self.cells[index].1 <= KEPT {
            self.kept.push(FileFault::at(file, place(), fault.message));
        }
    }

    /// Every fault that was kept, and how many more there are.
    pub fn finish(self, file: &str, columns: &[String]) -> Vec<FileFault> {
        let mut faults = self.kept;
        faults.sort_by_key(|fault| fault.position);
        for (cell, n) in self.cells.into_iter().filter(|(_, n)| *n > KEPT) {
            let of = cell.and_then(|cell| columns.get(cell)).map_or(String::new(), |name| format!(" in {name}"));
            faults.push(FileFault::whole(file, format!("{} more rows have a fault{of}; expected none", n - KEPT)));
        }
        faults
    }
}
