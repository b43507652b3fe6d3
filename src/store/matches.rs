//! Visual matches of a display: a CSV file with one row per match. Each row is on disk before the next picture is
//! shown. A match that is undone stays in the file, followed by a row that cancels it.

use std::path::Path;

use super::{
    FileErrors, StoreError, Writer,
    file::{AppendFile, MAX_TEXT, exists, folder_of, read_text},
    table::{self, exactly},
};
use crate::display::{
    Channel, UnknownChannel,
    matching::{Match, Rows},
};

/// The columns. `event` is `match` or `undo`. Of every `period` rows, each `row_px` pixels thick, `lit` rows are fully
/// lit and the others are dark. `patch` is the matched code, `time_s` is the time since the first
/// picture in seconds, and `seed` is the seed of the order.
const COLUMNS: &str = "event,trial,channel,lit,period,row_px,patch,time_s,seed";

/// The file of a matching run.
#[derive(Debug)]
pub struct MatchFile {
    file: AppendFile,
    /// The seed of the order.
    pub seed: u64,
}

/// Whether a row cancels a match, the match, and the seed of the order.
type Row = (bool, Match, u64);

impl MatchFile {
    /// Opens a file to continue it, and returns its matches and its seed; otherwise creates it with this seed, and its folder
    /// if necessary. An incomplete last row, such as after a power failure, is dropped.
    ///
    /// # Errors
    /// Another program is writing the file, or it is not a file of matches; the same errors as [`Writer::write`].
    pub fn begin(path: &Path, seed: u64) -> Result<(Self, Vec<Match>), StoreError> {
        let header = format!("{COLUMNS}\n").into_bytes();
        if exists(path)? {
            let file = AppendFile::open(path, true, header, MAX_TEXT)?;
            let rows = rows(&path.display().to_string(), file.content())?;
            let seed = rows.last().map_or(seed, |(.., seed)| *seed);
            return Ok((Self { file, seed }, counted(rows)));
        }
        let writer = Writer::default();
        writer.make_folder(folder_of(path))?;
        writer.check([path])?;
        let mut file = AppendFile::new(path, true, header);
        file.flush()?;
        Ok((Self { file, seed }, Vec::new()))
    }

    /// Records match `number`, counted from 1, made `time_s` seconds after the first picture; or, if it `is_undone`, that it no
    /// longer counts.
    ///
    /// # Errors
    /// The write failed; the next call will also write this match.
    pub fn record(&mut self, number: usize, found: &Match, time_s: f64, is_undone: bool) -> Result<(), StoreError> {
        let event = if is_undone { "undo" } else { "match" };
        let Match { channel, rows: Rows { lit, period, row_px }, code } = found;
        let seed = self.seed;
        let row = format!("{event},{number},{channel},{lit},{period},{row_px},{code},{time_s:.3},{seed}\n");
        self.file.append(row.as_bytes())
    }

    /// Writes the matches that could not be written before.
    ///
    /// # Errors
    /// The write failed again.
    pub fn save(&mut self) -> Result<(), StoreError> {
        self.file.flush()
    }
}

/// Reads the matches that count, in order.
///
/// # Errors
/// Reports every row that cannot be parsed, with its line and column.
pub fn open(path: &Path) -> Result<Vec<Match>, FileErrors> {
    Ok(counted(rows(&path.display().to_string(), read_text(path)?.as_bytes())?))
}

fn counted(rows: Vec<Row>) -> Vec<Match> {
    let mut matches = Vec::new();
    for (is_undone, found, _) in rows {
        if is_undone { _ = matches.pop() } else { matches.push(found) }
    }
    matches
}

fn rows(file: &str, text: &[u8]) -> Result<Vec<Row>, FileErrors> {
    let header = |names: &[&str]| exactly(names, COLUMNS.split(','));
    Ok(table::parse(file, text, b',', header, |(), cells| row(cells))?.1)
}

/// Parses a row.
///
/// # Errors
/// The index of the cell that is wrong, and what is wrong there.
fn row(cells: &[&str]) -> Result<Row, (usize, String)> {
    let [event, _, channel, lit, period, row_px, patch, _, seed] = *cells else {
        return Err((0, "the row has too few cells".to_owned()));
    };
    if !["match", "undo"].contains(&event) {
        return Err((0, format!("{event:?} is not known; expected match or undo")));
    }
    let channel: Channel = channel.parse().map_err(|error: UnknownChannel| (2, error.to_string()))?;
    let rows = Rows { lit: number(3, lit)?, period: number(4, period)?, row_px: number(5, row_px)? };
    if rows.lit == 0 || rows.lit >= rows.period || rows.row_px == 0 {
        return Err((
            3,
            format!("{lit} of {period} rows are lit, {row_px} px each; expected at least one lit row and one dark row"),
        ));
    }
    let found = Match { channel, rows, code: number(6, patch)? };
    Ok((event == "undo", found, number(8, seed)?))
}

fn number<T: std::str::FromStr>(cell: usize, text: &str) -> Result<T, (usize, String)> {
    text.parse().map_err(|_| (cell, format!("{text:?} is not a whole number in the valid range; expected one")))
}
