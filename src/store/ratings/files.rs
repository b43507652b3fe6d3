//! Expands the given files and folders into a list of files, and reads the head of each file: its separator and its
//! column names.

use std::{
    collections::HashSet,
    io::Read as _,
    path::{Path, PathBuf},
};

use crate::{
    store::{
        Columns, FileError, FileErrors,
        dataset::DATA_FILE,
        error::NotData,
        frames,
        open::open_regular,
        table::{Content, MAX_ROW, each_row},
    },
    system::entries,
    text::names::natural,
};

/// Returns the files to read, without duplicates and in the given order. The files of a folder are in natural order of
/// their paths.
pub(super) fn files(paths: &[PathBuf]) -> (Vec<PathBuf>, Vec<FileError>) {
    let (mut found, mut errors) = (Vec::new(), Vec::new());
    let mut seen = HashSet::new();
    for path in paths {
        match std::fs::metadata(path) {
            Ok(metadata) if metadata.is_dir() => match folder(path) {
                Ok(files) if files.is_empty() => {
                    errors.push(FileError::whole(path, "contains no CSV files; expected a folder of result files"));
                }
                Ok(files) => found.extend(files),
                Err(message) => errors.push(FileError::whole(path, message)),
            },
            // A pattern such as `data/*.csv` matches the frames files along with the data files.
            Ok(_) if has_suffix(path, frames::SUFFIX) => {}
            Ok(_) => found.push(path.clone()),
            Err(error) => {
                errors.push(FileError::whole(
                    path,
                    format!("cannot be opened: {error}; expected a CSV file or a folder of CSV files"),
                ));
            }
        }
    }
    found.retain(|path| seen.insert(path.canonicalize().unwrap_or_else(|_| path.clone())));
    (found, errors)
}

/// Returns the data files of all sessions in a folder and its subfolders, in natural order of their paths.
///
/// # Errors
/// The folder cannot be read, or it contains no data files.
pub fn data_files(root: &Path) -> Result<Vec<PathBuf>, FileErrors> {
    let mut files = folder(root).map_err(|message| FileErrors::whole(root, message))?;
    files.retain(|path| has_suffix(path, DATA_FILE));
    if files.is_empty() {
        return Err(FileErrors::whole(root, "contains no session data files; expected a results folder"));
    }
    Ok(files)
}

/// Returns the names of the columns of a table, in the order of the file. A name may be empty or appear twice.
///
/// # Errors
/// The file is not a table of text.
pub fn column_names(path: &Path) -> Result<Vec<String>, FileError> {
    Header::read(path).map(|header| header.names)
}

/// Returns these paths and, for each one that is a folder, the files that would be read from it.
pub fn with_files(mut paths: Vec<PathBuf>) -> Vec<PathBuf> {
    let files: Vec<_> = paths.iter().filter(|path| path.is_dir()).filter_map(|path| folder(path).ok()).collect();
    paths.extend(files.into_iter().flatten());
    paths
}

/// Returns the data files in a folder and its subfolders; if there are none, all its CSV files.
fn folder(root: &Path) -> Result<Vec<PathBuf>, String> {
    let mut files = Vec::new();
    let mut entered = HashSet::new();
    let mut open = vec![root.to_owned()];
    while let Some(folder) = open.pop() {
        // Without this check, a link to a parent folder would be followed forever.
        if !entered.insert(folder.canonicalize().unwrap_or_else(|_| folder.clone())) {
            continue;
        }
        let shown = folder.display();
        let paths = entries(&folder)
            .map_err(|error| format!("the folder {shown} cannot be read: {error}; expected a readable folder"))?;
        for path in paths {
            // Hidden files belong to other programs; for example, a Mac adds a file `._name.csv` for each file that it
            // writes to a disk with a foreign file system.
            if path.file_name().is_some_and(|name| name.to_string_lossy().starts_with('.')) {
                continue;
            }
            if path.is_dir() {
                open.push(path);
            } else if has_suffix(&path, ".csv") {
                files.push(path);
            }
        }
    }
    if files.iter().any(|path| has_suffix(path, DATA_FILE)) {
        files.retain(|path| has_suffix(path, DATA_FILE));
    }
    files.sort_by(|a, b| natural(&a.to_string_lossy(), &b.to_string_lossy()));
    Ok(files)
}

fn has_suffix(path: &Path, suffix: &str) -> bool {
    path.file_name().is_some_and(|name| name.to_string_lossy().to_ascii_lowercase().ends_with(suffix))
}

/// Maximum number of bytes of the header row. A table with a thousand columns has about 10,000.
const MAX_HEAD: u64 = 1 << 16;
/// Maximum number of bytes of a file whose lines end with only a carriage return, because it is converted in memory.
const MAX_OLD: u64 = 64 << 20;

/// The head of a file.
#[derive(Clone, Debug, Default)]
pub(super) struct Header {
    /// Names of the columns.
    pub names: Vec<String>,
    /// The separator: a comma, a semicolon or a tab.
    pub separator: u8,
    /// The cells of the first row below the header, if there is one.
    pub first: Option<Vec<String>>,
    /// Size of the file in bytes.
    pub size: u64,
    /// The content of the file, if its line ends had to be converted.
    memory: Option<Vec<u8>>,
    /// The table, if it is not a file.
    pub columns: Option<Columns>,
}

impl Header {
    /// Reads the head of a file.
    ///
    /// # Errors
    /// The file is not readable, is empty, or is not UTF-8 text.
    pub fn read(path: &Path) -> Result<Self, FileError> {
        let unreadable = |error: std::io::Error| {
            let message = NotData::of(&error).map(ToString::to_string);
            let message = message.unwrap_or_else(|| format!("cannot be read: {error}; expected a readable CSV file"));
            FileError::whole(path, message)
        };
        let mut file = open_regular(path).map_err(unreadable)?;
        let size = file.metadata().map_err(unreadable)?.len();
        let mut head = Vec::new();
        file.by_ref().take(MAX_HEAD + MAX_ROW).read_to_end(&mut head).map_err(unreadable)?;
        let mut header = Self { size, ..Self::default() };
        // Old spreadsheets end lines with only a carriage return, but lines are counted by their line feeds.
        if head.contains(&b'\r') && !head.contains(&b'\n') {
            if size > MAX_OLD {
                let message = format!("has {size} bytes and no line feeds; expected lines that end with a line feed");
                return Err(FileError::whole(path, message));
            }
            let mut all = head.clone();
            file.read_to_end(&mut all).map_err(unreadable)?;
            all.iter_mut().filter(|byte| **byte == b'\r').for_each(|byte| *byte = b'\n');
            head = all[..head.len()].to_vec();
            header.memory = Some(all);
        }
        header.parse(&head).map_err(|(column, message)| FileError::at(path, (1, column), message))?;
        Ok(header)
    }

    /// Returns the head of a table in memory.
    pub fn of(columns: Columns) -> Self {
        let names: Vec<String> = columns.names().map(|name| name.trim().to_owned()).collect();
        let first = (columns.rows() > 0).then(|| (0..names.len()).map(|column| columns.cell(0, column)).collect());
        Self { names, separator: b',', first, columns: Some(columns), ..Self::default() }
    }

    fn parse(&mut self, head: &[u8]) -> Result<(), (usize, String)> {
        let error = |message: &str| Err((1, message.to_owned()));
        if head.starts_with(&[0xff, 0xfe]) || head.starts_with(&[0xfe, 0xff]) {
            return error("is UTF-16 text; expected CSV in UTF-8");
        }
        let text = head.strip_prefix(&[0xef, 0xbb, 0xbf]).unwrap_or(head);
        if text.iter().all(u8::is_ascii_whitespace) {
            return error("the file is empty; expected a header row");
        }
        if let Some(what) = packed(text) {
            return error(what);
        }
        let line = text.split(|byte| matches!(byte, b'\r' | b'\n')).find(|line| !line.is_empty()).unwrap_or_default();
        if line.contains(&0) {
            return error("is not a CSV file: its first line contains zero bytes; expected a header row");
        }
        if let Err(error) = std::str::from_utf8(line) {
            let column = String::from_utf8_lossy(&line[..error.valid_up_to()]).chars().count() + 1;
            return Err((column, "the header is not UTF-8 text; expected CSV in UTF-8".to_owned()));
        }
        if line.len() as u64 + 3 >= MAX_HEAD {
            return error("the first row is longer than 65,000 bytes; expected a header row");
        }
        self.separator = separator(line);
        let mut rows = Vec::new();
        // Reading from memory does not fail.
        let _ = each_row(Content::Memory(head), self.separator, |row| {
            if rows.len() < 2 {
                let cells = row.record.iter().map(|cell| String::from_utf8_lossy(cell).trim().to_owned());
                rows.push(cells.collect::<Vec<_>>());
            }
        });
        let mut rows = rows.into_iter();
        self.names = rows.next().unwrap_or_default();
        self.first = rows.next();
        Ok(())
    }

    /// Returns the content of the file at `path`, from memory if it is kept there.
    pub fn content<'a>(&'a self, path: &'a Path) -> Content<'a> {
        self.memory.as_deref().map_or(Content::File(path), Content::Memory)
    }

    /// Returns the index of a column.
    pub fn position(&self, name: &str) -> Option<usize> {
        self.names.iter().position(|known| known == name)
    }

    /// Returns the column, in characters from 1, where the name at an index begins.
    pub fn column(&self, index: usize) -> usize {
        self.names.iter().take(index).map(|name| name.chars().count() + 1).sum::<usize>() + 1
    }
}

/// Returns the separator: a comma or, if the header has more of them outside quotes, a semicolon or tab, as in
/// spreadsheets from some countries.
fn separator(line: &[u8]) -> u8 {
    let mut counts = [(b'\t', 0), (b';', 0), (b',', 0)];
    let mut quoted = false;
    for byte in line {
        quoted ^= *byte == b'"';
        counts.iter_mut().filter(|(separator, _)| !quoted && separator == byte).for_each(|(_, count)| *count += 1);
    }
    counts.into_iter().max_by_key(|(_, count)| *count).map_or(b',', |(separator, _)| separator)
}

/// Says what a file is if its first bytes are those of a compressed file or a spreadsheet.
fn packed(head: &[u8]) -> Option<&'static str> {
    let kinds: [(&[u8], &str); 6] = [
        (b"\x1f\x8b", "is compressed (gzip); expected CSV: unpack it first"),
        (
            b"PK\x03\x04",
            "is a spreadsheet (.xlsx, .ods) or a zip archive; expected CSV: export it as CSV or unpack it first",
        ),
        (b"BZh91AY", "is compressed (bzip2); expected CSV: unpack it first"),
        (b"\xfd7zXZ\0", "is compressed (xz); expected CSV: unpack it first"),
        (b"\x28\xb5\x2f\xfd", "is compressed (Zstandard); expected CSV: unpack it first"),
        (b"\xd0\xcf\x11\xe0", "is a spreadsheet (.xls); expected CSV: export it as CSV first"),
    ];
    kinds.into_iter().find(|(first, _)| head.starts_with(first)).map(|(_, what)| what)
}
