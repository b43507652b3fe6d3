//! The answers of a visual nulling: one CSV file, one row an answer, on disk before the next picture. An answer that is
//! taken back stays, and a row says so.

use std::{
    fs::{File, OpenOptions},
    io::{ErrorKind, Seek as _, SeekFrom, Write as _},
    path::{Path, PathBuf},
};

use super::{FileFault, FileFaults, StoreError, fault::io, file::sync_folder, text};
use crate::display::{
    UnknownChannel,
    matching::{NullingStimulus, Observation, RowField},
};

/// The columns. `event` is `answer` or `taken-back`; `level` counts from 0 in the order of the plan; `lit` of `period`
/// rows, `row_px` pixels thick, have the code `hi`, the others `lo`; `time_s` is the time since the first picture;
/// `seed` the seed of the order.
const COLUMNS: [&str; 14] = [
    "event",
    "trial",
    "channel",
    "level",
    "catch",
    "lit",
    "period",
    "row_px",
    "lo",
    "hi",
    "patch",
    "judgement",
    "time_s",
    "seed",
];

/// Most files of answers beside a profile.
const MOST_FILES: u32 = 10_000;

/// The file of a running procedure. What was given is kept in memory too until it is on disk.
#[derive(Debug)]
pub struct NullingFile {
    path: PathBuf,
    file: File,
    seed: u64,
    content: Vec<u8>,
    on_disk: usize,
}

impl NullingFile {
    /// Creates the file beside the profile `profile`: `left.toml` has `left-nulling.csv`, or `left-nulling-2.csv` where
    /// that exists, and so on. No file is ever replaced.
    ///
    /// # Errors
    /// The system's refusal.
    pub fn create_beside(profile: &Path, seed: u64) -> Result<Self, StoreError> {
        let mut number = 1;
        loop {
            let path = numbered(profile, number);
            match OpenOptions::new().write(true).create_new(true).open(&path) {
                Ok(file) => {
                    let mut made = Self { path, file, seed, content: Vec::new(), on_disk: 0 };
                    made.add(&COLUMNS.map(str::to_owned))?;
                    sync_folder(&made.path)?;
                    return Ok(made);
                }
                Err(error) if error.kind() == ErrorKind::AlreadyExists && number < MOST_FILES => number += 1,
                Err(error) => return Err(io(&path, "create")(error)),
            }
        }
    }

    /// Where it is.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Adds an answer, given `time_s` seconds after the first picture.
    ///
    /// # Errors
    /// The disk refuses; the next call tries again with everything that is not on disk.
    pub fn answer(&mut self, observation: &Observation, time_s: f64) -> Result<(), StoreError> {
        self.event("answer", observation, time_s)
    }

    /// Says that an answer no longer counts.
    ///
    /// # Errors
    /// As [`NullingFile::answer`].
    pub fn take_back(&mut self, observation: &Observation, time_s: f64) -> Result<(), StoreError> {
        self.event("taken-back", observation, time_s)
    }

    fn event(&mut self, event: &str, observation: &Observation, time_s: f64) -> Result<(), StoreError> {
        let NullingStimulus { channel, rows, patch } = observation.stimulus;
        let cells = [
            event.to_owned(),
            observation.trial.to_string(),
            channel.to_string(),
            observation.level.to_string(),
            u8::from(observation.catch).to_string(),
            rows.lit.to_string(),
            rows.period.to_string(),
            rows.row_px.to_string(),
            rows.lo.to_string(),
            rows.hi.to_string(),
            patch.to_string(),
            observation.judgement.to_string(),
            format!("{time_s:.3}"),
            self.seed.to_string(),
        ];
        self.add(&cells)
    }

    /// No cell holds a comma, a quote or a line break.
    fn add(&mut self, cells: &[String; COLUMNS.len()]) -> Result<(), StoreError> {
        self.content.extend(cells.join(",").bytes());
        self.content.push(b'\n');
        // After a failed write the file may hold part of a row: back to what is known to be whole.
        let from = self.on_disk as u64;
        let written = self.file.set_len(from).and_then(|()| self.file.seek(SeekFrom::Start(from)));
        let written = written.and_then(|_| self.file.write_all(&self.content[self.on_disk..]));
        written.and_then(|()| self.file.sync_data()).map_err(io(&self.path, "write"))?;
        self.on_disk = self.content.len();
        Ok(())
    }
}

/// The last file of answers beside a profile, where there is one, and the file that the next answers would go into.
#[must_use]
pub fn beside(profile: &Path) -> (Option<PathBuf>, PathBuf) {
    let (mut last, mut next) = (None, numbered(profile, 1));
    for number in 2..=MOST_FILES {
        if !next.exists() {
            break;
        }
        last = Some(std::mem::replace(&mut next, numbered(profile, number)));
    }
    (last, next)
}

/// The name of a profile's nth file of answers, from 1.
fn numbered(profile: &Path, number: u32) -> PathBuf {
    let stem = profile.file_stem().unwrap_or_default().to_string_lossy();
    let suffix = if number == 1 { String::new() } else { format!("-{number}") };
    profile.with_file_name(format!("{stem}-nulling{suffix}.csv"))
}

/// Reads the answers that count, in the order in which they were given.
///
/// # Errors
/// Every row that does not parse, with its line.
pub fn open(path: &Path) -> Result<Vec<Observation>, FileFaults> {
    parse(&path.display().to_string(), &text::read(path)?)
}

/// Reads the answers that count from a file's text; `file` names it in messages.
///
/// # Errors
/// Every row that does not parse, with its line.
pub fn parse(file: &str, text: &str) -> Result<Vec<Observation>, FileFaults> {
    let mut faults = Vec::new();
    let mut fault = |line: usize, message: String| {
        faults.push(FileFault { file: file.to_owned(), position: Some((line, 1)), message });
    };
    let mut answers: Vec<Observation> = Vec::new();
    let mut lines = text.lines().zip(1..);
    if lines.next().map(|(header, _)| header) != Some(&COLUMNS.join(",")) {
        fault(1, format!("the header is another; expected {}", COLUMNS.join(",")));
        return Err(FileFaults(faults));
    }
    for (line, number) in lines {
        match row(line) {
            Ok(("answer", observation)) => answers.push(observation),
            Ok((_, observation)) if answers.last() == Some(&observation) => _ = answers.pop(),
            Ok(_) => fault(number, "takes back what is not the last answer; expected that one".to_owned()),
            Err(message) => fault(number, message),
        }
    }
    if faults.is_empty() { Ok(answers) } else { Err(FileFaults(faults)) }
}

fn row(line: &str) -> Result<(&str, Observation), String> {
    let cells: Vec<&str> = line.split(',').collect();
    let [event, trial, channel, level, catch, lit, period, row_px, lo, hi, patch, judgement, _, _] = cells[..] else {
        return Err(format!("the row has {} cells; expected {}", cells.len(), COLUMNS.len()));
    };
    if !["answer", "taken-back"].contains(&event) {
        return Err(format!("event {event:?} is not known; expected answer or taken-back"));
    }
    let rows = RowField {
        lit: number("lit", lit)?,
        period: number("period", period)?,
        row_px: number("row_px", row_px)?,
        lo: number("lo", lo)?,
        hi: number("hi", hi)?,
    };
    if rows.lit == 0 || rows.lit >= rows.period || rows.row_px == 0 {
        return Err(format!("{lit} of {period} rows of {row_px} pixels; expected at least one lit and one not"));
    }
    let channel = channel.parse().map_err(|error: UnknownChannel| error.to_string())?;
    let observation = Observation {
        trial: number("trial", trial)?,
        level: number("level", level)?,
        catch: number::<u8>("catch", catch)? != 0,
        stimulus: NullingStimulus { channel, rows, patch: number("patch", patch)? },
        judgement: judgement.parse().map_err(|expected| format!("judgement {judgement:?}: {expected}"))?,
    };
    Ok((event, observation))
}

fn number<T: std::str::FromStr>(column: &str, cell: &str) -> Result<T, String> {
    cell.parse().map_err(|_| format!("{column} {cell:?} is no whole number of its range; expected one, such as 1"))
}
