//! A session's rows: one CSV file, one row a trial, on disk before the next trial is shown.

use std::{fs, path::Path};

use super::{
    FileFault, FileFaults, StoreError,
    fault::io,
    file::{AppendFile, Sync, whole_lines},
};
use crate::experiment::{Column, TRAILING, TrialRecord};

/// The result file of a running session.
#[derive(Debug)]
pub struct ResultFile {
    file: AppendFile,
    /// Columns that the file has: one that an earlier version began lacks some at the end.
    width: usize,
}

/// What an interrupted session left.
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
        file.append(&line(columns.iter().map(|column| column.name.as_str())))?;
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
        let name = self.path().display().to_string();
        let (recovered, content, whole) = recover(&name, self.file.content(), columns)?;
        self.width = columns_of(&content, columns).len();
        self.file.repair(content, whole);
        Ok(recovered)
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
        self.file.append(&line(record.cells().iter().take(self.width).map(String::as_str)))
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
    let content = fs::read(path).map_err(io(path, "read"))?;
    Ok(recover(&path.display().to_string(), &content, columns)?.0)
}

/// A result file without a last line that is half written: the header and whole rows.
///
/// # Errors
/// As [`read`].
pub(super) fn whole(path: &Path, columns: &[Column]) -> Result<Vec<u8>, StoreError> {
    let content = fs::read(path).map_err(io(path, "read"))?;
    Ok(recover(&path.display().to_string(), &content, columns)?.1)
}

/// What a file holds, its content without a half-written last line, and how much of the file that is.
fn recover(file: &str, found: &[u8], columns: &[Column]) -> Result<(Recovered, Vec<u8>, usize), FileFaults> {
    let header = line(columns.iter().map(|column| column.name.as_str()));
    let whole = whole_lines(found).len();
    let rest = without_zeros(&found[whole..]);
    if whole == 0 && !header.starts_with(rest) {
        // Not the beginning of a file of ours: not to be cut away.
        let [found, expected] = [rest, &header].map(|line| clipped(&String::from_utf8_lossy(line)));
        let message = format!("the file begins with {found:?}; expected the header {expected:?}");
        return Err(FileFaults(vec![FileFault { file: file.to_owned(), position: Some((1, 1)), message }]));
    }
    let torn = (whole < found.len()).then(|| String::from_utf8_lossy(rest).into_owned());
    let content = if whole == 0 { header } else { found[..whole].to_vec() };
    let rows = parse(file, &content, columns)?;
    Ok((Recovered { rows, torn }, content, whole))
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
    let mut faults = Vec::new();
    let mut rows = Vec::new();
    let mut fault = |position: (usize, usize), message: String| {
        faults.push(FileFault { file: file.to_owned(), position: Some(position), message });
    };
    let mut reader = csv::ReaderBuilder::new().has_headers(false).flexible(true).from_reader(content);
    let mut record = csv::StringRecord::new();
    let mut header = true;
    let (all, columns) = (columns.len(), columns_of(content, columns));
    loop {
        let read = reader.read_record(&mut record);
        let position = |place: Option<&csv::Position>| place.map_or(1, |place| place.line() as usize);
        let line_number = position(record.position());
        match read {
            Ok(false) => break,
            Ok(true) if header => {
                header = false;
                if header_faults(&record, columns, &mut fault) {
                    // Another kind of file: its rows would be as many faults.
                    break;
                }
            }
            Ok(true) => {
                let cells: Vec<&str> = record.iter().collect();
                let column_at =
                    |index: usize| cells.iter().take(index).map(|cell| written_width(cell) + 1).sum::<usize>() + 1;
                if cells.len() != columns.len() {
                    fault((line_number, 1), format!("the row has {} cells; expected {}", cells.len(), columns.len()));
                    continue;
                }
                let mut full = cells.clone();
                full.resize(all, "");
                match TrialRecord::from_cells(&full) {
                    Ok(row) => rows.push(row),
                    Err((index, message)) => fault((line_number, column_at(index)), message),
                }
            }
            Err(error) => {
                let message = match error.kind() {
                    csv::ErrorKind::Utf8 { .. } => "the row is not UTF-8 text; expected UTF-8".to_owned(),
                    _ => format!("the row cannot be read: {error}; expected CSV"),
                };
                fault((position(error.position()), 1), message);
            }
        }
    }
    if header {
        fault((1, 1), "the file is empty; expected a header row".to_owned());
    }
    if faults.is_empty() { Ok(rows) } else { Err(FileFaults(faults)) }
}

/// Names the first column that is not the expected one; gives whether it is the very first: another kind of file.
fn header_faults(
    header: &csv::StringRecord,
    columns: &[Column],
    fault: &mut impl FnMut((usize, usize), String),
) -> bool {
    let mut at = 1;
    for i in 0..columns.len().max(header.len()) {
        let (found, expected) = (header.get(i), columns.get(i).map(|column| column.name.as_str()));
        if found != expected {
            let found = found.map_or("missing".to_owned(), |name| format!("{:?}", clipped(name)));
            let expected = expected.map_or("no further column".to_owned(), |name| format!("{name:?}"));
            fault((1, at), format!("column {} is {found}; expected {expected}, as in a result file", i + 1));
            return i == 0;
        }
        at += found.map_or(0, |name| name.chars().count()) + 1;
    }
    false
}

fn without_zeros(content: &[u8]) -> &[u8] {
    let end = content.iter().rposition(|byte| *byte != 0).map_or(0, |last| last + 1);
    &content[..end]
}

/// Width of a cell in its line, with the quotes that it needs.
fn written_width(cell: &str) -> usize {
    let quotes = cell.matches('"').count();
    let quoted = quotes > 0 || cell.contains([',', '\n', '\r']);
    cell.chars().count() + quotes + if quoted { 2 } else { 0 }
}

/// The beginning of what may be anything, for a message.
fn clipped(text: &str) -> String {
    const SHOWN: usize = 60;
    let mut shown: String = text.chars().take(SHOWN).collect();
    if shown.len() < text.len() {
        shown.push('…');
    }
    shown
}

/// One line of CSV. A cell never holds a line break, so that a line is a row.
fn line<'a>(cells: impl Iterator<Item = &'a str>) -> Vec<u8> {
    let mut writer = csv::WriterBuilder::new().from_writer(Vec::new());
    let clean: Vec<String> = cells.map(|cell| cell.replace(['\n', '\r'], " ")).collect();
    // Writing to memory does not fail, and one record cannot differ in length from the others.
    let _ = writer.write_record(&clean);
    writer.into_inner().unwrap_or_default()
}
