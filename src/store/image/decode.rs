//! The codes and the text chunks of a PNG file.

use std::{io::Cursor, path::Path};

use png::{BitDepth, ColorType, Decoder, DecodingError, Info, Limits, Transformations};

use crate::{
    light::{CodeImage, LinearImage, Samples, Transfers},
    store::{FileFaults, text::read_bytes},
};

/// Largest side of an image that is taken as light, pixels.
const SIDE_MAX: u32 = 8192;
/// Largest file, bytes: more than the largest image of ours takes without compression.
const FILE_MAX: u64 = 2 << 30;
/// How many bytes one byte of a PNG can become at most: what DEFLATE reaches is 1032.
const EXPANSION_MAX: usize = 1040;

/// Reads any PNG, gray, color or palette, as the light that a screen makes of its codes.
///
/// # Errors
/// Not readable, not a whole PNG, too large, or with an alpha channel: what shows through it is not known.
pub fn read_light(path: &Path, transfers: &Transfers) -> Result<LinearImage, FileFaults> {
    parse_light(&path.display().to_string(), &content(path)?, transfers)
}

/// Reads the content of a PNG as light; `name` names it in messages.
///
/// # Errors
/// As [`read_light`].
pub fn parse_light(name: &str, content: &[u8], transfers: &Transfers) -> Result<LinearImage, FileFaults> {
    let (image, _) = decode(name, content, |_| SIDE_MAX)?;
    let encoded: Vec<f64> = match &image.samples {
        Samples::Eight(codes) => codes.iter().map(|code| f64::from(*code) / 255.0).collect(),
        Samples::Sixteen(codes) => codes.iter().map(|code| f64::from(*code) / 65535.0).collect(),
    };
    let pixels = encoded.as_chunks::<3>().0.iter();
    let data = pixels.flat_map(|pixel| transfers.linear_from_encoded(*pixel).map(|light| light as f32)).collect();
    Ok(LinearImage { width: image.width, height: image.height, data })
}

/// The content of an image file.
pub(super) fn content(path: &Path) -> Result<Vec<u8>, FileFaults> {
    read_bytes(path, FILE_MAX, "an image")
}

/// The codes of an opaque PNG, and the chunks around them. `side_max`: the largest side it may have.
pub(super) fn decode(
    name: &str,
    content: &[u8],
    side_max: impl Fn(&Info<'_>) -> u32,
) -> Result<(CodeImage, Info<'static>), FileFaults> {
    let fail = |message: String| FileFaults::whole(name, message);
    let broken = |error: DecodingError| fail(format!("is not a whole PNG: {error}; expected an image"));
    let mut decoder = Decoder::new_with_limits(Cursor::new(content), Limits { bytes: 512 << 20 });
    decoder.set_transformations(Transformations::EXPAND);
    let mut reader = decoder.read_info().map_err(broken)?;
    let info = reader.info().clone();
    let (width, height, side_max) = (info.width, info.height, side_max(&info));
    if width.max(height) > side_max {
        return Err(fail(format!("has {width} × {height} pixels; expected at most {side_max} a side")));
    }
    let (color, depth) = reader.output_color_type();
    let copies = match color {
        ColorType::Grayscale => 3,
        ColorType::Rgb => 1,
        _ => {
            return Err(fail(
                "has an alpha channel, and what shows through it is not known; expected an opaque image".to_owned(),
            ));
        }
    };
    // Otherwise a small file that claims to hold a huge image would take the memory before the lie is found.
    let size = reader.output_buffer_size().filter(|size| *size <= content.len().saturating_mul(EXPANSION_MAX));
    let Some(size) = size else {
        return Err(fail(format!("is too short for {width} × {height} pixels; expected a whole PNG")));
    };
    let mut raw = vec![0; size];
    reader.next_frame(&mut raw).map_err(broken)?;
    let samples = if depth == BitDepth::Sixteen {
        let codes = raw.as_chunks::<2>().0.iter().map(|pair| u16::from_be_bytes(*pair));
        Samples::Sixteen(codes.flat_map(|code| std::iter::repeat_n(code, copies)).collect())
    } else if copies == 1 {
        Samples::Eight(raw)
    } else {
        Samples::Eight(raw.iter().flat_map(|code| std::iter::repeat_n(*code, copies)).collect())
    };
    Ok((CodeImage { width, height, samples }, info))
}
