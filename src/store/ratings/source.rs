//! Files as parts that can be read side by side.

use std::{
    fs::File,
    io::{Read, Seek as _, SeekFrom},
    ops::Range,
};

use super::{fast, header::Content, plain, plan::Input, record::Record};

/// A part of a file: the rows whose first byte is in the range.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Segment {
    /// Index of the file.
    pub file: usize,
    pub bytes: Range<u64>,
}

/// Why a part was not read.
#[derive(Debug)]
pub(super) enum Stop {
    /// It has what only the plain reader knows.
    Odd,
    /// The system's reason.
    Io(std::io::Error),
}

impl From<std::io::Error> for Stop {
    fn from(error: std::io::Error) -> Self {
        Self::Io(error)
    }
}

/// The content of a file from a place on.
pub(super) fn open(input: &Input, from: u64) -> std::io::Result<Box<dyn Read + '_>> {
    match &input.header.content {
        Content::Memory(content) => Ok(Box::new(content.get(from as usize..).unwrap_or_default())),
        Content::File => {
            let mut file = File::open(&input.path)?;
            file.seek(SeekFrom::Start(from))?;
            Ok(Box::new(file))
        }
    }
}

/// Hands on every row of a part; gives its lines.
///
/// # Errors
/// The file cannot be read, or not by the fast reader.
pub(super) fn each(input: &Input, bytes: &Range<u64>, odd: bool, take: impl FnMut(&Record<'_>)) -> Result<u64, Stop> {
    if odd { Ok(plain::each(input, take)?) } else { fast::each(input, bytes, take) }
}

/// Work for one thread after another: consecutive parts of about the same size together, in the order of the files. A
/// file that only the plain reader knows is one part.
pub(super) fn tasks(inputs: &[&Input], odd: &[bool], least: u64) -> Vec<Vec<Segment>> {
    let rows = |input: &Input| input.header.size.saturating_sub(input.header.end);
    let total: u64 = inputs.iter().map(|input| rows(input)).sum();
    let share = (total / (4 * rayon::current_num_threads() as u64)).max(least);
    let mut tasks: Vec<Vec<Segment>> = Vec::new();
    let mut open = 0;
    for (file, input) in inputs.iter().enumerate() {
        let parts = if odd[file] { 1 } else { (rows(input) / share).max(1) };
        let place =
            |part: u64| input.header.end + (u128::from(rows(input)) * u128::from(part) / u128::from(parts)) as u64;
        for part in 0..parts {
            // A file may grow meanwhile: its last part has all that is there now.
            let bytes = place(part)..if part + 1 == parts { u64::MAX } else { place(part + 1) };
            let size = place(part + 1) - place(part);
            match tasks.last_mut() {
                Some(task) if open + size <= share => {
                    task.push(Segment { file, bytes });
                    open += size;
                }
                _ => {
                    tasks.push(vec![Segment { file, bytes }]);
                    open = size;
                }
            }
        }
    }
    tasks
}

#[cfg(test)]
mod tests {
    use std::path::PathBuf;

    use proptest::prelude::*;

    use super::*;
    use crate::store::ratings::{Layout, header::Header, plan::Columns};

    fn input(text: &[u8]) -> Input {
        let header = Header::parse(text, text.len() as u64, Content::Memory(text.into())).unwrap();
        let columns = Columns::default();
        let (path, name) = (PathBuf::from("x"), "x".to_owned());
        Input { path, name, header, layout: Layout::Long, columns, sidecar: None, planned: None }
    }

    /// Everything that a reader says of a row, its line counted from the header.
    type Row = (u64, u64, Vec<u8>, Option<Vec<String>>, bool, bool);

    fn row(record: &Record<'_>, above: u64) -> Row {
        let cells = record.cells.map(|cells| (0..cells.len()).map(|i| cells.get(i).to_owned()).collect());
        (record.line + above, record.offset, record.raw.to_vec(), cells, record.last, record.terminated)
    }

    /// The rows of all parts by the fast reader; none where it refuses.
    fn fast_rows(input: &Input, cuts: &[u64]) -> Option<(Vec<Row>, u64)> {
        let (mut rows, mut lines) = (Vec::new(), 0);
        let mut places: Vec<u64> = cuts.iter().map(|cut| cut % (input.header.size + 1)).collect();
        places.retain(|place| *place > input.header.end);
        places.extend([input.header.end, u64::MAX]);
        places.sort_unstable();
        for part in places.windows(2) {
            lines += each(input, &(part[0]..part[1]), false, |record| rows.push(row(record, lines))).ok()?;
        }
        Some((rows, lines))
    }

    fn piece(quotes: u32, ends: u32) -> impl Strategy<Value = &'static [u8]> {
        let plain: &[&[u8]] = &[b",", b",", b"\n", b"\n", b"a", b"1.5", b" ", b"long cell of some length", b"\xc3\xa9"];
        let quoted: &[&[u8]] = &[b"\"", b"\"\"", b"\n\"", b",\"", b"\",", b"\"\n"];
        let odd: &[&[u8]] = &[b"\r\n", b"\r\n", b"\r\n\r\n", b"\r", b"\xff", b"\0"];
        prop_oneof![
            30 => proptest::sample::select(plain),
            quotes => proptest::sample::select(quoted),
            ends => proptest::sample::select(odd),
        ]
    }

    fn text() -> impl Strategy<Value = Vec<u8>> {
        let kinds = prop_oneof![Just((0, 0)), Just((0, 4)), Just((3, 0)), Just((12, 1)), Just((3, 3))];
        let body = kinds.prop_flat_map(|(quotes, ends)| proptest::collection::vec(piece(quotes, ends), 0..120));
        body.prop_map(|body| [b"a,b\n".to_vec(), body.concat()].concat())
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(4000))]

        /// Of any text, cut anywhere into parts, the fast reader reads what the plain one does, or refuses; and it
        /// refuses only for a quote or a `\r`.
        #[test]
        fn the_fast_reader_reads_what_the_plain_one_does(
            text in text(),
            cuts in proptest::collection::vec(any::<u64>(), 0..4),
        ) {
            let input = input(&text);
            let mut rows = Vec::new();
            let lines = plain::each(&input, |record| rows.push(row(record, 0))).unwrap();
            match fast_rows(&input, &cuts) {
                Some(fast) => prop_assert_eq!(fast, (rows, lines)),
                None => prop_assert!(text.iter().any(|byte| matches!(byte, b'"' | b'\r'))),
            }
        }
    }

    #[test]
    fn parts_cover_every_file_once_in_order() {
        let files: Vec<Input> =
            [10_000, 5, 0, 90_000, 300].map(|n| input(&[&b"a,b\n"[..], &vec![b'x'; n]].concat())).into();
        let inputs: Vec<&Input> = files.iter().collect();
        for least in [1, 1000, 1_000_000] {
            let tasks = tasks(&inputs, &[false, false, false, false, true], least);
            let parts: Vec<Segment> = tasks.concat();
            for (file, input) in inputs.iter().enumerate() {
                let own: Vec<&Segment> = parts.iter().filter(|part| part.file == file).collect();
                assert_eq!((own[0].bytes.start, own.last().unwrap().bytes.end), (input.header.end, u64::MAX));
                assert!(own.windows(2).all(|pair| pair[0].bytes.end == pair[1].bytes.start));
            }
            assert!(parts.is_sorted_by_key(|part| part.file));
            assert_eq!(least == 1_000_000, tasks.len() == 1);
        }
    }
}
