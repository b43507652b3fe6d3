//! CSV tables in which each row has a line number and each cell has a column.

use std::{borrow::Cow, collections::BTreeSet, io::Cursor};

use csv::{ByteRecord, Position};

use super::{FileError, FileErrors};

/// The byte order mark with which some programs begin a file.
pub(super) const BYTE_ORDER_MARK: &[u8] = &[0xef, 0xbb, 0xbf];

/// An error in a row: the index of the cell, and a message that says what is wrong and what is expected.
pub(super) type CellError = (usize, String);

/// The bytes of a table.
#[derive(Clone, Copy, Debug)]
pub(super) struct Content<'a> {
    pub bytes: &'a [u8],
    /// Whether they were a sheet of a workbook, so that the column of a place is that of the sheet.
    pub is_sheet: bool,
}

/// A row, not yet validated.
pub(super) struct Row<'a> {
    /// The cells as bytes.
    pub record: &'a ByteRecord,
    content: Content<'a>,
    pub separator: u8,
    /// The reader's position before the row, from which it can be read again. There may be line ends between this position and
    /// the row.
    pub start: &'a Position,
    end: usize,
    /// True if nothing follows this row.
    pub last: bool,
}

impl<'a> Row<'a> {
    /// Returns all cells as one text, to be sliced with [`ByteRecord::range`].
    ///
    /// # Errors
    /// The index of the first cell that is not UTF-8.
    pub fn text(&self) -> Result<&'a str, usize> {
        std::str::from_utf8(self.record.as_slice())
            .map_err(|_| self.record.iter().position(|cell| std::str::from_utf8(cell).is_err()).unwrap_or(0))
    }

    /// Returns the bytes of the row, including the line ends before and after it.
    pub fn raw(&self) -> &'a [u8] {
        &self.content.bytes[self.start.byte() as usize..self.end]
    }

    /// Returns the line and column, from 1, of the beginning of a cell or, if the cell is not text, of its first
    /// invalid byte.
    pub fn place(&self, cell: usize) -> (usize, usize) {
        let raw = self.raw();
        let raw = raw.strip_prefix(BYTE_ORDER_MARK).unwrap_or(raw);
        let raw = &raw[..raw.iter().rposition(|byte| !is_line_end(*byte)).map_or(0, |last| last + 1)];
        let mut at = raw.iter().take_while(|byte| is_line_end(**byte)).count();
        // A missing cell is located at the end of its line.
        at += cell_start(&raw[at..], self.separator, cell);
        if let Some(bytes) = self.record.get(cell)
            && let Err(error) = std::str::from_utf8(bytes)
        {
            at += error.valid_up_to();
        }
        let before = &raw[..at.min(raw.len())];
        let line = before.iter().filter(|byte| **byte == b'\n').count();
        let line_start = before.iter().rposition(|byte| is_line_end(*byte)).map_or(0, |end| end + 1);
        let characters = || String::from_utf8_lossy(&before[line_start..]).chars().count();
        let column = if self.content.is_sheet { cell } else { characters() };
        (self.start.line() as usize + line, column + 1)
    }

    /// True if the last cell has an unclosed quote, so that it includes everything up to the end of the file.
    pub fn is_open(&self) -> bool {
        self.last
            && self.record.iter().next_back().is_some_and(|cell| cell.contains(&b'\n'))
            && !self.raw().trim_ascii_end().ends_with(b"\"")
    }

    /// Checks the row of a table with this number of columns. Only the cells in the columns that are used matter.
    ///
    /// # Errors
    /// A quote is not closed, or the number of cells differs from the header's; a cell that is used contains a zero byte, or
    /// is not UTF-8 although it must be.
    pub fn check(&self, used: &BTreeSet<usize>, width: usize, is_utf8: bool) -> Result<(), (Option<usize>, String)> {
        let found = self.record.len();
        if self.is_open() {
            return Err((Some(found - 1), "a quote is never closed; expected a closing quote".to_owned()));
        }
        if found != width {
            let cells = if found == 1 { "cell" } else { "cells" };
            return Err((None, format!("the row has {found} {cells}; expected {width}, as in the header")));
        }
        let first = |is: fn(&[u8]) -> bool| used.iter().copied().find(|cell| self.record.get(*cell).is_some_and(is));
        if self.record.as_slice().contains(&0)
            && let Some(cell) = first(|cell| cell.contains(&0))
        {
            return Err((Some(cell), "the cell contains a zero byte; expected text".to_owned()));
        }
        if self.is_torn() {
            let message =
                "a cell continues after its closing quote, in another line; expected quotes around whole cells";
            return Err((None, message.to_owned()));
        }
        if is_utf8
            && self.text().is_err()
            && let Some(cell) = first(|cell| std::str::from_utf8(cell).is_err())
        {
            return Err((Some(cell), "the cell is not UTF-8 text; expected UTF-8".to_owned()));
        }
        Ok(())
    }

    /// True if a text in quotes that has several lines ends within a cell: a quote that is never closed began it, and the next
    /// one, that of another row, ends it.
    fn is_torn(&self) -> bool {
        let raw = self.raw();
        let mut rest = &raw[raw.iter().take_while(|byte| is_line_end(**byte)).count()..];
        let has_lines = self.record.as_slice().contains(&b'\n');
        has_lines
            && (0..self.record.len()).any(|_| {
                let (quoted, after) = rest.split_at(quoted_end(rest, 0));
                let is_end = |byte: &u8| *byte == self.separator || is_line_end(*byte);
                let length = after.iter().position(is_end).unwrap_or(after.len());
                rest = after.get(length + 1..).unwrap_or_default();
                quoted.contains(&b'\n') && !after[..length].trim_ascii().is_empty()
            })
    }

    /// Returns the position of the next line.
    fn next_line(&self) -> Position {
        let raw = self.raw();
        let before = raw.iter().take_while(|byte| is_line_end(**byte)).count();
        let length = raw[before..].iter().position(|byte| *byte == b'\n').map_or(raw.len(), |end| before + end + 1);
        let lines = raw[..length].iter().filter(|byte| **byte == b'\n').count() as u64;
        let mut next = Position::new();
        next.set_byte(self.start.byte() + length as u64).set_line(self.start.line() + lines);
        next
    }
}

/// Returns a text; if it is not UTF-8, it is Windows-1252, which has a character for every byte.
pub(super) fn decoded(bytes: &[u8]) -> Cow<'_, str> {
    let decoded = || encoding_rs::WINDOWS_1252.decode_without_bom_handling(bytes).0;
    std::str::from_utf8(bytes).map_or_else(|_| decoded(), Cow::from)
}

fn is_line_end(byte: u8) -> bool {
    matches!(byte, b'\r' | b'\n')
}

/// Returns the byte offset where a cell of a row begins. A quote is special only at the beginning of a cell. Within
/// quotes, two quotes stand for one; after the closing quote, everything up to the separator belongs to the cell.
fn cell_start(row: &[u8], separator: u8, cell: usize) -> usize {
    let mut at = 0;
    for _ in 0..cell {
        at = quoted_end(row, at);
        match row[at..].iter().position(|byte| *byte == separator) {
            Some(length) => at += length + 1,
            None => return row.len(),
        }
    }
    at
}

/// Returns the byte offset behind the closing quote of a text that begins here, or this offset if it has no quotes.
fn quoted_end(row: &[u8], mut at: usize) -> usize {
    if row.get(at) == Some(&b'"') {
        at += 1;
        while let Some(length) = row[at..].iter().position(|byte| *byte == b'"') {
            at += length + 1;
            if row.get(at) != Some(&b'"') {
                break;
            }
            at += 1;
        }
    }
    at
}

/// Calls `take` with the rows from a position on, or from the header, as long as it returns true. A quote that is not closed
/// affects only its own line.
pub(super) fn rows_from(
    content: Content<'_>,
    separator: u8,
    from: Option<&Position>,
    mut take: impl FnMut(&Row<'_>) -> bool,
) {
    let mut builder = csv::ReaderBuilder::new();
    builder.has_headers(false).flexible(true).delimiter(separator);
    let mut reader = builder.from_reader(Cursor::new(content.bytes));
    // Reading from memory does not fail.
    let _ = from.map(|from| reader.seek(from.clone()));
    let (mut record, start) = (ByteRecord::new(), Position::new());
    while reader.read_byte_record(&mut record).unwrap_or(false) {
        let end = reader.position().byte() as usize;
        let start = record.position().unwrap_or(&start);
        let row = Row { record: &record, content, separator, start, end, last: end >= content.bytes.len() };
        if !take(&row) {
            break;
        }
        let _ = (row.is_open() || row.is_torn()).then(|| reader.seek(row.next_line()));
    }
}

/// Returns the separator of a table with this header: a comma or, if it has more of them outside quotes, a semicolon or tab, as
/// in spreadsheets from some countries, or a vertical bar.
pub(super) fn separator(header: &[u8]) -> u8 {
    let mut counts = [(b'|', 0), (b'\t', 0), (b';', 0), (b',', 0)];
    let mut quoted = false;
    for byte in header {
        quoted ^= *byte == b'"';
        counts.iter_mut().filter(|(separator, _)| !quoted && separator == byte).for_each(|(_, count)| *count += 1);
    }
    counts.into_iter().max_by_key(|(_, count)| *count).map_or(b',', |(separator, _)| separator)
}

/// Returns a cell with a point in place of a decimal comma. If cells are not separated by commas, a comma in a number is
/// a decimal comma, as in spreadsheets from many countries.
pub(super) fn with_point(text: &str, separator: u8) -> Cow<'_, str> {
    // One comma, so that `1,234,567` stays text.
    if separator != b',' && text.matches(',').count() == 1 {
        let number = text.replace(',', ".");
        if number.parse::<f64>().is_ok() {
            return number.into();
        }
    }
    text.into()
}

/// Reads a small table: `header` checks the first row and returns what `row` needs to read the others, such as the places of
/// columns. Returns that and the rows.
///
/// # Errors
/// Reports an error in the header or every error in the rows, with their lines and columns.
pub(super) fn parse<H, T>(
    file: &str,
    text: &[u8],
    separator: u8,
    header: impl FnOnce(&[&str]) -> Result<H, CellError>,
    mut row: impl FnMut(&H, &[&str]) -> Result<T, CellError>,
) -> Result<(H, Vec<T>), FileErrors> {
    let (mut rows, mut errors, mut header, mut head) = (Vec::new(), Vec::new(), Some(header), None);
    let content = Content { bytes: text, is_sheet: false };
    rows_from(content, separator, None, |found| {
        let mut error = |(cell, message): CellError| errors.push(FileError::at(file, found.place(cell), message));
        let Ok(cells) = found.record.iter().map(std::str::from_utf8).collect::<Result<Vec<&str>, _>>() else {
            error((found.text().err().unwrap_or(0), "the row is not UTF-8 text; expected UTF-8".to_owned()));
            return head.is_some();
        };
        if let Some(check) = header.take() {
            head = check(&cells).map(|head| (head, cells.len())).map_err(error).ok();
        } else if let Some((_, width)) = &head
            && cells.len() != *width
        {
            error((0, format!("the number of cells in the row is {}; expected {width}", cells.len())));
        } else if let Some((head, _)) = &head {
            rows.extend(row(head, &cells).map_err(error));
        }
        head.is_some()
    });
    FileErrors::none(errors)?;
    let empty = || FileErrors::at(file, (1, 1), "the file is empty; expected a header row");
    head.map(|(head, _)| (head, rows)).ok_or_else(empty)
}

/// Checks that a header has these columns.
///
/// # Errors
/// Names the first column that is not the expected one.
pub(super) fn exactly<'a>(header: &[&str], expected: impl Iterator<Item = &'a str>) -> Result<(), CellError> {
    let expected: Vec<&str> = expected.collect();
    let differs = |at: &usize| header.get(*at) != expected.get(*at);
    let Some(at) = (0..expected.len().max(header.len())).find(differs) else { return Ok(()) };
    let told = |names: &[&str], none: &str| {
        names.get(at).map_or_else(|| none.to_owned(), |name| format!("{:?}", shortened(name)))
    };
    let (found, expected) = (told(header, "missing"), told(&expected, "no other column"));
    Err((at, format!("column {} is {found}; expected {expected}", at + 1)))
}

/// Formats one line of CSV. A line break within a cell becomes a space, so that each line is a row.
pub(super) fn line<S: AsRef<str>>(cells: impl IntoIterator<Item = S>) -> Vec<u8> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    let clean = cells.into_iter().map(|cell| cell.as_ref().replace(['\n', '\r'], " "));
    // Writing to memory does not fail, and a single record cannot differ in length from others.
    let _ = writer.write_record(clean.collect::<Vec<_>>());
    writer.into_inner().unwrap_or_default()
}

/// Joins names with commas, as a line of CSV: a name that contains a comma is quoted.
pub fn list<S: AsRef<str>>(names: impl IntoIterator<Item = S>) -> String {
    String::from_utf8_lossy(&line(names)).trim_end().to_owned()
}

/// Names as one text with commas between them; a name with a comma is quoted, as in CSV.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct List(pub Vec<String>);

impl std::fmt::Display for List {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&list(&self.0))
    }
}

impl std::str::FromStr for List {
    type Err = String;

    /// Splits what [`list`] joins; nothing for an empty text. An error says which quote or name is wrong.
    fn from_str(text: &str) -> Result<Self, String> {
        if text.matches('"').count() % 2 == 1 {
            return Err("a quote is never closed; expected names with commas between them".to_owned());
        }
        let mut reader = csv::ReaderBuilder::new();
        let mut reader = reader.has_headers(false).flexible(true).trim(csv::Trim::All).from_reader(text.as_bytes());
        let rows: Vec<csv::StringRecord> = reader.records().filter_map(Result::ok).collect();
        let names: Vec<String> = rows.iter().flatten().map(str::to_owned).collect();
        match names.iter().position(String::is_empty) {
            // CSV quotes the only cell of a row if it is empty.
            Some(_) if names.len() == 1 => Ok(Self::default()),
            Some(index) => Err(format!("name {} is empty; expected names with commas between them", index + 1)),
            None => Ok(Self(names)),
        }
    }
}

crate::text::names::serde_as_text!(List);

/// Returns the beginning of an arbitrary text, short enough for a message.
pub(super) fn shortened(text: &str) -> String {
    const SHOWN: usize = 40;
    let shown: String = text.chars().take(SHOWN).collect();
    if shown.len() < text.len() { shown + "…" } else { shown }
}
