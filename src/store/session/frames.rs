//! The frames file of a session: a CSV file next to the data that contains every frame interval, with one row for each
//! run of consecutive frames with the same content.
//!
//! Frames describe a session but are not its data, so the session continues if this file cannot be written.

use std::path::Path;

use crate::{
    display::frames::Refresh,
    experiment::{FrameRun, Phase, Schedule, Shown},
    store::{
        FileErrors, StoreError,
        file::{AppendFile, exists},
    },
};

/// The header row.
pub const HEADER: &str = "sitting,phase,trial,attempt,state,refresh_us,intervals_us";
/// Suffix of a frames file.
pub const SUFFIX: &str = "_frames.csv";

/// Maximum size of a frames file that a session continues, in bytes. Frames of 8 hours at 480 Hz have half of it.
const MAX_FILE: u64 = 2 << 30;

/// One row: consecutive frames with the same content.
#[derive(Clone, Debug, PartialEq)]
pub struct FrameRow {
    /// Number of the sitting: 1, plus 1 for each time the session was resumed.
    pub sitting: u32,
    /// Phase, as in the data.
    pub phase: Phase,
    /// Trial, as in the data: its planned position within the phase, from 1.
    pub trial: u32,
    /// Attempt, as in the data.
    pub attempt: u32,
    /// Content of the frames.
    pub shown: Shown,
    /// The refresh interval that the frames were compared with; `None` if it was not known.
    pub refresh: Option<Refresh>,
    /// How long each frame was shown, in microseconds.
    pub intervals_us: Vec<u32>,
}

impl FrameRow {
    /// Creates the row for a run of frames; `None` if the schedule has no such trial.
    pub fn new(run: FrameRun, schedule: &Schedule, sitting: u32) -> Option<Self> {
        let trial = schedule.trials.get(run.trial)?;
        let FrameRun { attempt, shown, refresh, intervals_us, .. } = run;
        Some(Self { sitting, phase: trial.phase, trial: trial.number, attempt, shown, refresh, intervals_us })
    }

    fn line(&self) -> String {
        let refresh = self.refresh.map_or_else(String::new, |refresh| format!("{:.3}", refresh.seconds() * 1e6));
        let intervals: Vec<String> = self.intervals_us.iter().map(u32::to_string).collect();
        let (phase, state) = (self.phase, self.shown.name());
        format!("{},{phase},{},{},{state},{refresh},{}\n", self.sitting, self.trial, self.attempt, intervals.join(" "))
    }
}

/// The frames file of a running session. It is created with the first row, so a session without a screen has none.
#[derive(Debug)]
pub struct FrameFile(pub(in crate::store) AppendFile);

impl FrameFile {
    /// Prepares the file of a new session.
    pub fn new(path: &Path) -> Self {
        Self(AppendFile::new(path, false, header()))
    }

    /// Opens the file of a resumed session, and keeps its content except for an incomplete last line.
    ///
    /// # Errors
    /// The file exists but cannot be read or is not a frames file, so it must not be written to.
    pub fn resume(path: &Path) -> Result<Self, StoreError> {
        if !exists(path)? {
            return Ok(Self::new(path));
        }
        let file = AppendFile::open(path, false, header(), MAX_FILE)?;
        if !file.content().starts_with(&header()) {
            let message = format!("is not a frames file; expected the header {HEADER}");
            return Err(FileErrors::whole(path, message).into());
        }
        Ok(Self(file))
    }

    /// True if the file has no rows.
    pub fn is_empty(&self) -> bool {
        self.0.content() == header()
    }

    /// Appends rows. They are kept in memory from now on, and they are in the file when this returns without an error.
    /// After an error, the next call tries again. A power failure may lose the last rows, because the session does not wait for
    /// the disk.
    ///
    /// # Errors
    /// I/O errors.
    pub fn append(&mut self, rows: &[FrameRow]) -> Result<(), StoreError> {
        if self.is_empty() && rows.is_empty() {
            return Ok(());
        }
        let text: String = rows.iter().map(FrameRow::line).collect();
        self.0.append(text.as_bytes())
    }

    /// Writes everything that is not in the file yet, and waits until it is on disk, so that the file can be sealed.
    ///
    /// # Errors
    /// I/O errors.
    pub fn sync(&mut self) -> Result<(), StoreError> {
        if self.is_empty() {
            return Ok(());
        }
        self.append(&[])?;
        self.0.sync()
    }

    /// Writes everything into a new file and continues there. The old file is not changed.
    ///
    /// # Errors
    /// The new location cannot be written or already has such a file. In that case, the old one stays in use.
    pub fn continue_in(&mut self, path: &Path) -> Result<(), StoreError> {
        if self.is_empty() {
            *self = Self::new(path);
            return Ok(());
        }
        self.0.continue_in(path)
    }
}

fn header() -> Vec<u8> {
    format!("{HEADER}\n").into_bytes()
}
