//! Files that are not plain text in UTF-8 with line feeds, such as packed files and Excel workbooks (`.xlsx`). They are
//! converted in memory.

use std::{io::Cursor, ops::Range, path::Path};

use calamine::{Data, DataRef, Reader as _, Xlsx};
use flate2::read::MultiGzDecoder;
use zip::ZipArchive;

use crate::store::{
    FileErrors, StoreError,
    error::io,
    open::{MAX_UNPACKED, read_regular, unpacked},
    table::line,
};

/// The content of a file as text in UTF-8.
#[derive(Clone, Debug, Default)]
pub(super) struct Converted {
    pub bytes: Vec<u8>,
    /// What a user should know about how the file was read, and what was expected.
    pub note: Option<[String; 2]>,
    /// Whether it is the sheet of a workbook.
    pub is_sheet: bool,
    /// Row and column, counted from 0, of each cell of a sheet that has no exact value, and what is wrong.
    pub unusable: Vec<(usize, usize, &'static str)>,
}

/// Converts a file that begins with `head`: unpacks gzip, takes the first sheet of an Excel workbook, decodes UTF-16, and
/// replaces carriage returns, with which old spreadsheets end lines, because lines are counted by their line feeds.
/// `None` if nothing of this is necessary.
///
/// # Errors
/// The file cannot be unpacked, or it is too large.
pub(super) fn converted(path: &Path, head: &[u8]) -> Result<Option<Converted>, StoreError> {
    let (is_gzip, is_workbook) = (head.starts_with(b"\x1f\x8b"), head.starts_with(b"PK\x03\x04"));
    if !is_gzip && !is_workbook && utf16(head).is_none() && !has_old_lines(head) {
        return Ok(None);
    }
    let bytes = read_regular(path, MAX_UNPACKED).map_err(io(path, "read"))?;
    let mut converted = Converted { bytes, is_sheet: is_workbook, ..Converted::default() };
    let failed = |message: String| FileErrors::whole(path, message);
    if is_gzip {
        converted.bytes = unpacked(MultiGzDecoder::new(&converted.bytes[..]), MAX_UNPACKED).map_err(failed)?;
    } else if is_workbook {
        (converted.bytes, converted.note, converted.unusable) = first_sheet(&converted.bytes).map_err(failed)?;
    }
    if let Some(encoding) = utf16(&converted.bytes) {
        converted.bytes = encoding.decode(&converted.bytes).0.into_owned().into_bytes();
    }
    if has_old_lines(&converted.bytes) {
        converted.bytes.iter_mut().filter(|byte| **byte == b'\r').for_each(|byte| *byte = b'\n');
    }
    Ok(Some(converted))
}

fn utf16(bytes: &[u8]) -> Option<&'static encoding_rs::Encoding> {
    let (encoding, _) = encoding_rs::Encoding::for_bom(bytes)?;
    (encoding != encoding_rs::UTF_8).then_some(encoding)
}

fn has_old_lines(bytes: &[u8]) -> bool {
    bytes.contains(&b'\r') && !bytes.contains(&b'\n')
}

/// Number of columns of a sheet in Excel.
const MAX_COLUMNS: u32 = 16_384;

/// Whole numbers below this are exact in a workbook.
const EXACT: f64 = (1_u64 << 53) as f64;

/// The rows of a sheet as CSV, what a user should know about how it was read, and the cells without an exact value.
type Sheet = (Vec<u8>, Option<[String; 2]>, Vec<(usize, usize, &'static str)>);

/// Returns the first sheet as CSV with commas. Line numbers are those of the sheet, and every row has as many cells as the
/// first one that is not empty.
///
/// # Errors
/// Says what is wrong and what is expected.
fn first_sheet(file: &[u8]) -> Result<Sheet, String> {
    check_size(file)?;
    // calamine does not check all that it calculates with, such as the row in the name of a cell.
    let read = std::panic::catch_unwind(|| read(file));
    read.unwrap_or_else(|_| Err("is a damaged workbook; expected an Excel workbook (.xlsx), or CSV".to_owned()))
}

fn read(file: &[u8]) -> Result<Sheet, String> {
    let unreadable =
        |error: &dyn std::fmt::Display| format!("is not an Excel workbook (.xlsx): {error}; expected one, or CSV");
    let mut workbook = Xlsx::new(Cursor::new(file)).map_err(|error| unreadable(&error))?;
    let names = workbook.sheet_names();
    let name = names.first().ok_or_else(|| unreadable(&"it has no sheets"))?;
    let mut cells = workbook.worksheet_cells_reader(name).map_err(|error| unreadable(&error))?;
    let (mut bytes, mut row, mut width, mut at) = (Vec::new(), Vec::<String>::new(), 0, 0);
    let (mut characters, mut unusable) = (0, Vec::new());
    let limited = |size: usize| match size as u64 > MAX_UNPACKED {
        true => Err(format!("the sheet has more than {MAX_UNPACKED} bytes as CSV; expected fewer")),
        false => Ok(()),
    };
    let mut end_row = |row: &mut Vec<String>| {
        width = if width == 0 { row.len() } else { width };
        if row.is_empty() {
            bytes.push(b'\n');
        } else {
            row.resize(row.len().max(width), String::new());
            bytes.extend(line(row.drain(..)));
        }
        limited(bytes.len())
    };
    // The formulas are not asked for as a range, which has a place for every cell between the first and the last one.
    while let Some(cell) = cells.next_cell_with_formula_metadata().map_err(|error| unreadable(&error))? {
        let ((found, column), text) = (cell.pos, text(&cell.value.clone().into()));
        let problem = match cell.value {
            DataRef::Float(number) if number.abs() >= EXACT => {
                Some("is a number of 2^53 or more, whose last digits a workbook does not keep; expected text")
            }
            DataRef::Empty if cell.formula.is_some() => {
                Some("is a formula without a value; expected the value, which a spreadsheet program stores with it")
            }
            _ => None,
        };
        unusable.extend(problem.map(|problem| (found as usize, column as usize, problem)));
        if text.is_empty() {
            continue;
        }
        if found < at || found == at && (column as usize) < row.len() || column >= MAX_COLUMNS {
            return Err(unreadable(&"its cells are not in order, or one has no place in a sheet"));
        }
        // Many cells can share one long text.
        characters += text.len();
        limited(characters)?;
        (at..found).try_for_each(|_| end_row(&mut row))?;
        at = found;
        row.resize(column as usize, String::new());
        row.push(text);
    }
    end_row(&mut row)?;
    let note = (names.len() > 1).then(|| {
        let others = names[1..].join(", ");
        let expected = format!("expected one sheet (the others were ignored: {others})");
        [format!("only the first sheet, {name}, was read"), expected]
    });
    Ok((bytes, note, unusable))
}

/// Returns the text of a cell: a date, a time of day or both as in ISO 8601, and a duration in hours, minutes and seconds.
fn text(cell: &Data) -> String {
    const DATES: Range<f64> = 0.0..2_958_466.0;
    let Data::DateTime(moment) = cell else { return cell.to_string() };
    let (days, (year, month, day, hour, minute, second, milli)) = (moment.as_f64(), moment.to_ymd_hms_milli());
    let date = format!("{year}-{month:02}-{day:02}");
    let part = if milli == 0 { String::new() } else { format!(".{milli:03}") };
    let time = format!("{minute:02}:{second:02}{part}");
    match hour {
        _ if !DATES.contains(&days) => days.to_string(),
        _ if moment.is_duration() => format!("{}:{time}", (24.0 * days + 1e-7).floor()),
        _ if days < 1.0 => format!("{hour:02}:{time}"),
        0 if time == "00:00" => date,
        _ => format!("{date}T{hour:02}:{time}"),
    }
}

/// Checks that a workbook does not unpack to too many bytes. calamine unpacks without a limit.
fn check_size(file: &[u8]) -> Result<(), String> {
    let broken = |error| format!("cannot be unpacked: {error}; expected an Excel workbook (.xlsx), or CSV");
    let mut archive = ZipArchive::new(Cursor::new(file)).map_err(broken)?;
    if archive.index_for_name("mimetype").is_some() {
        return Err("is an OpenDocument file; expected an Excel workbook (.xlsx), or CSV: save it as one".to_owned());
    }
    let mut left = MAX_UNPACKED;
    for index in 0..archive.len() {
        left -= unpacked(archive.by_index(index).map_err(broken)?, left)?.len() as u64;
    }
    Ok(())
}
