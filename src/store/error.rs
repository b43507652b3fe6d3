//! Errors in files, with their locations.

use std::{
    collections::BTreeMap,
    io::ErrorKind,
    path::{Path, PathBuf},
};

use crate::system::signals::Ended;

/// One error in a file: its location, what is wrong, and what is expected.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FileError {
    /// The file, or the name of a built-in definition.
    pub file: String,
    /// Line and column, counted from 1; the column is in characters.
    pub position: Option<(usize, usize)>,
    /// The key in a TOML file, such as `factors.width.2`; empty if no key is known.
    pub key: String,
    /// What is wrong; what is expected.
    pub message: String,
    /// The rows of a table in memory that it is about, counted from 0.
    pub rows: Vec<usize>,
}

/// Maximum length of a message that is shown whole, bytes. A single value of a file may have megabytes.
const MAX_MESSAGE: usize = 2000;

impl std::fmt::Display for FileError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        // An error is one line, whatever a file or a column is called.
        let line = |text: &str| -> String {
            let each = text.chars().map(|c| if c.is_control() { c.escape_default().to_string() } else { c.into() });
            each.collect()
        };
        f.write_str(&line(&self.file))?;
        if let Some((line, column)) = self.position {
            write!(f, ":{line}:{column}")?;
        }
        let message = line(&self.message);
        if message.len() <= MAX_MESSAGE {
            return write!(f, ": {message}");
        }
        let first = &message[..message.floor_char_boundary(MAX_MESSAGE / 2)];
        let last = &message[message.ceil_char_boundary(message.len() - MAX_MESSAGE / 2)..];
        write!(f, ": {first} … {last}")
    }
}

impl FileError {
    /// Creates an error at a line and column, counted from 1.
    pub fn at(file: impl AsRef<Path>, position: (usize, usize), message: impl Into<String>) -> Self {
        // Some parsers count the end of a line as column 0 of the next one.
        Self { position: Some((position.0.max(1), position.1.max(1))), ..Self::whole(file, message) }
    }

    /// Creates an error about a whole file.
    pub fn whole(file: impl AsRef<Path>, message: impl Into<String>) -> Self {
        let file = file.as_ref().display().to_string();
        Self { file, position: None, key: String::new(), message: message.into(), rows: Vec::new() }
    }
}

/// Returns the line and column of a byte offset, both counted from 1.
pub(super) fn position(text: &str, offset: usize) -> (usize, usize) {
    let before = text.get(..offset).unwrap_or(text);
    let line_start = before.rfind('\n').map_or(0, |i| i + 1);
    (before.matches('\n').count() + 1, before[line_start..].chars().count() + 1)
}

/// All errors in a file, in the order of the file; never empty.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub struct FileErrors(pub Vec<FileError>);

impl FileErrors {
    /// Creates a single error about the whole file.
    pub fn whole(file: impl AsRef<Path>, message: impl Into<String>) -> Self {
        Self(vec![FileError::whole(file, message)])
    }

    /// Creates a single error at a line and column, counted from 1.
    pub fn at(file: impl AsRef<Path>, position: (usize, usize), message: impl Into<String>) -> Self {
        Self(vec![FileError::at(file, position, message)])
    }

    /// Succeeds if the list is empty.
    ///
    /// # Errors
    /// Returns the errors in the list, if there are any.
    pub fn none(errors: Vec<FileError>) -> Result<(), Self> {
        if errors.is_empty() { Ok(()) } else { Err(Self(errors)) }
    }
}

impl std::fmt::Display for FileErrors {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let lines: Vec<String> = self.0.iter().map(ToString::to_string).collect();
        f.write_str(&lines.join("\n"))
    }
}

/// Maximum number of errors kept for one column of a table.
const MAX_KEPT: usize = 5;

/// The errors in a table's rows: the first ones in each column are kept, and the others are counted.
#[derive(Clone, Debug, Default)]
pub(super) struct RowErrors {
    kept: Vec<FileError>,
    /// For each error in a column, kept or not, its row in a table in memory; `None` stands for the row as a whole.
    rows: BTreeMap<Option<usize>, Vec<Option<usize>>>,
}

impl RowErrors {
    /// Adds the error that `make` returns, with its row in a table in memory; it is called only if the error is kept.
    pub fn add(&mut self, row: Option<usize>, cell: Option<usize>, make: impl FnOnce() -> FileError) {
        let rows = self.rows.entry(cell).or_default();
        rows.push(row);
        if rows.len() <= MAX_KEPT {
            self.kept.push(make());
        }
    }

    /// Returns the errors that were kept, and for each column the number of further errors; `columns` are the names in
    /// the header.
    pub fn finish(self, file: &str, columns: &[impl AsRef<str>]) -> Vec<FileError> {
        let mut errors = self.kept;
        errors.sort_by_key(|error| error.position);
        for (cell, rows) in self.rows.into_iter().filter(|(_, rows)| rows.len() > MAX_KEPT) {
            let column = cell.and_then(|cell| columns.get(cell));
            let column = column.map_or(String::new(), |name| format!(" in {}", name.as_ref()));
            let message = format!("further rows with errors{column}: {}; expected none", rows.len() - MAX_KEPT);
            errors.push(FileError {
                rows: rows[MAX_KEPT..].iter().flatten().copied().collect(),
                ..FileError::whole(file, message)
            });
        }
        errors
    }
}

/// Why a path cannot be read as data, although the system would open it.
#[derive(Debug, thiserror::Error)]
pub(super) enum NotData {
    #[error("is a folder; expected a file")]
    Folder,
    #[error("is not a regular file; expected one, not a device, pipe or socket")]
    Special,
    #[error("has {size} bytes; expected at most {most}")]
    TooLarge { size: u64, most: u64 },
}

impl NotData {
    /// Returns the reason within an I/O error, if there is one.
    pub fn of(error: &std::io::Error) -> Option<&Self> {
        error.get_ref()?.downcast_ref()
    }
}

/// The reasons why results could not be stored or found.
#[derive(Debug, thiserror::Error)]
pub enum StoreError {
    /// An I/O error.
    #[error("{}: cannot {action}: {source}; expected {}", path.display(), expected(source))]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// The attempted action, as a verb.
        action: &'static str,
        /// The system's error.
        source: std::io::Error,
    },
    /// A new session would overwrite an old one.
    #[error("{}: this session of this participant already exists; expected a different session", .0.display())]
    Exists(PathBuf),
    /// A file exists at the path of an output.
    #[error("{}: already exists; expected a new file", .0.display())]
    Occupied(PathBuf),
    /// An output must not be written to this path, for example because it would replace a file of a session.
    #[error("{}: {what}", path.display())]
    Protected {
        /// The output.
        path: PathBuf,
        /// What is wrong with the path, and what is expected.
        what: String,
    },
    /// Another program is writing the same session.
    #[error("{}: another machband process is writing this session; expected it to be closed first", .0.display())]
    InUse(PathBuf),
    /// There is nothing to resume.
    #[error("{}: no such session; expected an interrupted session", .0.display())]
    NothingToResume(PathBuf),
    /// Files are refused unless the option of this name is given.
    #[error("{0}")]
    Refused(FileErrors, &'static str),
    /// A file cannot be parsed.
    #[error(transparent)]
    FileErrors(#[from] FileErrors),
}

impl From<Ended> for StoreError {
    fn from(Ended { place, signal }: Ended) -> Self {
        FileErrors::whole(place, format!("ended by {signal}; expected to be done to the end")).into()
    }
}

impl StoreError {
    /// Returns the option that makes possible what is refused, if there is one.
    pub fn remedy(&self) -> Option<&'static str> {
        match self {
            Self::Exists(_) => Some("resume"),
            Self::Occupied(_) => Some("force"),
            Self::Refused(_, option) => Some(option),
            _ => None,
        }
    }

    /// Converts the error to a list of errors in the file at `path`.
    pub(crate) fn errors(self, path: &Path) -> Vec<FileError> {
        match self {
            Self::FileErrors(FileErrors(errors)) | Self::Refused(FileErrors(errors), _) => errors,
            Self::Io { path, action, source } => {
                vec![FileError::whole(path, format!("cannot {action}: {source}; expected {}", expected(&source)))]
            }
            error => vec![FileError::whole(path, error.to_string())],
        }
    }

    /// Refuses to write an output to this path; says what is wrong, and what is expected.
    pub fn protected(path: &Path, what: impl Into<String>) -> Self {
        Self::Protected { path: path.to_owned(), what: what.into() }
    }

    /// Creates an I/O error with the path and the attempted action.
    pub fn io(path: &Path, action: &'static str, source: std::io::Error) -> Self {
        if let Some(reason) = NotData::of(&source) {
            return FileErrors::whole(path, reason.to_string()).into();
        }
        Self::Io { path: path.to_owned(), action, source }
    }
}

/// Says what was expected where the system reported an error.
fn expected(error: &std::io::Error) -> &'static str {
    match error.kind() {
        ErrorKind::NotFound => "a path that exists",
        ErrorKind::PermissionDenied | ErrorKind::ReadOnlyFilesystem => "permission to do this",
        ErrorKind::StorageFull | ErrorKind::QuotaExceeded => "enough free space",
        _ => "a path and a disk that can be read and written",
    }
}

/// Attaches the path and the action to an I/O error.
pub(super) fn io<'a>(path: &'a Path, action: &'static str) -> impl FnOnce(std::io::Error) -> StoreError + 'a {
    move |source| StoreError::io(path, action, source)
}
