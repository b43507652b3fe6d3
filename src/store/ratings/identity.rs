//! Which trial a row of a result file records.

use super::{faults::Kind, plan::RecordColumns, record::Cells};

/// Largest number of a trial. A session has at most 100,000.
const TRIALS_MAX: u32 = 1_000_000;

/// A row's place in the plan of a study.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Identity<'a> {
    pub subject: &'a str,
    pub session: &'a str,
    /// Main or practice.
    pub main: bool,
    /// From 1.
    pub trial: u32,
    /// From 1.
    pub attempt: u32,
}

/// What is wrong with a cell.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Bad {
    pub kind: Kind,
    /// Index of the cell.
    pub cell: usize,
    /// In the words of a sink.
    pub said: Option<String>,
}

impl Bad {
    pub fn new(kind: Kind, cell: usize) -> Self {
        Self { kind, cell, said: None }
    }
}

impl<'a> Identity<'a> {
    /// Reads it off the cells of a row.
    ///
    /// # Errors
    /// The first cell that is wrong.
    pub fn new(
        cells: &Cells<'a>,
        subject: usize,
        columns: &RecordColumns,
        experiment: Option<&str>,
    ) -> Result<Self, Bad> {
        if let Some((column, expected)) = columns.experiment.zip(experiment)
            && cells.get(column) != expected
        {
            return Err(Bad::new(Kind::Experiment, column));
        }
        let text = |kind, column| match cells.get(column) {
            "" => Err(Bad::new(kind, column)),
            text => Ok(text),
        };
        let number = |kind, column, most| match small_number(cells.get(column).as_bytes()) {
            Some(number) if (1..=most).contains(&number) => Ok(number),
            _ => Err(Bad::new(kind, column)),
        };
        Ok(Self {
            subject: text(Kind::Subject, subject)?,
            session: text(Kind::Session, columns.session)?,
            main: match cells.get(columns.phase) {
                "main" => true,
                "practice" => false,
                _ => return Err(Bad::new(Kind::Phase, columns.phase)),
            },
            trial: number(Kind::Trial, columns.trial, TRIALS_MAX)?,
            attempt: number(Kind::Attempt, columns.attempt, u32::MAX)?,
        })
    }

    /// Whether a name of a row is the one that sessions give: participant, session, phase, trial and attempt.
    pub fn is_named(&self, row_id: &str) -> bool {
        let numbers = |row_id: &str| {
            let rest = row_id.strip_prefix(self.subject)?.strip_prefix('_')?;
            let rest = rest.strip_prefix(self.session)?.strip_prefix('_')?;
            let rest = rest.strip_prefix(if self.main { "main_" } else { "practice_" })?;
            let (trial, attempt) = rest.split_once('_')?;
            Some((small_number(trial.as_bytes())?, small_number(attempt.as_bytes())?))
        };
        numbers(row_id) == Some((self.trial, self.attempt))
    }
}

/// A whole number of digits only.
pub(super) fn small_number(text: &[u8]) -> Option<u32> {
    if text.is_empty() || text.len() > 9 {
        return None;
    }
    text.iter().try_fold(0, |number, byte| byte.is_ascii_digit().then(|| number * 10 + u32::from(byte - b'0')))
}
