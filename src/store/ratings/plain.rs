//! The plain reader: the csv crate, row by row. It takes everything that is CSV, and the fast reader is held against
//! it.

use std::io::Read as _;

use super::{
    header::count_lines,
    plan::Input,
    record::{Record, Unquoted},
    source::open,
};

/// Bytes read at a time.
const BLOCK: usize = 1 << 20;
/// A row that is longer has a quote that was never closed.
const LONGEST_ROW: usize = 1 << 20;

/// Hands on every row of a file; gives the lines below its header.
///
/// # Errors
/// The file cannot be read.
pub(super) fn each(input: &Input, mut take: impl FnMut(&Record<'_>)) -> std::io::Result<u64> {
    let mut reader = open(input, input.header.end)?;
    let mut block = Block {
        separator: input.header.separator,
        text: Vec::new(),
        offset: input.header.end,
        line: 0,
        ended: false,
        cells: Unquoted::default(),
    };
    loop {
        let before = block.text.len();
        reader.by_ref().take(BLOCK as u64).read_to_end(&mut block.text)?;
        block.ended = block.text.len() - before < BLOCK;
        let mut used = 0;
        // An unclosed quote ends a run before the end of the block.
        while let Some(more) = block.run(used, &mut take) {
            used = more;
        }
        if block.ended {
            return Ok(block.line);
        }
    }
}

/// A part of the file that begins with a row.
struct Block {
    separator: u8,
    text: Vec<u8>,
    /// Where it begins in the file.
    offset: u64,
    /// Lines above it.
    line: u64,
    /// Whether the file ends with it.
    ended: bool,
    cells: Unquoted,
}

impl Block {
    /// Hands on rows from a place on; gives the place after a row whose quote is never closed. At the end of the block
    /// keeps a row that may go on in the next.
    fn run(&mut self, from: usize, take: &mut impl FnMut(&Record<'_>)) -> Option<usize> {
        let Self { separator, text, offset, line, ended, cells } = self;
        let mut reader = csv::ReaderBuilder::new()
            .has_headers(false)
            .flexible(true)
            .delimiter(*separator)
            .from_reader(&text[from..]);
        let mut record = csv::ByteRecord::new();
        let mut used = from;
        while let Ok(true) = reader.read_byte_record(&mut record) {
            let begin = used + text[used..].iter().take_while(|byte| is_end(**byte)).count();
            let mut end = from + reader.position().byte() as usize;
            // The second half of `\r\n` is left for the next row.
            if text[end - 1] == b'\r' && text.get(end) == Some(&b'\n') {
                end += 1;
            }
            let mut open = end == text.len() && is_open(&text[begin..end], *separator);
            let cut = end == text.len() && (open || text[end - 1] != b'\n');
            if cut && !*ended && end - begin < LONGEST_ROW {
                break;
            }
            // A quote that is never closed would swallow all that follows: its own line is faulty, not they.
            let line_end = memchr::memchr(b'\n', &text[begin..end]).map_or(end, |newline| begin + newline + 1);
            open &= line_end < end;
            if open {
                end = line_end;
            }
            let raw = without_end(&text[begin..end]);
            let is_text = match std::str::from_utf8(raw) {
                Ok(raw) if open => {
                    cells.split(raw, *separator);
                    true
                }
                _ => cells.set(record.iter().map(|cell| std::str::from_utf8(cell).ok())),
            };
            take(&Record {
                line: *line + count_lines(&text[used..begin]),
                offset: *offset + begin as u64,
                raw,
                cells: is_text.then(|| cells.cells()),
                last: *ended && text[end..].iter().all(|byte| is_end(*byte)),
                terminated: end - begin > raw.len(),
            });
            *line += count_lines(&text[used..end]);
            used = end;
            if open {
                return Some(used);
            }
        }
        if *ended {
            *line += count_lines(&text[used..]);
        }
        text.drain(..used);
        *offset += used as u64;
        None
    }
}

fn is_end(byte: u8) -> bool {
    matches!(byte, b'\r' | b'\n')
}

fn is_open(row: &[u8], separator: u8) -> bool {
    !Unquoted::default().split(&String::from_utf8_lossy(row), separator)
}

fn without_end(row: &[u8]) -> &[u8] {
    let row = row.strip_suffix(b"\n").unwrap_or(row);
    row.strip_suffix(b"\r").unwrap_or(row)
}
