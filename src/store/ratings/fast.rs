//! The fast reader: blocks of whole lines, eight bytes searched at a time, and nothing copied.
//!
//! It takes what almost every file is: lines that are rows. A quoted line break, or a `\r` within a line, it leaves to
//! the plain reader, and it reads the same as that one does from all the rest.

use std::{io::Read, ops::Range};

use super::{
    plan::Input,
    record::{Cells, Record, Unquoted},
    source::{Stop, open},
};

/// Bytes read at a time: within the cache of a core.
const BLOCK: usize = 1 << 18;
/// Length of a line above which it may be none.
const LONGEST_LINE: usize = 1 << 20;

/// Hands on every row whose first byte is in a range; gives the lines from there.
///
/// # Errors
/// The file cannot be read, or has what only the plain reader knows.
pub(super) fn each(input: &Input, bytes: &Range<u64>, mut take: impl FnMut(&Record<'_>)) -> Result<u64, Stop> {
    let inside = bytes.start > input.header.end;
    // The byte before tells whether the first one begins a line.
    let begin = bytes.start - u64::from(inside);
    let mut part = Part {
        separator: input.header.separator,
        offset: begin,
        end: bytes.end,
        line: 0,
        ends: Vec::new(),
        unquoted: Unquoted::default(),
    };
    let mut reader = open(input, begin)?;
    let mut text = vec![0; BLOCK];
    let mut filled = 0;
    let mut skip = inside;
    loop {
        let read = fill(&mut reader, &mut text[filled..])?;
        filled += read;
        let ended = filled < text.len();
        let mut whole = memchr::memrchr(b'\n', &text[..filled]).map_or(0, |newline| newline + 1);
        if ended {
            whole = filled;
        } else if whole == 0 {
            if filled >= LONGEST_LINE {
                return Err(Stop::Odd);
            }
            text.resize(2 * filled, 0);
            continue;
        }
        let mut from = 0;
        if skip {
            from = memchr::memchr(b'\n', &text[..whole]).map_or(whole, |newline| newline + 1);
            part.offset += from as u64;
            skip = false;
        }
        if part.block(&text[from..whole], ended, &mut take)? || ended {
            return Ok(part.line);
        }
        text.copy_within(whole..filled, 0);
        filled -= whole;
    }
}

/// Reads until there is no room, or no more.
fn fill(reader: &mut impl Read, room: &mut [u8]) -> std::io::Result<usize> {
    let mut filled = 0;
    while filled < room.len() {
        match reader.read(&mut room[filled..]) {
            Ok(0) => break,
            Ok(n) => filled += n,
            Err(error) if error.kind() == std::io::ErrorKind::Interrupted => {}
            Err(error) => return Err(error),
        }
    }
    Ok(filled)
}

/// A part of a file, and how far it is read.
struct Part {
    separator: u8,
    /// Where the next block begins in the file.
    offset: u64,
    /// Where the part ends: a row that begins here belongs to the next.
    end: u64,
    /// Lines so far.
    line: u64,
    ends: Vec<u32>,
    unquoted: Unquoted,
}

impl Part {
    /// Hands on the rows of a block of whole lines; gives whether the part ends within it.
    fn block(&mut self, text: &[u8], last: bool, take: &mut impl FnMut(&Record<'_>)) -> Result<bool, Stop> {
        let alone = |i: usize| text.get(i + 1) != Some(&b'\n');
        if memchr::memchr_iter(b'\r', text).any(alone) {
            return Err(Stop::Odd);
        }
        // What follows the last row of the file: ends of lines only.
        let rows_end = text.iter().rposition(|byte| !matches!(byte, b'\r' | b'\n')).map_or(0, |last| last + 1);
        let last_row = if last { rows_end } else { usize::MAX };
        let done = match std::str::from_utf8(text) {
            Ok(plain) if memchr::memchr(b'"', text).is_none() => self.plain(plain, last_row, take),
            Ok(quoted) => self.lines(quoted.as_bytes(), last_row, take)?,
            Err(_) => self.lines(text, last_row, take)?,
        };
        self.offset += text.len() as u64;
        Ok(done)
    }

    /// Rows without quotes.
    fn plain(&mut self, text: &str, last_row: usize, take: &mut impl FnMut(&Record<'_>)) -> bool {
        let bytes = text.as_bytes();
        let mut start = 0;
        let mut ends = std::mem::take(&mut self.ends);
        ends.clear();
        let mut done = false;
        scan(bytes, self.separator, |at| {
            let newline = bytes.get(at).is_none_or(|byte| *byte == b'\n');
            if !newline {
                ends.push(at as u32);
                return true;
            }
            if self.offset + start as u64 >= self.end {
                done = true;
                return false;
            }
            let end = if at > start && bytes[at - 1] == b'\r' { at - 1 } else { at };
            if end > start {
                ends.push(end as u32);
                take(&Record {
                    line: self.line,
                    offset: self.offset + start as u64,
                    raw: &bytes[start..end],
                    cells: Some(Cells { text, start: start as u32, ends: &ends }),
                    last: end >= last_row,
                    terminated: at < bytes.len(),
                });
                ends.clear();
            }
            self.line += u64::from(at < bytes.len());
            start = at + 1;
            true
        });
        self.ends = ends;
        done
    }

    /// Rows some of which have quotes, or are not UTF-8.
    fn lines(&mut self, text: &[u8], last_row: usize, take: &mut impl FnMut(&Record<'_>)) -> Result<bool, Stop> {
        let mut start = 0;
        while start < text.len() {
            if self.offset + start as u64 >= self.end {
                return Ok(true);
            }
            let newline = memchr::memchr(b'\n', &text[start..]);
            let at = newline.map_or(text.len(), |length| start + length);
            let end = if at > start && text[at - 1] == b'\r' { at - 1 } else { at };
            if end > start {
                let raw = &text[start..end];
                let row = std::str::from_utf8(raw).ok();
                if let Some(row) = row
                    && !self.unquoted.split(row, self.separator)
                {
                    return Err(Stop::Odd);
                }
                // Quotes around a line break hide behind other faults too.
                if row.is_none() && raw.contains(&b'"') {
                    return Err(Stop::Odd);
                }
                take(&Record {
                    line: self.line,
                    offset: self.offset + start as u64,
                    raw,
                    cells: row.map(|_| self.unquoted.cells()),
                    last: end >= last_row,
                    terminated: newline.is_some(),
                });
            }
            self.line += u64::from(newline.is_some());
            start = at + 1;
        }
        Ok(false)
    }
}

/// Gives the place of every separator and line end, and that of the end of a text that does not end with one; until
/// told to stop.
fn scan(text: &[u8], separator: u8, mut found: impl FnMut(usize) -> bool) {
    let (words, rest) = text.as_chunks::<8>();
    let (groups, few) = words.as_chunks::<8>();
    for (i, group) in groups.iter().enumerate() {
        let mut mask = (0..8).fold(0, |mask, word| mask | matches(group[word], separator) << (8 * word));
        while mask != 0 {
            if !found(64 * i + mask.trailing_zeros() as usize) {
                return;
            }
            mask &= mask - 1;
        }
    }
    let begin = text.len() - 8 * few.len() - rest.len();
    for (i, byte) in text[begin..].iter().enumerate() {
        if (*byte == separator || *byte == b'\n') && !found(begin + i) {
            return;
        }
    }
    if text.last().is_some_and(|last| *last != b'\n') {
        found(text.len());
    }
}

/// A bit for each of eight bytes that is a separator or ends a line.
fn matches(bytes: [u8; 8], separator: u8) -> u64 {
    const ONES: u64 = 0x0101_0101_0101_0101;
    const LOW: u64 = 0x7f * ONES;
    /// Brings the lowest bits of all bytes together in the highest byte.
    const GATHER: u64 = 0x0102_0408_1020_4080;
    let word = u64::from_le_bytes(bytes);
    // The highest bit of every byte that is not zero; no byte carries into the next.
    let filled = |word: u64| ((word & LOW) + LOW) | word;
    let either = !(filled(word ^ (ONES * u64::from(separator))) & filled(word ^ (ONES * u64::from(b'\n'))));
    (either >> 7 & ONES).wrapping_mul(GATHER) >> 56
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_separator_and_line_end_is_found() {
        let mut text: Vec<u8> = (0..=255).collect();
        text.extend((0..5_000_u32).map(|i| b",\nx;\x8d\xac\x0b-"[(i * i % 31 % 8) as usize]));
        for length in [0, 1, 7, 8, 63, 64, 65, 300, text.len()] {
            let text = &text[..length];
            let mut found = Vec::new();
            scan(text, b',', |at| {
                found.push(at);
                true
            });
            let mut expected: Vec<usize> = (0..length).filter(|&i| matches!(text[i], b',' | b'\n')).collect();
            if text.last().is_some_and(|last| *last != b'\n') {
                expected.push(length);
            }
            assert_eq!(found, expected);
        }
    }
}
