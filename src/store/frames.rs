//! Every frame interval of a session: a CSV file beside the data, one row for each stretch of frames that showed one
//! thing.
//!
//! The frames describe a session and are not its data: where this file cannot be written the session goes on.

use std::{
    fs::OpenOptions,
    io::{Seek as _, SeekFrom, Write as _},
    path::{Path, PathBuf},
};

use super::{FileFault, FileFaults, StoreError, fault::io, hash::sha256, text};
use crate::{
    display::frames::Refresh,
    experiment::{Phase, Schedule, Shown, Stretch},
};

/// The header row.
pub const HEADER: &str = "sitting,phase,trial,attempt,state,refresh_us,intervals_us";
/// Ends the name of such a file.
pub const SUFFIX: &str = "_frames.csv";

/// One row: frames that followed each other.
#[derive(Clone, Debug, PartialEq)]
pub struct FrameRow {
    /// 1, and 1 more each time an interrupted session was resumed.
    pub sitting: u32,
    /// As in the data.
    pub phase: Phase,
    /// As in the data: planned place within the phase, from 1.
    pub trial: u32,
    /// As in the data.
    pub attempt: u32,
    /// What the frames showed.
    pub shown: Shown,
    /// What they were judged against; `None` where it was not known.
    pub refresh: Option<Refresh>,
    /// For how long each of them stood, microseconds.
    pub intervals_us: Vec<u32>,
}

impl FrameRow {
    /// The row of a stretch. `None` where the schedule has no such trial.
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

/// The file of a running session. It is made when the first row comes: a session without a screen has none.
#[derive(Debug)]
pub struct FrameFile {
    path: PathBuf,
    /// Everything that belongs in the file.
    content: Vec<u8>,
    /// How much of it is known to be in the file.
    written: usize,
    /// The file is this session's own: made by it, or found when it went on.
    own: bool,
}

impl FrameFile {
    /// For a new session.
    pub fn new(path: &Path) -> Self {
        Self { path: path.to_owned(), content: Vec::new(), written: 0, own: false }
    }

    /// For a session that goes on: keeps what is there, less a last line that was half written.
    ///
    /// # Errors
    /// The file is there and cannot be read, or is none of this kind; the old one must not be written to then.
    pub fn resume(path: &Path) -> Result<Self, StoreError> {
        let content = match std::fs::read(path) {
            Ok(content) => content,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(Self::new(path)),
            Err(error) => return Err(io(path, "read")(error)),
        };
        let whole = content.iter().rposition(|byte| *byte == b'\n').map_or(0, |newline| newline + 1);
        if !content.starts_with(HEADER.as_bytes()) && !HEADER.as_bytes().starts_with(&content) {
            let message = format!("is no file of frames; expected the header {HEADER}");
            return Err(FileFaults::whole(path.display().to_string(), message).into());
        }
        Ok(Self { path: path.to_owned(), content: content[..whole].to_vec(), written: whole, own: true })
    }

    /// Where the file is, or would be.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// SHA-256 of everything that belongs in the file.
    pub fn sha256(&self) -> String {
        sha256(&self.content)
    }

    /// Whether there is anything in it.
    pub fn is_empty(&self) -> bool {
        self.content.is_empty()
    }

    /// Adds rows. They are kept in memory from here on, and in the file when this returns without an error; after an
    /// error the next call tries again. A power cut may take the last of them, since nobody waits for the disk.
    ///
    /// # Errors
    /// The system's refusal.
    pub fn append(&mut self, rows: &[FrameRow]) -> Result<(), StoreError> {
        if self.is_empty() && !rows.is_empty() {
            self.content.extend_from_slice(HEADER.as_bytes());
            self.content.push(b'\n');
        }
        for row in rows {
            self.content.extend_from_slice(row.line().as_bytes());
        }
        self.write()
    }

    fn write(&mut self) -> Result<(), StoreError> {
        if self.content.len() == self.written {
            return Ok(());
        }
        let refused = |error| io(&self.path, "write")(error);
        let mut options = OpenOptions::new();
        // Nobody else's file is written to.
        options.write(true).create(true).create_new(!self.own).truncate(false);
        let mut file = options.open(&self.path).map_err(refused)?;
        self.own = true;
        // Gone, and made anew just now: all of it.
        if file.metadata().map_err(refused)?.len() < self.written as u64 {
            self.written = 0;
        }
        file.set_len(self.written as u64).map_err(refused)?;
        file.seek(SeekFrom::Start(self.written as u64)).map_err(refused)?;
        file.write_all(&self.content[self.written..]).map_err(refused)?;
        self.written = self.content.len();
        Ok(())
    }

    /// Puts everything into a new file, and goes on there. The old one stays as it is.
    ///
    /// # Errors
    /// The new place refuses, or has such a file; the old one is then kept.
    pub fn move_to(&mut self, path: &Path) -> Result<(), StoreError> {
        let content = self.content.clone();
        let mut moved = Self { path: path.to_owned(), content, written: 0, own: false };
        moved.write()?;
        *self = moved;
        Ok(())
    }
}

/// Reads a file of frames.
///
/// # Errors
/// Every fault with its line and column.
pub fn read(path: &Path) -> Result<Vec<FrameRow>, FileFaults> {
    let file = path.display().to_string();
    parse(&file, &text::read(path)?)
}

/// Reads the text of a file of frames; `file` names it in messages.
///
/// # Errors
/// Every fault with its line and column.
pub fn parse(file: &str, text: &str) -> Result<Vec<FrameRow>, FileFaults> {
    let mut faults = Vec::new();
    let mut fault = |line: usize, column: usize, message: String| {
        faults.push(FileFault { file: file.to_owned(), position: Some((line, column)), message });
    };
    let mut rows = Vec::new();
    let mut lines = text.lines();
    if lines.next() != Some(HEADER) {
        fault(1, 1, format!("this is no header of a file of frames; expected {HEADER}"));
    } else {
        for (number, line) in (2..).zip(lines) {
            match row(line) {
                Ok(row) => rows.push(row),
                Err((column, message)) => fault(number, column, message),
            }
        }
    }
    if faults.is_empty() { Ok(rows) } else { Err(FileFaults(faults)) }
}

/// One row, or the column and what is wrong there.
fn row(line: &str) -> Result<FrameRow, (usize, String)> {
    let cells: Vec<&str> = line.split(',').collect();
    let &[sitting, phase, trial, attempt, state, refresh, intervals] = cells.as_slice() else {
        return Err((1, format!("the row has {} cells; expected 7", cells.len())));
    };
    let column = |index: usize| cells[..index].iter().map(|cell| cell.chars().count() + 1).sum::<usize>() + 1;
    let wrong = |index: usize, expected: &str| {
        let name = HEADER.split(',').nth(index).unwrap_or_default();
        (column(index), format!("{name} is {:?}; expected {expected}", cells[index]))
    };
    let count = |index: usize, cell: &str| match cell.parse::<u32>() {
        Ok(number) if number > 0 => Ok(number),
        _ => Err(wrong(index, "a whole number from 1")),
    };
    let refresh = match refresh {
        "" => None,
        text => Some(
            (text.parse::<f64>().ok())
                .and_then(|us| Refresh::new(us * 1e-6).ok())
                .ok_or_else(|| wrong(5, "microseconds from one refresh to the next, above 0, or nothing"))?,
        ),
    };
    Ok(FrameRow {
        sitting: count(0, sitting)?,
        phase: phase.parse().map_err(|_| wrong(1, "practice or main"))?,
        trial: count(2, trial)?,
        attempt: count(3, attempt)?,
        shown: (Shown::ALL.into_iter().find(|shown| shown.name() == state))
            .ok_or_else(|| wrong(4, "recovery, stimulus, response or closing"))?,
        refresh,
        intervals_us: (intervals.split(' ').map(|text| text.parse().ok()).collect::<Option<_>>()).ok_or_else(|| {
            (column(6), "intervals_us is not a list; expected whole microseconds with a space between".to_owned())
        })?,
    })
}
