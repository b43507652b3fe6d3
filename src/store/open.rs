//! Opens files to read data from them. Only regular files are data.

use std::{
    fs::{self, File},
    io::{Error, ErrorKind, Read},
    path::Path,
};

use super::error::NotData;

/// Opens a file to read data from it. Links are followed, but only a regular file is opened: a device may never end,
/// and opening a pipe would wait for its writer.
///
/// # Errors
/// [`NotData`]; I/O errors.
pub(super) fn open_regular(path: &Path) -> std::io::Result<File> {
    is_data(&fs::metadata(path)?)?;
    let file = File::open(path)?;
    // The name may lead to a different file by now.
    is_data(&file.metadata()?)?;
    Ok(file)
}

/// Returns the error [`NotData`] for anything but a regular file.
pub(super) fn is_data(metadata: &fs::Metadata) -> std::io::Result<()> {
    match metadata.file_type() {
        found if found.is_file() => Ok(()),
        found => Err(Error::other(if found.is_dir() { NotData::Folder } else { NotData::Special })),
    }
}

/// Reads a whole regular file of at most `most` bytes.
///
/// # Errors
/// The same errors as [`open_regular`]; [`NotData::TooLarge`].
pub(super) fn read_regular(path: &Path, most: u64) -> std::io::Result<Vec<u8>> {
    read_at_most(&mut open_regular(path)?, most)
}

/// Reads a whole open file of at most `most` bytes.
///
/// # Errors
/// [`NotData::TooLarge`]; [`ErrorKind::UnexpectedEof`] if the file has more bytes than could be read; I/O errors.
pub(super) fn read_at_most(file: &mut File, most: u64) -> std::io::Result<Vec<u8>> {
    let size = file.metadata()?.len();
    let mut bytes = Vec::new();
    if size <= most {
        // The limit also holds for a file that grows, and for a system file that reports no length.
        file.by_ref().take(most.saturating_add(1)).read_to_end(&mut bytes)?;
        // A failing disk or network share can end a file early, and nothing may follow from a part of it. Another program
        // may have made the file shorter.
        let read = bytes.len() as u64;
        if read < size && read < file.metadata()?.len() {
            let message = format!("the file ended after {read} of {size} bytes");
            return Err(Error::new(ErrorKind::UnexpectedEof, message));
        }
    }
    let size = size.max(bytes.len() as u64);
    if size > most { Err(Error::other(NotData::TooLarge { size, most })) } else { Ok(bytes) }
}

/// Maximum number of bytes of a packed file, and of what it unpacks to.
pub(super) const MAX_UNPACKED: u64 = 64 << 20;

/// Unpacks all that a reader has, if it is at most `most` bytes.
///
/// # Errors
/// Says what is wrong and what is expected.
pub(super) fn unpacked(reader: impl Read, most: u64) -> Result<Vec<u8>, String> {
    let mut bytes = Vec::new();
    let read = reader.take(most + 1).read_to_end(&mut bytes);
    read.map_err(|error| format!("cannot be unpacked: {error}; expected a complete file"))?;
    if bytes.len() as u64 > most {
        return Err(format!("unpacks to more than {MAX_UNPACKED} bytes; expected fewer: unpack it first"));
    }
    Ok(bytes)
}
