//! Readings of a photometer (CSV): `channel,level,luminance_cd_m2`.

use std::path::Path;

use super::{
    FileFault, FileFaults, StoreError,
    dataset::write_whole,
    fault::io,
    text::{self, position},
};
use crate::display::photometer::{Channel, Reading, ReadingFault, Readings};

/// The columns, in the order in which they are written. Further columns are passed over.
pub const COLUMNS: [&str; 3] = ["channel", "level", "luminance_cd_m2"];

/// Reads readings that a profile can be made from, in the order in which they were taken.
///
/// # Errors
/// Every fault, that of a cell with its line and column.
pub fn open(path: &Path) -> Result<Readings, FileFaults> {
    parse(&path.display().to_string(), &text::read(path)?)
}

/// Reads readings from their text; `file` names it in messages.
///
/// # Errors
/// Every fault, that of a cell with its line and column.
pub fn parse(file: &str, text: &str) -> Result<Readings, FileFaults> {
    let rows = rows(file, text)?;
    let readings = rows.iter().map(|row| row.reading).collect();
    Readings::new(readings).map_err(|faults| {
        let told = faults.iter().map(|found| {
            let place = found.index.and_then(|index| rows.get(index)).map(|row| match found.fault {
                ReadingFault::Luminance(_) => row.luminance_at,
                _ => row.level_at,
            });
            FileFault { file: file.to_owned(), position: place, message: found.to_string() }
        });
        FileFaults(told.collect())
    })
}

/// Reads readings as they stand in a file that may not be complete, to go on with it.
///
/// # Errors
/// Cells that are no readings, each with its line and column.
pub fn open_begun(path: &Path) -> Result<Vec<Reading>, FileFaults> {
    let rows = rows(&path.display().to_string(), &text::read(path)?)?;
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

/// A reading, and where its cells stand: line and column from 1.
struct Row {
    reading: Reading,
    level_at: (usize, usize),
    luminance_at: (usize, usize),
}

/// What a table of readings looks like.
struct Shape {
    separator: u8,
    /// Indices of [`COLUMNS`].
    columns: [usize; 3],
}

fn rows(file: &str, text: &str) -> Result<Vec<Row>, FileFaults> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let shape = shape(file, text)?;
    let mut reader = csv::ReaderBuilder::new().delimiter(shape.separator).flexible(true).from_reader(text.as_bytes());
    let mut faults = Vec::new();
    let mut rows = Vec::new();
    for record in reader.records() {
        match record {
            Ok(record) => match row(text, &shape, &record) {
                Ok(row) => rows.push(row),
                Err(found) => faults.extend(found),
            },
            Err(error) => faults.push((None, format!("is no CSV: {error}; expected rows of cells"))),
        }
    }
    if faults.is_empty() {
        return Ok(rows);
    }
    let fault = |(position, message)| FileFault { file: file.to_owned(), position, message };
    Err(FileFaults(faults.into_iter().map(fault).collect()))
}

fn shape(file: &str, text: &str) -> Result<Shape, FileFaults> {
    let header = text.lines().next().unwrap_or_default();
    // Spreadsheets of half the world separate by semicolons, since the comma is their decimal point.
    let separator = if header.contains(';') && !header.contains(',') { ';' } else { ',' };
    let names: Vec<String> =
        header.split(separator).map(|name| name.trim().trim_matches('"').to_ascii_lowercase()).collect();
    let index = |column: &str| names.iter().position(|name| name == column);
    match COLUMNS.map(index) {
        [Some(channel), Some(level), Some(luminance)] => {
            Ok(Shape { separator: separator as u8, columns: [channel, level, luminance] })
        }
        found => {
            let missing: Vec<&str> =
                COLUMNS.into_iter().zip(found).filter(|(_, index)| index.is_none()).map(|(name, _)| name).collect();
            let message =
                format!("the header lacks {}; expected the columns {}", missing.join(", "), COLUMNS.join(","));
            Err(FileFaults(vec![FileFault { file: file.to_owned(), position: Some((1, 1)), message }]))
        }
    }
}

type Faults = Vec<(Option<(usize, usize)>, String)>;

fn row(text: &str, shape: &Shape, record: &csv::StringRecord) -> Result<Row, Faults> {
    let start = record.position().map_or(0, |position| position.byte() as usize);
    // The reader's position may be before line ends that it passed over.
    let start = start + text[start..].len() - text[start..].trim_start_matches(['\r', '\n']).len();
    let place = |column: usize| position(text, start + cell_start(&text[start..], column, shape.separator));
    let [channel_at, level_at, luminance_at] = shape.columns;
    let mut faults = Faults::new();
    let mut cell = |column: usize, name: &str| match record.get(column).map(str::trim) {
        Some(text) if !text.is_empty() => Some(text),
        _ => {
            faults.push((Some(place(column.min(record.len()))), format!("{name} is empty; expected a value")));
            None
        }
    };
    let cells = [channel_at, level_at, luminance_at].map(|column| {
        let name = COLUMNS[shape.columns.iter().position(|at| *at == column).unwrap_or(0)];
        (column, name, cell(column, name))
    });
    let mut channel = None;
    let mut numbers = [None; 2];
    for (index, (column, name, cell)) in cells.into_iter().enumerate() {
        let Some(cell) = cell else { continue };
        let wrong = if index == 0 {
            cell.parse::<Channel>().map(|known| channel = Some(known)).err().map(|error| error.to_string())
        } else {
            numbers[index - 1] = number(cell, shape.separator);
            numbers[index - 1].is_none().then(|| format!("{name} {cell:?} is no number; expected one such as 0.5"))
        };
        faults.extend(wrong.map(|message| (Some(place(column)), message)));
    }
    match (channel, numbers) {
        (Some(channel), [Some(level), Some(luminance_cd_m2)]) => Ok(Row {
            reading: Reading { channel, level, luminance_cd_m2 },
            level_at: place(level_at),
            luminance_at: place(luminance_at),
        }),
        _ => Err(faults),
    }
}

fn number(cell: &str, separator: u8) -> Option<f64> {
    if separator == b';' { cell.replace(',', ".").parse().ok() } else { cell.parse().ok() }
}

/// Byte at which a cell of a row begins.
fn cell_start(row: &str, column: usize, separator: u8) -> usize {
    let mut quoted = false;
    let mut passed = 0;
    for (at, byte) in row.bytes().enumerate() {
        if passed == column {
            return at;
        }
        match byte {
            b'"' => quoted = !quoted,
            b'\n' | b'\r' if !quoted => return at,
            _ if byte == separator && !quoted => passed += 1,
            _ => {}
        }
    }
    row.len()
}
