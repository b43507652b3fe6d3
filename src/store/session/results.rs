//! The result file of a session, a CSV file with one row per trial, each of which is on disk before the next trial is shown;
//! and its frames file.

use std::path::Path;

use crate::{
    experiment::{Column, FrameRun, Schedule, Trial, TrialRecord},
    store::{
        FileErrors, StoreError,
        error::io,
        file::{AppendFile, complete_lines_or_header, exists, split_partial_line},
        open::read_regular,
        table::{self, exactly},
    },
};

/// Maximum size in bytes of a session's file. The longest session has 100,000 trials; a row has about 300 bytes.
pub(in crate::store) const MAX_FILE: u64 = 256 << 20;

/// Opens and locks the file of an interrupted session. The file is not changed until the next write, which removes an
/// incomplete last line.
///
/// # Errors
/// [`StoreError::InUse`]; I/O errors; or the file has no complete line and does not begin with the header.
pub(super) fn open(path: &Path, columns: &[Column]) -> Result<AppendFile, StoreError> {
    AppendFile::open(path, true, header(columns), MAX_FILE)
}

/// Reads a result file without changing it. An incomplete last line is ignored.
///
/// # Errors
/// I/O errors; every row that cannot be parsed, with its line and column.
pub fn read(path: &Path, columns: &[Column]) -> Result<Vec<TrialRecord>, StoreError> {
    let (content, _) = whole(path, content(path)?, columns)?;
    Ok(parse(&path.display().to_string(), &content, columns)?)
}

/// Reads the content of a result file.
///
/// # Errors
/// I/O errors; or the file is too large.
pub(in crate::store) fn content(path: &Path) -> Result<Vec<u8>, StoreError> {
    read_regular(path, MAX_FILE).map_err(io(path, "read"))
}

/// Splits the content of the result file at `path` into the header with the complete rows, and an incomplete last line.
///
/// # Errors
/// The content has no complete line and does not begin with the header.
pub(in crate::store) fn whole(
    path: &Path,
    content: Vec<u8>,
    columns: &[Column],
) -> Result<(Vec<u8>, Option<String>), FileErrors> {
    let (whole, partial_line) = split_partial_line(content);
    Ok((complete_lines_or_header(path, whole, partial_line.as_deref(), header(columns))?, partial_line))
}

/// Returns the number of rows in the content of a result file with a header.
pub(super) fn count(content: &[u8]) -> usize {
    content.iter().filter(|byte| **byte == b'\n').count().saturating_sub(1)
}

pub(super) fn header(columns: &[Column]) -> Vec<u8> {
    table::line(columns.iter().map(|column| &column.name))
}

/// Parses all rows of a result file with known columns.
///
/// # Errors
/// Reports every row that cannot be parsed, with its line and column, and a header that is not the expected one.
pub fn parse(file: &str, content: &[u8], columns: &[Column]) -> Result<Vec<TrialRecord>, FileErrors> {
    let header = |names: &[&str]| exactly(names, columns.iter().map(|column| column.name.as_str()));
    let row = |(): &(), cells: &[&str]| TrialRecord::from_cells(cells, columns);
    Ok(table::parse(file, content, b',', header, row)?.1)
}

/// The header row of a frames file.
pub const FRAMES_HEADER: &str = "sitting,phase,trial,attempt,state,refresh_us,intervals_us";
/// Maximum size of a frames file in bytes. Frames of 8 hours at 480 Hz have half of it.
pub(in crate::store) const MAX_FRAMES: u64 = 2 << 30;

/// Returns the line of a run of frames in a sitting, whose number is 1, plus 1 for each time the session was resumed; `None` if
/// the schedule has no such trial.
pub fn frames_line(run: &FrameRun, schedule: &Schedule, sitting: u32) -> Option<String> {
    let Trial { phase, number, .. } = schedule.trials.get(run.trial)?;
    let refresh = run.refresh.map_or_else(String::new, |refresh| format!("{:.3}", refresh.seconds() * 1e6));
    let intervals: Vec<String> = run.intervals_us.iter().map(u32::to_string).collect();
    let (attempt, state) = (run.attempt, run.shown.name());
    Some(format!("{sitting},{phase},{number},{attempt},{state},{refresh},{}\n", intervals.join(" ")))
}

/// Prepares the frames file of a new session: a CSV file next to the data that contains every frame interval, with one row for
/// each run of consecutive frames with the same content. Frames describe a session but are not its data, so the session
/// continues if this file cannot be written. It is created with the first row, so a session without a screen has none.
pub fn new_frames(path: &Path) -> AppendFile {
    AppendFile::new(path, false, frames_header())
}

/// Opens the frames file of a resumed session, and keeps its content except for an incomplete last line.
///
/// # Errors
/// The file exists but cannot be read or is not a frames file, so it must not be written to.
pub fn open_frames(path: &Path) -> Result<AppendFile, StoreError> {
    if !exists(path)? {
        return Ok(new_frames(path));
    }
    let file = AppendFile::open(path, false, frames_header(), MAX_FRAMES)?;
    if !file.content().starts_with(&frames_header()) {
        let message = format!("is not a frames file; expected the header {FRAMES_HEADER}");
        return Err(FileErrors::whole(path, message).into());
    }
    Ok(file)
}

fn frames_header() -> Vec<u8> {
    format!("{FRAMES_HEADER}\n").into_bytes()
}
