//! Photometer readings: CSV with the columns `channel,level,luminance_cd_m2`, or a file of another program.

use std::path::Path;

use super::{
    FileError, FileErrors, StoreError, Writer, calibrations,
    error::RowErrors,
    file::{folder_of, read_text},
    table::{Content, each_row},
};
use crate::display::{
    Channel,
    photometer::{ErrorLocation, Reading, Readings},
};

/// The columns, in the order in which they are written. Additional columns are ignored when reading.
pub const COLUMNS: [&str; 3] = ["channel", "level", "luminance_cd_m2"];

/// Maximum number of readings. Three at each of the 256 levels of four channels are 3,072.
const MAX_READINGS: usize = 4000;

/// Reads a complete set of readings, sufficient for a profile, in the order in which they were taken.
///
/// # Errors
/// Reports every error, with its line and column if it is in a cell. If a column has many errors, only the first ones
/// are listed, followed by the number of others.
pub fn open(path: &Path) -> Result<Readings, FileErrors> {
    parse(&path.display().to_string(), &read_text(path)?)
}

/// Parses the text of a readings file; `file` identifies it in messages.
///
/// # Errors
/// The same errors as [`open()`].
pub fn parse(file: &str, text: &str) -> Result<Readings, FileErrors> {
    let mut rows = match calibrations::parse(file, text) {
        Some(found) => (found?.into_iter()).map(|(reading, line)| Row { reading, places: [(line, 1); 3] }).collect(),
        None => rows(file, text)?,
    };
    complete_black(&mut rows);
    Readings::new(rows.iter().map(|row| row.reading).collect()).map_err(|found| {
        let exchanged = rows.iter().all(|row| (0.0..=1.0).contains(&row.reading.luminance_cd_m2));
        let (mut errors, mut of_all) = (RowErrors::default(), Vec::new());
        for error in found {
            let mut message = error.message.clone();
            let (index, column) = match error.location {
                ErrorLocation::Luminance(index) => (index, 2),
                ErrorLocation::Level(index) => (index, 1),
                ErrorLocation::All => {
                    of_all.push(FileError::whole(file, message));
                    continue;
                }
            };
            if column == 1 && exchanged {
                message += EXCHANGED;
            }
            errors.add(file, Some(column), message, || rows[index].places[column]);
        }
        FileErrors([errors.finish(file, &COLUMNS), of_all].concat())
    })
}

/// Gives the reading of black to every channel that lacks it: all channels are dark in it.
fn complete_black(rows: &mut Vec<Row>) {
    let blacks: Vec<Row> = rows.iter().filter(|row| row.reading.level == 0.0).cloned().collect();
    let Some(of) = blacks.first().map(|black| black.reading.channel) else { return };
    for channel in Channel::ALL {
        let own = |row: &&Row| row.reading.channel == channel;
        if rows.iter().any(|row| own(&row)) && !blacks.iter().any(|row| own(&row)) {
            let one = blacks.iter().filter(|row| row.reading.channel == of);
            rows.extend(one.map(|row| Row { reading: Reading { channel, ..row.reading }, ..row.clone() }));
        }
    }
}

/// The likely cause if levels are outside 0…1 but all luminances are inside 0…1.
const EXCHANGED: &str = " (every luminance_cd_m2 is within 0…1: are the columns level and luminance_cd_m2 swapped?)";

/// Reads the readings in a possibly incomplete file in order to resume it.
///
/// # Errors
/// Reports cells that are not readings, with their line and column. If a column has many errors, only the first ones
/// are listed, followed by the number of others.
pub fn open_incomplete(path: &Path) -> Result<Vec<Reading>, FileErrors> {
    let rows = rows(&path.display().to_string(), &read_text(path)?)?;
    Ok(rows.into_iter().map(|row| row.reading).collect())
}

/// Writes readings, and creates their folder if necessary.
///
/// # Errors
/// The same errors as [`Writer::write`].
pub fn write(writer: &Writer, path: &Path, readings: &[Reading]) -> Result<(), StoreError> {
    let mut text = COLUMNS.join(",") + "\n";
    for Reading { channel, level, luminance_cd_m2 } in readings {
        text += &format!("{},{level},{luminance_cd_m2}\n", channel.key());
    }
    writer.make_folder(folder_of(path))?;
    writer.write(path, text.as_bytes())
}

/// A reading, and the line and column of each of its cells in the order of [`COLUMNS`].
#[derive(Clone)]
struct Row {
    reading: Reading,
    places: [(usize, usize); 3],
}

fn rows(file: &str, text: &str) -> Result<Vec<Row>, FileErrors> {
    // In many countries, spreadsheets separate cells with semicolons because the comma is the decimal separator.
    let first = text.lines().next().unwrap_or_default();
    let separator = if first.contains(';') && !first.contains(',') { b';' } else { b',' };
    let (mut rows, mut errors) = (Vec::new(), RowErrors::default());
    let (mut columns, mut width) = ([None; 3], None);
    // Reading from memory does not fail.
    let _ = each_row(Content::Memory(text.as_bytes()), separator, |row| {
        let cells: Vec<&str> =
            row.record.iter().map(|cell| std::str::from_utf8(cell).unwrap_or_default().trim()).collect();
        let Some(width) = width else {
            width = Some(cells.len());
            columns = COLUMNS.map(|column| cells.iter().position(|name| name.eq_ignore_ascii_case(column)));
            return;
        };
        let [Some(channel_at), Some(level_at), Some(luminance_at)] = columns else { return };
        // If a row has more fields than the header, it is unclear which of them are the reading.
        if cells.len() > width {
            let why = if separator == b',' { " (a decimal comma?)" } else { "" };
            return errors.add(file, None, format!("{} fields; expected {width}{why}", cells.len()), || row.place(0));
        }
        let mut cell = |index: usize, column: usize| {
            let found = cells.get(column).copied().filter(|cell| !cell.is_empty());
            if found.is_none() {
                let message = format!("{} is empty; expected a value", COLUMNS[index]);
                errors.add(file, Some(index), message, || row.place(column.min(cells.len())));
            }
            found
        };
        let (channel, level, luminance) = (cell(0, channel_at), cell(1, level_at), cell(2, luminance_at));
        let mut number = |index: usize, column: usize, cell: Option<&str>| {
            let cell = cell?;
            let number = if separator == b';' { cell.replace(',', ".").parse() } else { cell.parse() };
            number
                .map_err(|_| {
                    let message = format!("{} {cell:?} is not a number; expected one such as 0.5", COLUMNS[index]);
                    errors.add(file, Some(index), message, || row.place(column));
                })
                .ok()
        };
        let (level, luminance_cd_m2) = (number(1, level_at, level), number(2, luminance_at, luminance));
        let channel = channel.map(str::parse::<Channel>).and_then(|channel| {
            channel.map_err(|error| errors.add(file, Some(0), error.to_string(), || row.place(channel_at))).ok()
        });
        if let (Some(channel), Some(level), Some(luminance_cd_m2)) = (channel, level, luminance_cd_m2) {
            let places = [channel_at, level_at, luminance_at].map(|column| row.place(column));
            rows.push(Row { reading: Reading { channel, level, luminance_cd_m2 }, places });
        }
    });
    let missing: Vec<&str> =
        COLUMNS.into_iter().zip(columns).filter(|(_, index)| index.is_none()).map(|(name, _)| name).collect();
    if !missing.is_empty() {
        let message = format!("the header lacks {}; expected the columns {}", missing.join(", "), COLUMNS.join(","));
        return Err(FileErrors::at(file, (1, 1), message));
    }
    if rows.len() > MAX_READINGS {
        let message = format!("the number of readings is {}; expected at most {MAX_READINGS}", rows.len());
        return Err(FileErrors::whole(file, message));
    }
    FileErrors::none(errors.finish(file, &COLUMNS)).map(|()| rows)
}
