//! Expands the given files and folders into a list of files, and reads the head of each file: its separator and its
//! column names.

use std::{
    collections::HashSet,
    io::Read as _,
    path::{Path, PathBuf},
};

use crate::{
    store::{
        Columns, FileError, FileErrors, StoreError,
        dataset::{DATA_FILE, DESCRIPTION},
        error::io,
        frames,
        open::open_regular,
        table::{Content, MAX_ROW, each_row},
    },
    system::{entries, found, is_of_another_user},
    text::names::natural,
};

/// Returns the files to read, without duplicates and in the given order, and warnings about folders that were not read.
/// The files of a folder are in natural order of their paths.
///
/// # Errors
/// A file or folder does not exist or cannot be read; a folder contains no CSV files.
pub(super) fn files(paths: &[PathBuf]) -> Result<(Vec<PathBuf>, Vec<FileError>), FileErrors> {
    let (mut all, mut errors, mut warnings) = (Vec::new(), Vec::new(), Vec::new());
    for path in paths {
        match found(path).map_err(io(path, "access")) {
            Ok(Some(metadata)) if metadata.is_dir() => {
                let listed = Listed::of(path);
                if listed.files.is_empty() && listed.errors.is_empty() {
                    errors.push(FileError::whole(path, "contains no CSV files; expected a folder of result files"));
                }
                errors.extend(listed.errors);
                warnings.extend(listed.warnings);
                all.extend(listed.files);
            }
            // A pattern such as `data/*.csv` matches the frames files along with the data files.
            Ok(Some(_)) if has_suffix(path, frames::SUFFIX) => {}
            Ok(Some(_)) => all.push(path.clone()),
            Ok(None) => {
                let message = "does not exist; expected a CSV file or a folder of CSV files";
                errors.push(FileError::whole(path, message));
            }
            Err(error) => errors.extend(error.errors(path)),
        }
    }
    let mut seen = HashSet::new();
    all.retain(|path| match path.canonicalize().map_err(io(path, "access")) {
        Ok(full) => seen.insert(full),
        Err(error) => {
            errors.extend(error.errors(path));
            false
        }
    });
    if errors.is_empty() { Ok((all, warnings)) } else { Err(FileErrors([errors, warnings].concat())) }
}

/// Returns the names of the columns of a table, in the order of the file. A name may be empty or appear twice.
///
/// # Errors
/// The file cannot be read, or it is not a table of text.
pub fn column_names(path: &Path) -> Result<Vec<String>, StoreError> {
    Header::read(path).map(|header| header.names)
}

/// Returns these paths and, for each one that is a folder, the files that would be read from it.
///
/// # Errors
/// A folder cannot be read.
pub fn with_files(mut paths: Vec<PathBuf>) -> Result<Vec<PathBuf>, StoreError> {
    for path in paths.clone() {
        if found(&path).map_err(io(&path, "access"))?.is_some_and(|metadata| metadata.is_dir()) {
            let Listed { files, errors, .. } = Listed::of(&path);
            FileErrors::none(errors)?;
            paths.extend(files);
        }
    }
    Ok(paths)
}

/// What was found in a folder and its subfolders.
#[derive(Debug, Default)]
pub struct Listed {
    /// The data files of all sessions, in natural order of their paths; if there are none, all CSV files.
    pub files: Vec<PathBuf>,
    /// The folders that have the description of a data set.
    pub datasets: Vec<PathBuf>,
    /// The folders and files that could not be examined, so that `files` may not be complete.
    pub errors: Vec<FileError>,
    /// The folders that were not examined because they belong to another user or are hidden.
    pub warnings: Vec<FileError>,
}

impl Listed {
    /// Lists the sessions in a folder: only their data files. A file stands for itself.
    #[must_use]
    pub fn sessions(root: &Path) -> Self {
        if matches!(found(root), Ok(Some(found)) if found.is_file()) {
            return Self { files: vec![root.to_owned()], ..Self::default() };
        }
        let mut listed = Self::of(root);
        listed.files.retain(|path| has_suffix(path, DATA_FILE));
        listed
    }

    /// Succeeds if there are files and everything could be examined.
    ///
    /// # Errors
    /// There is nothing, or not everything could be examined.
    pub fn complete(self, root: &Path) -> Result<Self, FileErrors> {
        FileErrors::none(self.errors.clone())?;
        if self.files.is_empty() { Err(self.nothing(root)) } else { Ok(self) }
    }

    /// Returns the error that there is no session, with the warnings that may explain why.
    #[must_use]
    pub fn nothing(&self, root: &Path) -> FileErrors {
        let message = "contains no session data files; expected a results folder";
        FileErrors([&[FileError::whole(root, message)], &self.warnings[..]].concat())
    }

    /// Lists the tables in a folder.
    fn of(root: &Path) -> Self {
        let mut listed = Self::default();
        let mut entered = HashSet::new();
        let mut open = vec![root.to_owned()];
        while let Some(folder) = open.pop() {
            let inside = folder.canonicalize().and_then(|full| {
                // Without this check, a link to a parent folder would be followed forever.
                if entered.insert(full) { listed.enter(&folder) } else { Ok(Vec::new()) }
            });
            match inside {
                Ok(folders) => open.extend(folders),
                Err(error) => listed.refused(root, &folder, &error),
            }
        }
        if listed.files.iter().any(|path| has_suffix(path, DATA_FILE)) {
            listed.files.retain(|path| has_suffix(path, DATA_FILE));
        }
        listed.files.sort_by(|a, b| natural(&a.to_string_lossy(), &b.to_string_lossy()));
        listed.datasets.sort();
        listed
    }

    /// Lists what is in one folder, and returns the folders in it.
    fn enter(&mut self, folder: &Path) -> std::io::Result<Vec<PathBuf>> {
        let mut folders = Vec::new();
        for path in entries(folder)? {
            let name = path.file_name().unwrap_or_default();
            if name == DESCRIPTION {
                self.datasets.push(folder.to_owned());
            }
            // Hidden files belong to other programs; for example, a Mac adds a file `._name.csv` for each file that it
            // writes to a disk with a foreign file system.
            if name.to_string_lossy().starts_with('.') {
                let described = match found(&path.join(DESCRIPTION)) {
                    Err(error) if error.kind() == std::io::ErrorKind::PermissionDenied => None,
                    described => described?,
                };
                if described.is_some() {
                    let message =
                        "is a hidden data set and was not read; expected a name without a dot at its beginning";
                    self.warnings.push(FileError::whole(&path, message));
                }
            } else if found(&path)?.is_some_and(|metadata| metadata.is_dir()) {
                folders.push(path);
            } else if has_suffix(&path, ".csv") {
                self.files.push(path);
            }
        }
        Ok(folders)
    }

    /// Reports a folder that cannot be read. It is an error unless the folder belongs to somebody else, such as
    /// `lost+found`, and is not part of a data set.
    fn refused(&mut self, root: &Path, folder: &Path, error: &std::io::Error) {
        let is_of_dataset = || self.datasets.iter().any(|dataset| folder.starts_with(dataset));
        let is_denied = error.kind() == std::io::ErrorKind::PermissionDenied;
        if is_denied && folder != root && is_of_another_user(folder) && !is_of_dataset() {
            let message =
                "belongs to another user and cannot be read, so it was not examined; expected a readable folder";
            self.warnings.push(FileError::whole(folder, message));
        } else {
            let message = format!("the folder cannot be read: {error}; expected a readable folder");
            self.errors.push(FileError::whole(folder, message));
        }
    }
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
    pub fn read(path: &Path) -> Result<Self, StoreError> {
        let mut file = open_regular(path).map_err(io(path, "read"))?;
        let size = file.metadata().map_err(io(path, "read"))?.len();
        let mut head = Vec::new();
        file.by_ref().take(MAX_HEAD + MAX_ROW).read_to_end(&mut head).map_err(io(path, "read"))?;
        let mut header = Self { size, ..Self::default() };
        // Old spreadsheets end lines with only a carriage return, but lines are counted by their line feeds.
        if head.contains(&b'\r') && !head.contains(&b'\n') {
            if size > MAX_OLD {
                let message = format!("has {size} bytes and no line feeds; expected lines that end with a line feed");
                return Err(FileErrors::whole(path, message).into());
            }
            let mut all = head.clone();
            file.read_to_end(&mut all).map_err(io(path, "read"))?;
            all.iter_mut().filter(|byte| **byte == b'\r').for_each(|byte| *byte = b'\n');
            head = all[..head.len()].to_vec();
            header.memory = Some(all);
        }
        header.parse(&head).map_err(|(column, message)| FileErrors(vec![FileError::at(path, (1, column), message)]))?;
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
        if is_packed(text) {
            return error("is a spreadsheet or a compressed file; expected CSV: export it as CSV or unpack it first");
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

/// True if a file begins like a compressed file (gzip, bzip2, xz, Zstandard, zip) or a spreadsheet.
fn is_packed(head: &[u8]) -> bool {
    let kinds: [&[u8]; 6] =
        [b"\x1f\x8b", b"BZh91AY", b"\xfd7zXZ\0", b"\x28\xb5\x2f\xfd", b"PK\x03\x04", b"\xd0\xcf\x11\xe0"];
    kinds.iter().any(|first| head.starts_with(first))
}
