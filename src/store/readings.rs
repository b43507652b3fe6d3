//! Readings of a photometer (CSV): `channel,level,luminance_cd_m2`.

use std::{
    collections::{BTreeMap, BTreeSet},
    path::Path,
};

use super::{
    FileFault, FileFaults, StoreError,
    fault::io,
    file::{read_text, write_whole},
    table::{Content, each_row},
};
use crate::display::{
    Channel,
    photometer::{About, Reading, Readings},
};

/// Faults of one kind that are reported one by one; of more, the first is, with their number.
const MOST_EACH: usize = 3;

/// The columns, in the order in which they are written. Further columns are ignored.
pub const COLUMNS: [&str; 3] = ["channel", "level", "luminance_cd_m2"];

/// Reads readings that a profile can be made from, in the order in which they were taken.
///
/// # Errors
/// Every fault, that of a cell with its line and column; of many of one kind the first, with their number.
pub fn open(path: &Path) -> Result<Readings, FileFaults> {
    parse(&path.display().to_string(), &read_text(path)?)
}

/// Reads readings from their text; `file` names it in messages.
///
/// # Errors
/// Every fault, that of a cell with its line and column; of many of one kind the first, with their number.
pub fn parse(file: &str, text: &str) -> Result<Readings, FileFaults> {
    let rows = rows(file, text)?;
    let readings = rows.iter().map(|row| row.reading).collect();
    Readings::new(readings).map_err(|faults| {
        let found = faults.iter().map(|found| {
            let (kind, position) = match found.about {
                About::Luminance(index) => (Kind::Luminance, Some(rows[index].luminance_at)),
                About::Level(index) => (Kind::Level, Some(rows[index].level_at)),
                About::Levels(..) | About::All => (Kind::Whole, None),
            };
            Found { kind, position, message: found.message.clone() }
        });
        let mut found: Vec<Found> = found.collect();
        if rows.iter().all(|row| (0.0..=1.0).contains(&row.reading.luminance_cd_m2)) {
            found.iter_mut().filter(|found| found.kind == Kind::Level).for_each(|found| found.message += EXCHANGED);
        }
        summarized(file, found)
    })
}

/// What levels outside 0…1 beside luminances within are likely to be.
const EXCHANGED: &str = " (every luminance_cd_m2 is within 0…1: are the columns level and luminance_cd_m2 exchanged?)";

/// Kinds of faults that can be in many rows for one reason.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Kind {
    /// Of the readings together, or of the table: each is reported.
    Whole,
    Fields,
    /// Of the cell in the nth of [`COLUMNS`].
    Empty(usize),
    Cell(usize),
    Level,
    Luminance,
}

/// A fault, and where it is: line and column from 1.
struct Found {
    kind: Kind,
    position: Option<(usize, usize)>,
    message: String,
}

/// The faults as they are reported: what is wrong in every row for one reason is one line, not a line a row.
fn summarized(file: &str, found: Vec<Found>) -> FileFaults {
    let mut counts = BTreeMap::new();
    found.iter().for_each(|one| *counts.entry(one.kind).or_insert(0_usize) += 1);
    let mut begun = BTreeSet::new();
    let each = found.into_iter().filter_map(|Found { kind, position, mut message }| {
        let count = counts[&kind];
        if kind != Kind::Whole && count > MOST_EACH {
            if !begun.insert(kind) {
                return None;
            }
            message += &format!("; {count} rows are like this one");
        }
        Some(FileFault { file: file.to_owned(), position, message })
    });
    FileFaults(each.collect())
}

/// Reads the readings in a file that may not be complete, to resume it.
///
/// # Errors
/// Cells that are not readings, each with its line and column; of many of one kind the first, with their number.
pub fn open_begun(path: &Path) -> Result<Vec<Reading>, FileFaults> {
    let rows = rows(&path.display().to_string(), &read_text(path)?)?;
    Ok(rows.into_iter().map(|row| row.reading).collect())
}

/// Writes readings, whole or not at all, and onto the disk.
///
/// # Errors
/// The system's refusal.
pub fn write(path: &Path, readings: &[Reading]) -> Result<(), StoreError> {
    let mut text = COLUMNS.join(",");
    text.push('\n');
    for Reading { channel, level, luminance_cd_m2 } in readings {
        text.push_str(&format!("{},{level},{luminance_cd_m2}\n", channel.key()));
    }
    if let Some(folder) = path.parent().filter(|folder| !folder.as_os_str().is_empty()) {
        std::fs::create_dir_all(folder).map_err(io(folder, "make the folder"))?;
    }
    write_whole(path, text.as_bytes(), true)
}

/// A reading, and where its cells are: line and column from 1.
struct Row {
    reading: Reading,
    level_at: (usize, usize),
    luminance_at: (usize, usize),
}

fn rows(file: &str, text: &str) -> Result<Vec<Row>, FileFaults> {
    // Spreadsheets of half the world separate by semicolons, since the comma is their decimal point.
    let first = text.lines().next().unwrap_or_default();
    let separator = if first.contains(';') && !first.contains(',') { b';' } else { b',' };
    let (mut rows, mut faults) = (Vec::new(), Vec::new());
    let mut columns: Option<[Option<usize>; 3]> = None;
    let mut width = 0;
    let read = each_row(Content::Memory(text.as_bytes()), separator, |row| {
        let cells: Vec<&str> =
            row.record.iter().map(|cell| std::str::from_utf8(cell).unwrap_or_default().trim()).collect();
        match columns {
            None => {
                width = cells.len();
                let index = |column: &str| cells.iter().position(|name| name.eq_ignore_ascii_case(column));
                columns = Some(COLUMNS.map(index));
            }
            Some([Some(channel), Some(level), Some(luminance)]) if cells.len() <= width => {
                match reading(&cells, [channel, level, luminance], separator, |cell| row.place(cell)) {
                    Ok(row) => rows.push(row),
                    Err(found) => faults.extend(found),
                }
            }
            // More fields than the header names: which of them are the reading cannot be known.
            Some([Some(_), Some(_), Some(_)]) => {
                let why = if separator == b',' { " (a decimal comma?)" } else { "" };
                let message = format!("{} fields; expected {width}{why}", cells.len());
                faults.push(Found { kind: Kind::Fields, position: Some(row.place(0)), message });
            }
            Some(_) => {}
        }
    });
    let found = columns.unwrap_or_default();
    let missing: Vec<&str> =
        COLUMNS.into_iter().zip(found).filter(|(_, index)| index.is_none()).map(|(name, _)| name).collect();
    if !missing.is_empty() {
        let message = format!("the header lacks {}; expected the columns {}", missing.join(", "), COLUMNS.join(","));
        return Err(FileFaults(vec![FileFault::at(file, (1, 1), message)]));
    }
    if let Err(error) = read {
        faults.push(Found { kind: Kind::Whole, position: None, message: format!("{error}; expected rows of cells") });
    }
    if faults.is_empty() { Ok(rows) } else { Err(summarized(file, faults)) }
}

/// The reading of a row; `place` gives the position of a cell.
fn reading(
    cells: &[&str],
    columns: [usize; 3],
    separator: u8,
    place: impl Fn(usize) -> (usize, usize),
) -> Result<Row, Vec<Found>> {
    let mut faults = Vec::new();
    let mut channel = None;
    let mut numbers = [None; 2];
    for (index, (column, name)) in columns.into_iter().zip(COLUMNS).enumerate() {
        let Some(cell) = cells.get(column).copied().filter(|cell| !cell.is_empty()) else {
            let position = Some(place(column.min(cells.len())));
            let message = format!("{name} is empty; expected a value");
            faults.push(Found { kind: Kind::Empty(index), position, message });
            continue;
        };
        let wrong = if index == 0 {
            cell.parse::<Channel>().map(|known| channel = Some(known)).err().map(|error| error.to_string())
        } else {
            let number = if separator == b';' { cell.replace(',', ".").parse() } else { cell.parse() };
            numbers[index - 1] = number.ok();
            numbers[index - 1].is_none().then(|| format!("{name} {cell:?} is not a number; expected one such as 0.5"))
        };
        faults.extend(wrong.map(|message| Found { kind: Kind::Cell(index), position: Some(place(column)), message }));
    }
    let [_, level_at, luminance_at] = columns;
    match (channel, numbers) {
        (Some(channel), [Some(level), Some(luminance_cd_m2)]) => Ok(Row {
            reading: Reading { channel, level, luminance_cd_m2 },
            level_at: place(level_at),
            luminance_at: place(luminance_at),
        }),
        _ => Err(faults),
    }
}
