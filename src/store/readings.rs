//! Photometer readings: CSV with the columns `channel,level,luminance_cd_m2`, or a file of another program.

use std::{cell::Cell, path::Path};

use super::{
    FileError, FileErrors, StoreError, Writer, calibrations,
    error::RowErrors,
    file::{folder_of, read_text},
    ratings::with_point,
    table::{self, separator},
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
/// Reports every error, with its line and column if it is in a cell. If a column has many values that are not possible, only
/// the first ones are listed, followed by the number of others.
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
        let (mut errors, mut of_all) = (RowErrors::default(), Vec::new());
        for error in found {
            let message = error.message.clone();
            let (index, column) = match error.location {
                ErrorLocation::Luminance(index) => (index, 2),
                ErrorLocation::Level(index) => (index, 1),
                ErrorLocation::Levels(..) | ErrorLocation::All => {
                    of_all.push(FileError::whole(file, message));
                    continue;
                }
            };
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

/// Reads the readings in a possibly incomplete file in order to resume it.
///
/// # Errors
/// Reports rows that are not readings, with their line and column.
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
    let separator = separator(text.lines().next().unwrap_or_default().as_bytes());
    let columns = Cell::new([0; 3]);
    let header = |names: &[&str]| {
        let found = COLUMNS.map(|column| names.iter().position(|name| name.trim().eq_ignore_ascii_case(column)));
        let missing = COLUMNS.into_iter().zip(found).filter(|(_, index)| index.is_none()).map(|(name, _)| name);
        let missing: Vec<&str> = missing.collect();
        columns.set(found.map(Option::unwrap_or_default));
        let message = || format!("the header lacks {}; expected the columns {}", missing.join(", "), COLUMNS.join(","));
        if missing.is_empty() { Ok(()) } else { Err((0, message())) }
    };
    let rows = table::parse(file, text.as_bytes(), separator, header, |cells, row| {
        let columns = columns.get();
        let number = |index: usize| {
            let cell = cells[columns[index]].trim();
            let message = || format!("{} {cell:?} is not a number; expected one such as 0.5", COLUMNS[index]);
            with_point(cell, separator).parse::<f64>().map_err(|_| (columns[index], message()))
        };
        let channel: Channel = cells[columns[0]].trim().parse().map_err(|error| (columns[0], format!("{error}")))?;
        let reading = Reading { channel, level: number(1)?, luminance_cd_m2: number(2)? };
        Ok(Row { reading, places: columns.map(|column| row.place(column)) })
    })?;
    if rows.len() > MAX_READINGS {
        let message = format!("the number of readings is {}; expected at most {MAX_READINGS}", rows.len());
        return Err(FileErrors::whole(file, message));
    }
    Ok(rows)
}
