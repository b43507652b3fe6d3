//! The frames file of a session: a CSV file next to the data that contains every frame interval, with one row for each
//! run of consecutive frames with the same content.
//!
//! Frames describe a session but are not its data, so the session continues if this file cannot be written.

use std::path::Path;

use crate::{
    experiment::{FrameRun, Schedule, Trial},
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

/// Returns the line of a run of frames in a sitting, whose number is 1, plus 1 for each time the session was resumed; `None` if
/// the schedule has no such trial.
pub fn line(run: &FrameRun, schedule: &Schedule, sitting: u32) -> Option<String> {
    let Trial { phase, number, .. } = schedule.trials.get(run.trial)?;
    let refresh = run.refresh.map_or_else(String::new, |refresh| format!("{:.3}", refresh.seconds() * 1e6));
    let intervals: Vec<String> = run.intervals_us.iter().map(u32::to_string).collect();
    let (attempt, state) = (run.attempt, run.shown.name());
    Some(format!("{sitting},{phase},{number},{attempt},{state},{refresh},{}\n", intervals.join(" ")))
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

    /// Appends lines. They are kept in memory from now on, and they are in the file when this returns without an error.
    /// After an error, the next call tries again. A power failure may lose the last rows, because the session does not wait for
    /// the disk.
    ///
    /// # Errors
    /// I/O errors.
    pub fn append(&mut self, lines: &[String]) -> Result<(), StoreError> {
        if self.is_empty() && lines.is_empty() {
            return Ok(());
        }
        self.0.append(lines.concat().as_bytes())
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
