//! A session's rows: one CSV file, one row a trial, on disk before the next trial is shown.

use std::{fs, path::Path};

use crate::{
    experiment::{Column, TRAILING, TrialRecord},
    store::{
        FileFault, FileFaults, StoreError,
        fault::io,
        file::{AppendFile, Sync, split_torn},
        table::{self, CellFault, shortened},
    },
};

/// The result file of a running session.
#[derive(Debug)]
pub struct ResultFile {
    file: AppendFile,
    /// Columns that the file has: one that an earlier version began lacks some at the end.
    width: usize,
}

/// What a result file holds.
#[derive(Debug, PartialEq)]
pub struct Recovered {
    /// Its rows in the order of the file.
    pub rows: Vec<TrialRecord>,
    /// A last line that was half written.
    pub torn: Option<String>,
}

impl ResultFile {
    /// Creates the file with its header; an existing one is never touched.
    ///
    /// # Errors
    /// [`StoreError::Exists`], or the system's refusal.
    pub fn create(path: &Path, columns: &[Column]) -> Result<Self, StoreError> {
        let mut file = AppendFile::new(path, Sync::Always);
        file.append(&header(columns))?;
        Ok(Self { file, width: columns.len() })
    }

    /// Opens an interrupted session's file, and keeps every other program from it. Its rows are read by
    /// [`ResultFile::recover`].
    ///
    /// # Errors
    /// [`StoreError::InUse`], or the system's refusal.
    pub fn open(path: &Path) -> Result<Self, StoreError> {
        Ok(Self { file: AppendFile::open(path, Sync::Always)?, width: usize::MAX })
    }

    /// Reads the rows of a file that was opened. A last line that was half written is left out, and cut off by the
    /// next [`ResultFile::flush`]; until then the file is as it was.
    ///
    /// # Errors
    /// Rows that do not parse, each with line and column.
    pub fn recover(&mut self, columns: &[Column]) -> Result<Recovered, FileFaults> {
        let (name, torn) = (self.path().display().to_string(), self.file.torn().map(str::to_owned));
        if self.file.content().is_empty() {
            self.file.extend(&begun(&name, torn.as_deref(), columns)?);
        }
        let content = self.file.content();
        let rows = parse(&name, content, columns)?;
        self.width = columns_of(content, columns).len();
        Ok(Recovered { rows, torn })
    }

    /// SHA-256 of everything that belongs in the file.
    pub fn sha256(&self) -> String {
        self.file.sha256()
    }

    /// Where the file is.
    pub fn path(&self) -> &Path {
        self.file.path()
    }

    /// Adds a row. It is kept in memory from here on, and on disk when this returns without an error.
    ///
    /// # Errors
    /// The disk refuses, or the file is no longer the one that was written; [`ResultFile::flush`] tries again,
    /// [`ResultFile::move_to`] goes elsewhere.
    pub fn append(&mut self, record: &TrialRecord) -> Result<(), StoreError> {
        self.file.append(&table::line(record.cells().iter().take(self.width)))
    }

    /// Writes what is not on disk yet.
    ///
    /// # Errors
    /// As [`ResultFile::append`].
    pub fn flush(&mut self) -> Result<(), StoreError> {
        self.file.flush()
    }

    /// Puts everything recorded so far into a new file and continues there. The old file stays as it is.
    ///
    /// # Errors
    /// The new place refuses; the old one is then kept.
    pub fn move_to(&mut self, path: &Path) -> Result<(), StoreError> {
        self.file.move_to(path)
    }
}

/// Reads a result file and leaves it as it is. A last line that was half written is left out.
///
/// # Errors
/// The system's refusal; rows that do not parse, each with line and column.
pub fn read(path: &Path, columns: &[Column]) -> Result<Recovered, StoreError> {
    let (content, torn) = whole(path, columns)?;
    Ok(Recovered { rows: parse(&path.display().to_string(), &content, columns)?, torn })
}

/// The header and whole rows of a result file, and a last line that is half written.
///
/// # Errors
/// The system's refusal; a file that begins otherwise.
pub(crate) fn whole(path: &Path, columns: &[Column]) -> Result<(Vec<u8>, Option<String>), StoreError> {
    let (mut content, torn) = split_torn(fs::read(path).map_err(io(path, "read"))?);
    if content.is_empty() {
        content = begun(&path.display().to_string(), torn.as_deref(), columns)?;
    }
    Ok((content, torn))
}

/// The header of a file that has no whole line yet.
///
/// # Errors
/// It does not begin with this header, so that it is not to be cut off.
fn begun(file: &str, torn: Option<&str>, columns: &[Column]) -> Result<Vec<u8>, FileFaults> {
    let (header, found) = (header(columns), torn.unwrap_or_default());
    if header.starts_with(found.as_bytes()) {
        return Ok(header);
    }
    let [found, expected] = [found, &String::from_utf8_lossy(&header)].map(shortened);
    let message = format!("the file begins with {found:?}; expected the header {expected:?}");
    Err(FileFaults(vec![FileFault::at(file, (1, 1), message)]))
}

fn header(columns: &[Column]) -> Vec<u8> {
    table::line(columns.iter().map(|column| &column.name))
}

/// Those of the columns that the file has: one of an earlier version lacks some of the last.
fn columns_of<'a>(content: &[u8], columns: &'a [Column]) -> &'a [Column] {
    let header = content.split(|byte| *byte == b'\n').next().unwrap_or_default();
    // A column's name has no comma, and a header that differs otherwise is a fault of its own.
    let found = header.split(|byte| *byte == b',').count();
    let least = columns.len().saturating_sub(TRAILING);
    &columns[..if (least..columns.len()).contains(&found) { found } else { columns.len() }]
}

/// Reads all rows of a result file whose columns are known. The last of them may be missing where the file is of an
/// earlier version.
///
/// # Errors
/// Every row that does not parse, with line and column; a header that is not the expected one.
pub fn parse(file: &str, content: &[u8], columns: &[Column]) -> Result<Vec<TrialRecord>, FileFaults> {
    let all = columns.len();
    let header = |header: &[&str]| check_header(header, columns_of(content, columns));
    table::parse(file, content, header, |cells| {
        let mut full = cells.to_vec();
        full.resize(all.max(cells.len()), "");
        TrialRecord::from_cells(&full)
    })
}

/// Names the first column that is not the expected one.
fn check_header(header: &[&str], columns: &[Column]) -> Result<(), CellFault> {
    for i in 0..columns.len().max(header.len()) {
        let (found, expected) = (header.get(i).copied(), columns.get(i).map(|column| column.name.as_str()));
        if found != expected {
            let found = found.map_or("missing".to_owned(), |name| format!("{:?}", shortened(name)));
            let expected = expected.map_or("no further column".to_owned(), |name| format!("{name:?}"));
            return Err((i, format!("column {} is {found}; expected {expected}, as in a result file", i + 1)));
        }
    }
    Ok(())
}
