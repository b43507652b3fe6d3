//! Every frame interval of a session: a CSV file next to the data, with one row for each run of frames with the same
//! content.
//!
//! The frames describe a session and are not its data: if this file cannot be written, the session continues.

use std::path::Path;

use crate::{
    display::frames::Refresh,
    experiment::{Phase, Schedule, Shown, Stretch},
    store::{
        FileFaults, StoreError,
        file::{AppendFile, is_there, read_text},
        table::{self, CellFault, shortened},
    },
};

/// The header row.
pub const HEADER: &str = "sitting,phase,trial,attempt,state,refresh_us,intervals_us";
/// Suffix of such a file.
pub const SUFFIX: &str = "_frames.csv";

/// One row: consecutive frames.
#[derive(Clone, Debug, PartialEq)]
pub struct FrameRow {
    /// 1, plus 1 each time an interrupted session was resumed.
    pub sitting: u32,
    /// As in the data.
    pub phase: Phase,
    /// As in the data: planned place within the phase, from 1.
    pub trial: u32,
    /// As in the data.
    pub attempt: u32,
    /// Content of the frames.
    pub shown: Shown,
    /// The refresh interval with which they were compared; `None` if it was not known.
    pub refresh: Option<Refresh>,
    /// How long each frame was shown, in microseconds.
    pub intervals_us: Vec<u32>,
}

impl FrameRow {
    /// The row of a stretch. `None` if the schedule has no such trial.
    #[must_use]
    pub fn new(stretch: Stretch, schedule: &Schedule, sitting: u32) -> Option<Self> {
        let trial = schedule.trials.get(stretch.trial)?;
        let Stretch { attempt, shown, refresh, intervals_us, .. } = stretch;
        Some(Self { sitting, phase: trial.phase, trial: trial.number, attempt, shown, refresh, intervals_us })
    }

    fn line(&self) -> String {
        let refresh = self.refresh.map_or_else(String::new, |refresh| format!("{:.3}", refresh.seconds() * 1e6));
        let intervals: Vec<String> = self.intervals_us.iter().map(u32::to_string).collect();
        let (phase, state) = (self.phase, self.shown.name());
        format!("{},{phase},{},{},{state},{refresh},{}\n", self.sitting, self.trial, self.attempt, intervals.join(" "))
    }
}

/// The file of a running session. It is created with the first row, so a session without a screen has none.
#[derive(Debug)]
pub struct FrameFile(pub(in crate::store) AppendFile);

impl FrameFile {
    /// For a new session.
    pub fn new(path: &Path) -> Self {
        Self(AppendFile::new(path, false, header()))
    }

    /// For a resumed session: keeps the content, except for an incomplete last line.
    ///
    /// # Errors
    /// The file exists but cannot be read, or is of another kind; it must not be written to then.
    pub fn resume(path: &Path) -> Result<Self, StoreError> {
        if !is_there(path)? {
            return Ok(Self::new(path));
        }
        let file = AppendFile::open(path, false, header())?;
        if !file.content().starts_with(&header()) {
            let message = format!("is not a frames file; expected the header {HEADER}");
            return Err(FileFaults::whole(path, message).into());
        }
        Ok(Self(file))
    }

    /// Whether it has no rows.
    pub fn is_empty(&self) -> bool {
        self.0.content() == header()
    }

    /// Adds rows. They are kept in memory from here on, and in the file when this returns without an error; after an
    /// error the next call tries again, in a new file where the old one is gone. A power cut may take the last of them,
    /// since nobody waits for the disk.
    ///
    /// # Errors
    /// The system's refusal.
    pub fn append(&mut self, rows: &[FrameRow]) -> Result<(), StoreError> {
        if self.is_empty() && rows.is_empty() {
            return Ok(());
        }
        let text: String = rows.iter().map(FrameRow::line).collect();
        self.0.append(text.as_bytes()).or_else(|error| {
            let path = self.0.path().to_owned();
            if matches!(error, StoreError::Changed { .. }) && !is_there(&path)? {
                self.move_to(&path)
            } else {
                Err(error)
            }
        })
    }

    /// Writes everything into a new file and continues there. The old one is not changed.
    ///
    /// # Errors
    /// The new location cannot be written or already has such a file; the old one is then kept.
    pub fn move_to(&mut self, path: &Path) -> Result<(), StoreError> {
        if self.is_empty() {
            *self = Self::new(path);
            return Ok(());
        }
        self.0.move_to(path)
    }
}

fn header() -> Vec<u8> {
    format!("{HEADER}\n").into_bytes()
}

/// Reads a file of frames.
///
/// # Errors
/// Every fault with its line and column.
pub fn read(path: &Path) -> Result<Vec<FrameRow>, FileFaults> {
    parse(&path.display().to_string(), &read_text(path)?)
}

/// Reads the text of a file of frames; `file` names it in messages.
///
/// # Errors
/// Every fault with its line and column.
pub fn parse(file: &str, text: &str) -> Result<Vec<FrameRow>, FileFaults> {
    table::parse(file, text.as_bytes(), |header| table::exactly(header, HEADER), row)
}

fn row(cells: &[&str]) -> Result<FrameRow, CellFault> {
    let &[sitting, phase, trial, attempt, state, refresh, intervals] = cells else {
        return Err((0, format!("the row has {} cells; expected 7", cells.len())));
    };
    let wrong = |index: usize, expected: &str| {
        let name = HEADER.split(',').nth(index).unwrap_or_default();
        (index, format!("{name} is {:?}; expected {expected}", shortened(cells[index])))
    };
    let count = |index: usize, cell: &str| match cell.parse::<u32>() {
        Ok(number) if number > 0 => Ok(number),
        _ => Err(wrong(index, "a whole number from 1")),
    };
    let refresh = match refresh {
        "" => None,
        text => Some(
            (text.parse::<f64>().ok())
                .and_then(|us| Refresh::new(us * 1e-6))
                .ok_or_else(|| wrong(5, "microseconds from one refresh to the next, above 0, or an empty cell"))?,
        ),
    };
    let intervals = intervals.split(' ').map(|text| text.parse().ok()).collect::<Option<_>>();
    Ok(FrameRow {
        sitting: count(0, sitting)?,
        phase: phase.parse().map_err(|_| wrong(1, "practice or main"))?,
        trial: count(2, trial)?,
        attempt: count(3, attempt)?,
        shown: state.parse().map_err(|_| wrong(4, &format!("one of {}", Shown::NAMES.join(", "))))?,
        refresh,
        intervals_us: intervals.ok_or_else(|| wrong(6, "whole microseconds separated by spaces"))?,
    })
}
