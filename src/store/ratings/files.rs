//! Expands the given files and folders into a list of files, and reads the head of each file: its separator and its
//! column names. Files that are not plain text in UTF-8 with line feeds, such as packed files and Excel workbooks (`.xlsx`),
//! are converted in memory.

use std::{
    collections::{BTreeSet, HashSet},
    io::Cursor,
    ops::Range,
    path::{Path, PathBuf},
};

use calamine::{Data, DataRef, Reader as _, SheetVisible, Xlsx};
use encoding_rs::{Encoding, UTF_8};
use flate2::read::MultiGzDecoder;
use zip::ZipArchive;

use crate::{
    store::{
        Columns, FileError, FileErrors, StoreError,
        dataset::{self, DATA_FILE, DESCRIPTION, FRAMES_SUFFIX},
        error::io,
        file,
        open::{MAX_UNPACKED, is_data, read_regular, unpacked},
        table::{BYTE_ORDER_MARK, Content, decoded, line, list, rows_from, separator},
    },
    system::{entries, found, identified, is_of_another_user},
    text::names::natural,
};

/// The tables by which the output of an analysis is known.
const ANALYSES: [[&str; 2]; 2] = [["cells.csv", "counts.csv"], ["answers.csv", "thresholds.csv"]];

/// Lists the files to read, without duplicates and in the given order. The files of a folder are in natural order of their
/// paths. What is beside the sessions of a folder and belongs to none is an error, because rows may be missing.
///
/// # Errors
/// A file or folder does not exist or cannot be read; a folder contains no tables.
pub fn files(paths: &[PathBuf]) -> Result<Listed, FileErrors> {
    let (mut all, mut errors) = (Listed::default(), Vec::new());
    for path in paths {
        let mut listed = Listed::of(path);
        if listed.files.is_empty() && listed.errors.is_empty() {
            errors.push(FileError::whole(path, "contains no tables; expected a folder of CSV files"));
        } else if listed.files != [path.clone()] {
            all.errors.extend(listed.unexpected(&[]));
        }
        // A pattern such as `data/*.csv` matches the frames files along with the data files.
        listed.files.retain(|file| file != path || !has_suffix(file, FRAMES_SUFFIX));
        errors.extend(listed.errors);
        all.warnings.extend(listed.warnings);
        all.files.extend(listed.files);
    }
    let mut seen = HashSet::new();
    all.files.retain(|path| match full(path) {
        Ok(full) => seen.insert(full),
        Err(error) => {
            errors.extend(error.errors(path));
            false
        }
    });
    if errors.is_empty() { Ok(all) } else { Err(FileErrors([errors, all.warnings].concat())) }
}

/// Returns the full path of a data file, if it is a file, and so is its sidecar: otherwise, they cannot be read.
fn full(path: &Path) -> Result<PathBuf, StoreError> {
    let sidecar = has_suffix(path, DATA_FILE).then(|| path.with_extension("json"));
    for one in [path].into_iter().chain(sidecar.as_deref()) {
        let metadata = found(one).map_err(io(one, "access"))?;
        metadata.map_or(Ok(()), |metadata| is_data(&metadata)).map_err(io(one, "read"))?;
    }
    path.canonicalize().map_err(io(path, "access"))
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
    /// The data files of all sessions, in natural order of their paths; if there are none, all tables.
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
    pub fn sessions(root: &Path) -> Self {
        let mut listed = Self::of(root);
        listed.files.retain(|path| path == root || has_suffix(path, DATA_FILE));
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
    pub fn nothing(&self, root: &Path) -> FileErrors {
        let message = "contains no session data files; expected a results folder";
        FileErrors([&[FileError::whole(root, message)], &self.warnings[..]].concat())
    }

    /// Returns the files in the folders of the sessions, and of the data sets `also`, that belong to no session. Folders with
    /// other errors are left out.
    pub fn unexpected(&self, also: &[PathBuf]) -> Vec<FileError> {
        let sessions = self.files.iter().filter(|csv| dataset::identity(csv).is_ok());
        let mut datasets: BTreeSet<PathBuf> = also.iter().cloned().collect();
        let mut errors = Vec::new();
        for csv in sessions {
            match dataset::of(csv) {
                Ok(dataset) => datasets.extend(dataset),
                Err(error) => errors.extend(error.errors(csv)),
            }
        }
        let is_listed =
            |dataset: &PathBuf| !self.errors.iter().any(|error| Path::new(&error.file).starts_with(dataset));
        let unexpected =
            datasets.iter().filter(|dataset| is_listed(dataset)).flat_map(|one| dataset::unexpected_files(one));
        errors.into_iter().chain(unexpected).collect()
    }

    /// Lists the tables in a folder. A file stands for itself.
    fn of(root: &Path) -> Self {
        let mut listed = Self::default();
        match found(root).map_err(io(root, "access")) {
            Ok(Some(metadata)) if !metadata.is_dir() => listed.files.push(root.to_owned()),
            Err(error) => listed.errors = error.errors(root),
            Ok(_) => listed.walk(root),
        }
        listed
    }

    /// Lists the tables in a folder and its subfolders.
    fn walk(&mut self, root: &Path) {
        let mut entered = HashSet::new();
        let mut open = vec![root.to_owned()];
        while let Some(folder) = open.pop() {
            let inside = identified(&folder).and_then(|folder_id| {
                // Without this check, a link to a parent folder would be followed forever.
                if entered.insert(folder_id) { self.enter(root, &folder) } else { Ok(Vec::new()) }
            });
            match inside {
                Ok(folders) => open.extend(folders),
                Err(error) => self.refused(root, &folder, &error),
            }
        }
        if self.files.iter().any(|path| has_suffix(path, DATA_FILE)) {
            self.files.retain(|path| has_suffix(path, DATA_FILE));
        }
        self.files.sort_by(|a, b| natural(&a.to_string_lossy(), &b.to_string_lossy()));
        self.datasets.sort();
    }

    /// Lists what is in one folder, and returns the folders in it. An analysis that was written below `root`, but not
    /// into a data set, is not part of the data: its counts would count every rating again.
    fn enter(&mut self, root: &Path, folder: &Path) -> std::io::Result<Vec<PathBuf>> {
        let mut folders = Vec::new();
        let inside = entries(folder)?;
        let has = |name: &str| inside.contains(&folder.join(name));
        let is_analysis = || ANALYSES.iter().any(|names| names.iter().all(|name| has(name)));
        if folder != root && !has(DESCRIPTION) && is_analysis() {
            return Ok(folders);
        }
        for path in inside {
            let name = path.file_name().unwrap_or_default();
            if name == DESCRIPTION {
                self.datasets.push(folder.to_owned());
            }
            // Hidden files belong to other programs; for example, a Mac adds a file `._name.csv` for each file that it
            // writes to a disk with a foreign file system, and Excel a file `~$name.xlsx` for each one that is open.
            if name.to_string_lossy().starts_with(['.', '~']) {
                let described = match found(&path.join(DESCRIPTION)) {
                    Err(error) if error.kind() == std::io::ErrorKind::PermissionDenied => None,
                    described => described?,
                };
                if described.is_some() {
                    let message =
                        "is a hidden data set and was not read; expected a name without a dot at its beginning";
                    self.warnings.push(FileError::whole(&path, message));
                }
                continue;
            }
            match found(&path) {
                Err(error) => {
                    let message = format!("cannot be examined: {error}; expected a file or folder");
                    self.errors.push(FileError::whole(&path, message));
                }
                Ok(Some(metadata)) if metadata.is_dir() && has_suffix(&path, DATA_FILE) => {
                    let message = "is a folder; expected the data file of a session";
                    self.errors.push(FileError::whole(&path, message));
                }
                Ok(Some(metadata)) if metadata.is_dir() => folders.push(path),
                Ok(_) if [".csv", ".tsv", ".csv.gz", ".xlsx"].iter().any(|suffix| has_suffix(&path, suffix)) => {
                    self.files.push(path);
                }
                Ok(_) => {}
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
            let message = match error.kind() {
                std::io::ErrorKind::NotFound => {
                    "does not exist; expected a data file, or a folder of data files".to_owned()
                }
                _ => format!("the folder cannot be read: {error}; expected a readable folder"),
            };
            self.errors.push(FileError::whole(folder, message));
        }
    }
}

fn has_suffix(path: &Path, suffix: &str) -> bool {
    path.file_name().is_some_and(|name| name.to_string_lossy().to_ascii_lowercase().ends_with(suffix))
}

/// The column with the participant ID in result files.
pub(super) const SUBJECT: &str = "subject_id";
/// The names of this column in the tables of PsychoPy, BIDS, jsPsych and E-Prime, and OpenSesame. A name such as `id` may stand
/// for a trial or a stimulus.
const SUBJECTS: [&str; 4] = ["participant", "participant_id", "subject", "subject_nr"];

/// Number of rows that may be a part of the header below its first one, and in which the separator may be.
const MAX_LABELS: usize = 2;

/// Maximum size of a table in bytes. Larger ones come as counts.
const MAX_TABLE: u64 = 4 << 30;

/// Maximum size, in bytes, of a file for which a hash is reported.
const MAX_HASHED: usize = 64 << 20;

/// A file in memory, and its head.
#[derive(Clone, Debug, Default)]
pub(in crate::store) struct Header {
    /// Names of the columns.
    pub names: Vec<String>,
    /// The separator: a comma, a semicolon, a tab, a vertical bar, or what the first line says.
    pub separator: u8,
    /// The line of the header.
    pub line: usize,
    /// The cells of the first row below the header, if there is one.
    pub first: Option<Vec<String>>,
    /// Number of rows below the header that are part of it.
    pub labels: usize,
    /// True if the header has one text at most, and a row below it has several.
    pub is_title: bool,
    /// SHA-256 of the file, unless it is large.
    pub sha256: Option<String>,
    /// The content of the file, as text if that is not what it is.
    pub(super) text: Converted,
    /// The table, if it is not a file.
    pub columns: Option<Columns>,
}

impl Header {
    /// Reads a file and its head.
    ///
    /// # Errors
    /// The file is not readable, is empty, or is not a table.
    pub fn read(path: &Path) -> Result<Self, StoreError> {
        let bytes = read_regular(path, MAX_TABLE).map_err(io(path, "read"))?;
        let sha256 = (bytes.len() <= MAX_HASHED).then(|| file::sha256(&bytes));
        let text = converted(bytes).map_err(|message| FileErrors::whole(path, message))?;
        let mut header = Self { sha256, text, line: 1, ..Self::default() };
        header.parse().map_err(|message| FileErrors::at(path, (1, 1), message))?;
        Ok(header)
    }

    /// Returns the head of a table in memory.
    pub fn of(columns: Columns) -> Self {
        let names: Vec<String> = columns.names().map(|name| name.trim().to_owned()).collect();
        let first = (columns.rows() > 0)
            .then(|| (0..names.len()).map(|column| columns.texts(column).get(0).to_owned()).collect());
        Self { names, separator: b',', first, columns: Some(columns), ..Self::default() }
    }

    fn parse(&mut self) -> Result<(), &'static str> {
        let marks = if self.text.bytes.starts_with(BYTE_ORDER_MARK) { BYTE_ORDER_MARK.len() } else { 0 };
        let named = named_separator(&self.text.bytes[marks..]);
        if named.is_some() {
            // The line stays, so that the others keep their numbers.
            self.text.bytes.drain(..marks + SEPARATOR_LINE);
        }
        let text = self.text.bytes.strip_prefix(BYTE_ORDER_MARK).unwrap_or(&self.text.bytes);
        if text.iter().all(u8::is_ascii_whitespace) {
            return Err("the file is empty; expected a header row");
        }
        if is_packed(text) {
            return Err("is a compressed file or an old spreadsheet; expected CSV, .csv.gz or .xlsx: export it as CSV");
        }
        if text.trim_ascii_start().starts_with(b"{") || text.trim_ascii_start().starts_with(b"[") {
            return Err("is JSON; expected CSV, .csv.gz or .xlsx: export it as CSV");
        }
        let mut lines = text.split(|byte| matches!(byte, b'\r' | b'\n')).filter(|line| !line.is_empty());
        let line = lines.next().unwrap_or_default();
        if line.contains(&0) {
            return Err("is not a CSV file: its first line contains zero bytes; expected a header row");
        }
        // A title has no separator.
        let with_cells = |line: &&[u8]| line.iter().any(|byte| b",;\t|".contains(byte));
        let head_line = std::iter::once(line).chain(lines.take(MAX_LABELS)).find(with_cells).unwrap_or_default();
        self.separator = named.unwrap_or_else(|| separator(head_line));
        let (mut rows, mut line) = (Vec::new(), 1);
        rows_from(self.content(), self.separator, None, |row| {
            if rows.is_empty() {
                line = row.place(0).0;
            }
            rows.push(row.record.iter().map(|cell| decoded(cell).trim().to_owned()).collect::<Vec<_>>());
            rows.len() < 2 + MAX_LABELS
        });
        let mut rows = rows.into_iter();
        (self.line, self.names) = (line, rows.next().unwrap_or_default());
        let below = rows.as_slice();
        // Qualtrics has two rows of labels.
        if below.get(1).is_some_and(|row| row.iter().any(|cell| cell.starts_with("{\"ImportId\""))) {
            self.labels = MAX_LABELS;
        }
        let texts = |row: &Vec<String>| row.iter().filter(|cell| !cell.is_empty()).count();
        self.is_title = texts(&self.names) < 2 && below.iter().any(|row| texts(row) > 1);
        // R has no name for its row numbers, and other programs none for what follows the last separator.
        if below.len() > 1 && below.iter().all(|row| row.len() == self.names.len() + 1) {
            if below.iter().all(|row| row.last().is_some_and(String::is_empty)) {
                self.names.push(String::new());
            } else if (1..).zip(below).all(|(number, row)| row[0] == number.to_string()) {
                self.names.insert(0, String::new());
            }
        }
        let mut rows = rows.skip(self.labels);
        self.first = rows.next();
        Ok(())
    }

    /// Returns the content of the file.
    pub fn content(&self) -> Content<'_> {
        Content { bytes: &self.text.bytes, is_sheet: self.text.is_sheet }
    }

    /// Returns the index of a column, the first one with this name.
    pub fn position(&self, name: &str) -> Option<usize> {
        self.positions(name).next()
    }

    /// Returns the indices of all columns with a name.
    pub fn positions<'a>(&'a self, name: &'a str) -> impl Iterator<Item = usize> + 'a {
        (0..self.names.len()).filter(move |index| self.names[*index] == name)
    }

    /// Returns the column with the participants if none is named: [`SUBJECT`], or the only one with a usual name.
    pub fn subject(&self) -> Option<&str> {
        let mut usual = self.names.iter().filter(|name| SUBJECTS.contains(&name.to_lowercase().as_str()));
        match (usual.next(), usual.next()) {
            _ if self.position(SUBJECT).is_some() => Some(SUBJECT),
            (Some(one), None) => Some(one),
            _ => None,
        }
    }

    /// Says that the participants are in this column of the file `name`, which was not named, unless it is [`SUBJECT`].
    pub fn note_of_subject(&self, name: &str, index: usize) -> Option<FileError> {
        let column = Some(&self.names[index]).filter(|column| *column != SUBJECT)?;
        let message = format!("participants are in the column {column}; expected {SUBJECT}, or a column that you name");
        Some(self.error(name, index, message))
    }

    /// Creates an error in the header of the file `name`, at the name with this index.
    pub fn error(&self, name: &str, index: usize, message: String) -> FileError {
        if self.columns.is_some() {
            return FileError::whole(name, message);
        } else if self.text.is_sheet {
            return FileError::at(name, (self.line, index + 1), message);
        }
        let column = self.names.iter().take(index).map(|name| name.chars().count() + 1).sum::<usize>() + 1;
        FileError::at(name, (self.line, column), message)
    }
}

/// Number of bytes of Excel's line `sep=;`.
const SEPARATOR_LINE: usize = 5;

/// Returns the separator that this line names, if it is the first.
fn named_separator(text: &[u8]) -> Option<u8> {
    let (line, rest) = text.split_at_checked(SEPARATOR_LINE)?;
    let is_line = line[..4].eq_ignore_ascii_case(b"sep=") && (rest.starts_with(b"\n") || rest.starts_with(b"\r\n"));
    Some(line[4]).filter(|separator| is_line && separator.is_ascii())
}

/// True if a file begins like a compressed file (gzip, bzip2, xz, Zstandard, zip) or a spreadsheet.
fn is_packed(head: &[u8]) -> bool {
    let kinds: [&[u8]; 6] =
        [b"\x1f\x8b", b"BZh91AY", b"\xfd7zXZ\0", b"\x28\xb5\x2f\xfd", b"PK\x03\x04", b"\xd0\xcf\x11\xe0"];
    kinds.iter().any(|first| head.starts_with(first))
}

/// The content of a file as text in UTF-8.
#[derive(Clone, Debug, Default)]
pub(super) struct Converted {
    pub bytes: Vec<u8>,
    /// What a user should know about how the file was read, and what was expected.
    pub note: Option<[String; 2]>,
    /// Whether it is the sheet of a workbook.
    pub is_sheet: bool,
    /// Row and column, counted from 0, of each cell of a sheet that has no exact value, and what is wrong.
    pub unusable: Vec<(usize, usize, &'static str)>,
}

/// Converts a file to text: unpacks gzip, takes the first sheet of an Excel workbook, decodes UTF-16, and replaces carriage
/// returns, with which old spreadsheets end lines, because lines are counted by their line feeds.
///
/// # Errors
/// The file cannot be unpacked, or it is too large.
fn converted(bytes: Vec<u8>) -> Result<Converted, String> {
    let mut converted = Converted { bytes, ..Converted::default() };
    let is_packed = [b"\x1f\x8b".as_slice(), b"PK\x03\x04"].iter().any(|first| converted.bytes.starts_with(first));
    if is_packed && converted.bytes.len() as u64 > MAX_UNPACKED {
        return Err(format!("has {} bytes; expected at most {MAX_UNPACKED}, or CSV", converted.bytes.len()));
    } else if converted.bytes.starts_with(b"\x1f\x8b") {
        converted.bytes = unpacked(MultiGzDecoder::new(&converted.bytes[..]), MAX_UNPACKED)?;
    } else if is_packed {
        converted = first_sheet(&converted.bytes)?;
    }
    if let Some((encoding, _)) = Encoding::for_bom(&converted.bytes)
        && encoding != UTF_8
    {
        converted.bytes = encoding.decode(&converted.bytes).0.into_owned().into_bytes();
    }
    if converted.bytes.contains(&b'\r') && !converted.bytes.contains(&b'\n') {
        converted.bytes.iter_mut().filter(|byte| **byte == b'\r').for_each(|byte| *byte = b'\n');
    }
    Ok(converted)
}

/// Number of columns of a sheet in Excel.
const MAX_COLUMNS: u32 = 16_384;

/// Whole numbers below this are exact in a workbook.
const EXACT: f64 = (1_u64 << 53) as f64;

/// Returns the first sheet as CSV with commas. Line numbers are those of the sheet, and every row has as many cells as the
/// first one that is not empty.
///
/// # Errors
/// Says what is wrong and what is expected.
fn first_sheet(file: &[u8]) -> Result<Converted, String> {
    check_size(file)?;
    // calamine does not check all that it calculates with, such as the row in the name of a cell.
    let read = std::panic::catch_unwind(|| read(file));
    read.unwrap_or_else(|_| Err("is a damaged workbook; expected an Excel workbook (.xlsx), or CSV".to_owned()))
}

fn read(file: &[u8]) -> Result<Converted, String> {
    let unreadable =
        |error: &dyn std::fmt::Display| format!("is not an Excel workbook (.xlsx): {error}; expected one, or CSV");
    let mut workbook = Xlsx::new(Cursor::new(file)).map_err(|error| unreadable(&error))?;
    let names = workbook.sheet_names();
    let is_visible = |name: &&String| {
        workbook.sheets_metadata().iter().any(|sheet| sheet.name == **name && sheet.visible == SheetVisible::Visible)
    };
    let name = names.iter().find(is_visible).or(names.first()).ok_or_else(|| unreadable(&"it has no sheets"))?.clone();
    let mut cells = workbook.worksheet_cells_reader(&name).map_err(|error| unreadable(&error))?;
    let (mut bytes, mut row, mut width, mut at) = (Vec::new(), Vec::<String>::new(), 0, 0);
    let (mut characters, mut unusable) = (0, Vec::new());
    let limited = |size: usize| match size as u64 > MAX_UNPACKED {
        true => Err(format!("the sheet has more than {MAX_UNPACKED} bytes as CSV; expected fewer")),
        false => Ok(()),
    };
    let mut end_row = |row: &mut Vec<String>| {
        width = if width == 0 { row.len() } else { width };
        if row.is_empty() {
            bytes.push(b'\n');
        } else {
            row.resize(row.len().max(width), String::new());
            bytes.extend(line(row.drain(..)));
        }
        limited(bytes.len())
    };
    // The formulas are not asked for as a range, which has a place for every cell between the first and the last one.
    while let Some(cell) = cells.next_cell_with_formula_metadata().map_err(|error| unreadable(&error))? {
        let ((found, column), text) = (cell.pos, text(&cell.value.clone().into()));
        let problem = match cell.value {
            DataRef::Float(number) if number.abs() >= EXACT => {
                Some("is a number of 2^53 or more, whose last digits a workbook does not keep; expected text")
            }
            DataRef::Empty if cell.formula.is_some() => {
                Some("is a formula without a value; expected the value, which a spreadsheet program stores with it")
            }
            _ => None,
        };
        unusable.extend(problem.map(|problem| (found as usize, column as usize, problem)));
        if text.is_empty() {
            continue;
        }
        if found < at || found == at && (column as usize) < row.len() || column >= MAX_COLUMNS {
            return Err(unreadable(&"its cells are not in order, or one has no place in a sheet"));
        }
        // Many cells can share one long text.
        characters += text.len();
        limited(characters)?;
        (at..found).try_for_each(|_| end_row(&mut row))?;
        at = found;
        row.resize(column as usize, String::new());
        row.push(text);
    }
    end_row(&mut row)?;
    let note = (names.len() > 1).then(|| {
        let others = list(names.iter().filter(|other| **other != name));
        [format!("only the sheet {name} was read"), format!("expected one sheet (the others were ignored: {others})")]
    });
    Ok(Converted { bytes, note, is_sheet: true, unusable })
}

/// Returns the text of a cell: a date, a time of day or both as in ISO 8601, and a duration in hours, minutes and seconds.
fn text(cell: &Data) -> String {
    const DATES: Range<f64> = 0.0..2_958_466.0;
    let Data::DateTime(moment) = cell else { return cell.to_string() };
    let (days, (year, month, day, hour, minute, second, milli)) = (moment.as_f64(), moment.to_ymd_hms_milli());
    let date = format!("{year}-{month:02}-{day:02}");
    let part = if milli == 0 { String::new() } else { format!(".{milli:03}") };
    let time = format!("{minute:02}:{second:02}{part}");
    match hour {
        _ if !DATES.contains(&days) => days.to_string(),
        _ if moment.is_duration() => format!("{}:{time}", (24.0 * days + 1e-7).floor()),
        _ if days < 1.0 => format!("{hour:02}:{time}"),
        0 if time == "00:00" => date,
        _ => format!("{date}T{hour:02}:{time}"),
    }
}

/// Checks that a workbook does not unpack to too many bytes. calamine unpacks without a limit.
fn check_size(file: &[u8]) -> Result<(), String> {
    let broken = |error| format!("cannot be unpacked: {error}; expected an Excel workbook (.xlsx), or CSV");
    let mut archive = ZipArchive::new(Cursor::new(file)).map_err(broken)?;
    if archive.index_for_name("mimetype").is_some() {
        return Err("is an OpenDocument file; expected an Excel workbook (.xlsx), or CSV: save it as one".to_owned());
    }
    let mut left = MAX_UNPACKED;
    for index in 0..archive.len() {
        left -= unpacked(archive.by_index(index).map_err(broken)?, left)?.len() as u64;
    }
    Ok(())
}
