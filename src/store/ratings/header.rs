//! The head of a file: what separates its cells, and what its columns are called.

use std::{fs::File, io::Read as _, path::Path, sync::Arc};

use super::{FileFault, discovery::whole};

/// A header row, and the row below it, end within this many bytes.
const LONGEST: u64 = 1 << 20;

/// Where the rows of a file come from.
#[derive(Clone, Debug)]
pub(super) enum Content {
    /// A file, read as often as need be.
    File,
    /// What a pipe gave, once.
    Memory(Arc<[u8]>),
}

/// The head of a file.
#[derive(Clone, Debug)]
pub(super) struct Header {
    /// Names of the columns.
    pub names: Vec<String>,
    /// Between cells: a comma, a semicolon or a tab.
    pub separator: u8,
    /// Where the rows begin, bytes.
    pub end: u64,
    /// Lines up to there.
    pub lines: u64,
    /// The cells of the first row, if there is one.
    pub first: Option<Vec<String>>,
    /// Bytes of the whole file.
    pub size: u64,
    /// Where they are.
    pub content: Content,
}

impl Header {
    /// Reads the head of a file.
    ///
    /// # Errors
    /// Not readable, empty, no text in UTF-8.
    pub fn read(path: &Path) -> Result<Self, FileFault> {
        let unreadable =
            |error: std::io::Error| whole(path, format!("cannot be read: {error}; expected a readable CSV file"));
        let metadata = std::fs::metadata(path).map_err(unreadable)?;
        let mut file = File::open(path).map_err(unreadable)?;
        let mut head = Vec::new();
        let (size, content) = if metadata.is_file() {
            file.take(LONGEST).read_to_end(&mut head).map_err(unreadable)?;
            (metadata.len().max(head.len() as u64), Content::File)
        } else {
            // A pipe can be read once only, and result files are read twice.
            let mut all = Vec::new();
            file.read_to_end(&mut all).map_err(unreadable)?;
            head.extend_from_slice(&all[..all.len().min(LONGEST as usize)]);
            (all.len() as u64, Content::Memory(all.into()))
        };
        Self::parse(&head, size, content)
            .map_err(|(column, message)| FileFault { position: Some((1, column)), ..whole(path, message) })
    }

    pub(super) fn parse(head: &[u8], size: u64, content: Content) -> Result<Self, (usize, String)> {
        let fault = |message: &str| Err((1, message.to_owned()));
        if head.starts_with(&[0xff, 0xfe]) || head.starts_with(&[0xfe, 0xff]) {
            return fault("is UTF-16 text; expected CSV in UTF-8");
        }
        let bom = if head.starts_with(&[0xef, 0xbb, 0xbf]) { 3 } else { 0 };
        let text = &head[bom..];
        if text.iter().all(u8::is_ascii_whitespace) {
            return fault("the file is empty; expected a header row");
        }
        let begin = text.iter().position(|byte| !matches!(byte, b'\r' | b'\n')).unwrap_or(0);
        let line = text[begin..].split(|byte| matches!(byte, b'\r' | b'\n')).next().unwrap_or_default();
        if line.contains(&0) {
            return fault("is no CSV file: there are zero bytes in its first line; expected a header row");
        }
        if let Err(error) = std::str::from_utf8(line) {
            let column = String::from_utf8_lossy(&line[..error.valid_up_to()]).chars().count() + 1;
            return Err((column, "the header is not UTF-8 text; expected CSV in UTF-8".to_owned()));
        }
        let separator = separator(line);
        let mut reader = csv::ReaderBuilder::new()
            .has_headers(false)
            .flexible(true)
            .delimiter(separator)
            .from_reader(&text[begin..]);
        let mut record = csv::ByteRecord::new();
        let mut next = || match reader.read_byte_record(&mut record) {
            Ok(true) => {
                let cells = record.iter().map(|cell| String::from_utf8_lossy(cell).trim().to_owned());
                Some((cells.collect::<Vec<_>>(), reader.position().byte() as usize))
            }
            _ => None,
        };
        let Some((names, end)) = next() else { return fault("has no header row; expected the names of the columns") };
        let end = bom + begin + end;
        if end == head.len() && (head.len() as u64) < size {
            return fault("the first row has more than a million bytes; expected a header row");
        }
        let lines = count_lines(&head[..end]);
        Ok(Self { names, separator, end: end as u64, lines, first: next().map(|(cells, _)| cells), size, content })
    }

    /// Index of a column.
    pub fn position(&self, name: &str) -> Option<usize> {
        self.names.iter().position(|known| known == name)
    }

    /// Column in characters, from 1, at which the name at an index begins.
    pub fn column(&self, index: usize) -> usize {
        self.names.iter().take(index).map(|name| name.chars().count() + 1).sum::<usize>() + 1
    }
}

/// Ends of lines: `\n`, `\r\n`, and a `\r` by itself.
pub(super) fn count_lines(text: &[u8]) -> u64 {
    let newlines = memchr::memchr_iter(b'\n', text).count();
    let alone = memchr::memchr_iter(b'\r', text).filter(|&i| text.get(i + 1) != Some(&b'\n')).count();
    (newlines + alone) as u64
}

/// A comma; where a header has none, the semicolon or tab that spreadsheets of some countries write.
fn separator(line: &[u8]) -> u8 {
    let count = |wanted: u8| line.iter().filter(|byte| **byte == wanted).count();
    if count(b',') > 0 || count(b';') + count(b'\t') == 0 {
        b','
    } else if count(b';') >= count(b'\t') {
        b';'
    } else {
        b'\t'
    }
}
