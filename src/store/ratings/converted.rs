//! Files that are not plain text in UTF-8 with line feeds. They are converted in memory.

use std::path::Path;

use flate2::read::MultiGzDecoder;

use super::workbook;
use crate::store::{
    FileErrors, StoreError,
    error::io,
    open::{MAX_UNPACKED, read_regular, unpacked},
};

/// The content of a file as text in UTF-8.
#[derive(Clone, Debug, Default)]
pub(super) struct Converted {
    pub bytes: Vec<u8>,
    /// What a user should know about how the file was read, and what was expected.
    pub note: Option<[String; 2]>,
    /// Whether it is the sheet of a workbook, whose cells have names.
    pub is_sheet: bool,
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
        (converted.bytes, converted.note) = workbook::first_sheet(&converted.bytes).map_err(failed)?;
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
