//! Any PNG, as the light that it asks of a screen.

use std::{fs::File, io::BufReader, path::Path};

use super::FileFaults;
use crate::light::{LinearImage, Transfers};

/// Largest side, pixels.
const SIDE_MAX: u32 = 8192;

/// Reads a PNG of any depth, gray, colour or palette; `transfers` says what a screen makes of its codes.
///
/// # Errors
/// Not readable, no whole PNG, too large, or with an alpha channel: what shows through it is not known.
pub fn read(path: &Path, transfers: &Transfers) -> Result<LinearImage, FileFaults> {
    let name = path.display().to_string();
    let fail = |message: String| FileFaults::whole(&name, message);
    let file =
        File::open(path).map_err(|error| fail(format!("cannot be opened: {error}; expected a readable file")))?;
    let broken = |error: png::DecodingError| fail(format!("is not a whole PNG: {error}; expected an image"));
    let mut decoder = png::Decoder::new_with_limits(BufReader::new(file), png::Limits { bytes: 512 << 20 });
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
    let size = reader
        .output_buffer_size()
        .ok_or_else(|| fail("is too large; expected an image that fits in memory".to_owned()))?;
    let mut raw = vec![0; size];
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
