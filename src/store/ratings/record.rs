//! One row of a CSV file, in place: its text is the file's, its cells are found by where they end.

/// A row as a reader hands it on.
#[derive(Clone, Copy, Debug)]
pub(super) struct Record<'a> {
    /// Lines of the part of the file above the row; 0 for its first line.
    pub line: u64,
    /// Where the row begins in the file, bytes. No two rows have the same.
    pub offset: u64,
    /// The row as it is in the file, without its end of line.
    pub raw: &'a [u8],
    /// Its cells; none where it is not UTF-8.
    pub cells: Option<Cells<'a>>,
    /// Whether this is the last row of the file.
    pub last: bool,
    /// Whether an end of line follows it.
    pub terminated: bool,
}

/// Cells without their quotes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cells<'a> {
    /// Where they stand, one byte between every two.
    pub text: &'a str,
    /// Where the first begins.
    pub start: u32,
    /// Where each ends.
    pub ends: &'a [u32],
}

impl<'a> Cells<'a> {
    /// How many.
    pub fn len(&self) -> usize {
        self.ends.len()
    }

    /// A cell, without white space around it; empty where there is none.
    pub fn get(&self, index: usize) -> &'a str {
        let start = if index == 0 { self.start as usize } else { self.ends[index - 1] as usize + 1 };
        let cell = self.text.get(start..self.ends[index] as usize).unwrap_or_default();
        let is_space = |byte: Option<&u8>| byte.is_some_and(|byte| *byte <= b' ' || *byte >= 0x80);
        // Almost no cell needs the search for white space.
        if is_space(cell.as_bytes().first()) || is_space(cell.as_bytes().last()) { cell.trim() } else { cell }
    }
}

/// Column in characters, from 1, at which a cell of a row begins; of a row with line breaks, counted on its last line.
pub(super) fn column(raw: &[u8], separator: u8, index: usize) -> usize {
    let mut unquoted = Unquoted::default();
    unquoted.split(&String::from_utf8_lossy(raw), separator);
    let before = &unquoted.starts.get(index).map_or(&[][..], |&start| &raw[..start.min(raw.len())]);
    let line = before.iter().rposition(|byte| *byte == b'\n').map_or(0, |newline| newline + 1);
    String::from_utf8_lossy(&before[line..]).chars().count() + 1
}

/// A row with quotes, split by the rules of the plain reader.
#[derive(Debug, Default)]
pub(super) struct Unquoted {
    text: String,
    ends: Vec<u32>,
    starts: Vec<usize>,
}

impl Unquoted {
    /// Splits a row; gives whether its last quote is closed; what is open is its last cell. A quote counts only where a cell begins with it; within
    /// quotes two stand for one; after the closing one anything up to the separator belongs to the cell.
    pub fn split(&mut self, raw: &str, separator: u8) -> bool {
        self.text.clear();
        self.ends.clear();
        self.starts.clear();
        let bytes = raw.as_bytes();
        let mut at = 0;
        loop {
            self.starts.push(at);
            if bytes.get(at) == Some(&b'"') {
                at += 1;
                loop {
                    let Some(length) = memchr::memchr(b'"', &bytes[at..]) else {
                        self.text.push_str(&raw[at..]);
                        self.ends.push(self.text.len() as u32);
                        return false;
                    };
                    self.text.push_str(&raw[at..at + length]);
                    at += length + 1;
                    if bytes.get(at) != Some(&b'"') {
                        break;
                    }
                    self.text.push('"');
                    at += 1;
                }
            }
            let length = memchr::memchr(separator, &bytes[at..]);
            let end = length.map_or(bytes.len(), |length| at + length);
            self.text.push_str(&raw[at..end]);
            self.ends.push(self.text.len() as u32);
            if length.is_none() {
                return true;
            }
            self.text.push(' ');
            at = end + 1;
        }
    }

    /// Takes the cells of a row that was split elsewhere; gives whether all of them are texts.
    pub fn set<'a>(&mut self, cells: impl Iterator<Item = Option<&'a str>>) -> bool {
        self.text.clear();
        self.ends.clear();
        for cell in cells {
            let Some(cell) = cell else { return false };
            if !self.ends.is_empty() {
                self.text.push(' ');
            }
            self.text.push_str(cell);
            self.ends.push(self.text.len() as u32);
        }
        true
    }

    /// The cells of the last row.
    pub fn cells(&self) -> Cells<'_> {
        Cells { text: &self.text, start: 0, ends: &self.ends }
    }
}
