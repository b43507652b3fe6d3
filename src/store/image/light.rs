//! Any PNG, as the light that it asks of a screen.

use std::{
    fs::File,
    io::{Cursor, Read as _},
    path::Path,
};

use crate::{
    light::{LinearImage, Transfers},
    store::FileFaults,
};

/// Largest side, pixels.
const SIDE_MAX: u32 = 8192;

/// Largest file, bytes: more than the largest image of ours takes without compression.
const FILE_MAX: u64 = 2 << 30;
/// How many bytes one byte of a PNG can become at most: what DEFLATE reaches is 1032.
const EXPANSION_MAX: usize = 1040;

/// Reads a PNG of any depth, gray, colour or palette; `transfers` says what a screen makes of its codes.
///
/// # Errors
/// Not readable, no whole PNG, too large, or with an alpha channel: what shows through it is not known.
pub fn read(path: &Path, transfers: &Transfers) -> Result<LinearImage, FileFaults> {
    parse(&path.display().to_string(), &content(path)?, transfers)
}

/// Reads the content of a PNG; `name` names it in messages.
///
/// # Errors
/// As [`read`].
pub fn parse(name: &str, content: &[u8], transfers: &Transfers) -> Result<LinearImage, FileFaults> {
    let fail = |message: String| FileFaults::whole(name, message);
    let broken = |error: png::DecodingError| fail(format!("is not a whole PNG: {error}; expected an image"));
    let mut decoder = png::Decoder::new_with_limits(Cursor::new(content), png::Limits { bytes: 512 << 20 });
    decoder.set_transformations(png::Transformations::EXPAND);
    let mut reader = decoder.read_info().map_err(broken)?;
    let (width, height) = (reader.info().width, reader.info().height);
    if width.max(height) > SIDE_MAX {
        return Err(fail(format!("has {width} × {height} pixels; expected at most {SIDE_MAX} a side")));
    }
    let (color, depth) = reader.output_color_type();
    let channels = match color {
        png::ColorType::Grayscale => 1,
        png::ColorType::Rgb => 3,
        _ => {
            return Err(fail(
                "has an alpha channel, and what shows through it is not known; expected an opaque image".to_owned(),
            ));
        }
    };
    let mut raw = room(reader.output_buffer_size(), content.len()).map_err(fail)?;
    reader.next_frame(&mut raw).map_err(broken)?;
    let encoded: Vec<f64> = if depth == png::BitDepth::Sixteen {
        raw.as_chunks::<2>().0.iter().map(|pair| f64::from(u16::from_be_bytes(*pair)) / 65535.0).collect()
    } else {
        raw.iter().map(|code| f64::from(*code) / 255.0).collect()
    };
    let pixels = encoded.chunks_exact(channels).map(|pixel| [pixel[0], pixel[channels / 2], pixel[channels - 1]]);
    let data = pixels.flat_map(|pixel| transfers.linear_from_encoded(pixel).map(|light| light as f32)).collect();
    Ok(LinearImage { width, height, data })
}

/// The content of an image file.
pub(super) fn content(path: &Path) -> Result<Vec<u8>, FileFaults> {
    let fail = |message: String| FileFaults::whole(path.display().to_string(), message);
    let mut content = Vec::new();
    File::open(path)
        .and_then(|file| file.take(FILE_MAX + 1).read_to_end(&mut content))
        .map_err(|error| fail(format!("cannot be opened: {error}; expected a readable file")))?;
    if content.len() as u64 > FILE_MAX {
        return Err(fail(format!("has more than {FILE_MAX} bytes; expected an image")));
    }
    Ok(content)
}

/// Room for the pixels of an image that says to need `size` bytes and comes in `from`. A small file that promises a huge
/// image would otherwise take the memory before it is found not to keep it.
pub(super) fn room(size: Option<usize>, from: usize) -> Result<Vec<u8>, String> {
    match size {
        Some(size) if size <= from.saturating_mul(EXPANSION_MAX) => Ok(vec![0; size]),
        Some(size) => Err(format!("is too short for {size} bytes of pixels; expected a whole PNG")),
        None => Err("is too large; expected an image that fits in memory".to_owned()),
    }
}
