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
