//! The result file of a session: a CSV file with one row per trial. Each row is on disk before the next trial is shown.

use std::path::Path;

use crate::{
    experiment::{Column, TrialRecord},
    store::{
        FileErrors, StoreError,
        error::io,
        file::{AppendFile, complete_lines_or_header, split_partial_line},
        open::read_regular,
        table::{self, exactly},
    },
};

/// Maximum size in bytes of a session's file. The longest session has 100,000 trials; a row has about 300 bytes.
pub(in crate::store) const MAX_FILE: u64 = 256 << 20;

/// Creates the file of a new session with its header. An existing file is never touched.
///
/// # Errors
/// [`StoreError::Exists`], or an I/O error.
pub(super) fn create(path: &Path, columns: &[Column]) -> Result<AppendFile, StoreError> {
    let mut file = AppendFile::new(path, true, header(columns));
    file.flush()?;
    Ok(file)
}

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
pub(super) fn content(path: &Path) -> Result<Vec<u8>, StoreError> {
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

pub(super) fn header(columns: &[Column]) -> Vec<u8> {
    table::line(columns.iter().map(|column| &column.name))
}

/// Parses all rows of a result file with known columns.
///
/// # Errors
/// Reports every row that cannot be parsed, with its line and column, and a header that is not the expected one.
pub fn parse(file: &str, content: &[u8], columns: &[Column]) -> Result<Vec<TrialRecord>, FileErrors> {
    table::parse(
        file,
        content,
        b',',
        |header| exactly(header, columns.iter().map(|column| column.name.as_str())),
        |cells, _| TrialRecord::from_cells(cells, columns),
    )
}
