//! Decodes the textures of meshes, and says where on a mesh they lie.

use std::io::Cursor;

use glam::{DAffine2, DVec2};
use png::{ColorType, Decoder, Transformations};
use serde_json::Value;
use zune_jpeg::{
    JpegDecoder,
    zune_core::{bytestream::ZCursor, colorspace::ColorSpace, options::DecoderOptions},
};

/// Maximum number of texels of all textures of a mesh, as many as 4096 × 4096: each needs 12 bytes.
pub(super) const MAX_TEXELS: usize = 1 << 24;

/// An image with 8 bits for each of red, green and blue.
pub(super) struct Pixels {
    pub width: u32,
    pub height: u32,
    pub codes: Vec<[u8; 3]>,
}

/// Where a texture lies: a set of texture coordinates, and what `KHR_texture_transform` does to them.
#[derive(Clone, Copy, PartialEq)]
pub(super) struct TexturePlace {
    pub set: u32,
    pub placed: DAffine2,
}

impl TexturePlace {
    /// Reads the extension of a material's texture whose own set is `set`.
    ///
    /// # Errors
    /// The extension is not valid.
    pub fn new(set: u32, transform: Option<&Value>) -> Result<Self, String> {
        let Some(transform) = transform else { return Ok(Self { set, placed: DAffine2::IDENTITY }) };
        let read = || {
            let two = |name: &str, missing: f64| match transform.get(name) {
                None => Some(DVec2::splat(missing)),
                Some(value) => Some(DVec2::new(value.get(0)?.as_f64()?, value.get(1)?.as_f64()?)),
            };
            let angle = transform.get("rotation").map_or(Some(0.0), Value::as_f64)?;
            let set = transform.get("texCoord").map_or(Some(u64::from(set)), Value::as_u64)?;
            // The angle turns the image clockwise, and v points down.
            let placed = DAffine2::from_scale_angle_translation(two("scale", 1.0)?, -angle, two("offset", 0.0)?);
            Some(Self { set: u32::try_from(set).ok()?, placed })
        };
        read().ok_or_else(|| {
            "a KHR_texture_transform is not valid; expected two numbers for offset and scale, and a number for rotation".to_owned()
        })
    }
}

/// Decodes a PNG or JPEG image of at most `most` pixels.
///
/// # Errors
/// A sentence without its subject: the content is of neither format, is damaged or has too many pixels.
pub(super) fn decode(content: &[u8], most: usize) -> Result<Pixels, String> {
    let pixels = match content {
        [0x89, b'P', b'N', b'G', ..] => png(content, most)?,
        [0xff, 0xd8, ..] => jpeg(content, most)?,
        _ => return Err("is neither a PNG nor a JPEG image; expected one of them".to_owned()),
    };
    let count = u64::from(pixels.width) * u64::from(pixels.height);
    if count == 0 || pixels.codes.len() as u64 != count {
        return Err("is damaged; expected a PNG or JPEG image".to_owned());
    }
    Ok(pixels)
}

fn check(width: usize, height: usize, most: usize) -> Result<(), String> {
    if width.saturating_mul(height) > most {
        return Err(format!("has {width} × {height} pixels; expected at most {MAX_TEXELS} in all images together"));
    }
    Ok(())
}

fn png(content: &[u8], most: usize) -> Result<Pixels, String> {
    let damaged = |error: png::DecodingError| format!("is not a PNG image ({error}); expected one");
    let mut decoder = Decoder::new(Cursor::new(content));
    decoder.set_transformations(Transformations::EXPAND | Transformations::STRIP_16);
    let mut reader = decoder.read_info().map_err(damaged)?;
    check(reader.info().width as usize, reader.info().height as usize, most)?;
    let size = reader.output_buffer_size().ok_or("is too large for this machine; expected a smaller image")?;
    let mut codes = vec![0; size];
    let frame = reader.next_frame(&mut codes).map_err(damaged)?;
    codes.truncate(frame.buffer_size());
    let codes = match frame.color_type {
        ColorType::Grayscale => codes.iter().map(|gray| [*gray; 3]).collect(),
        ColorType::GrayscaleAlpha => codes.as_chunks().0.iter().map(|[gray, _]| [*gray; 3]).collect(),
        ColorType::Rgba => codes.as_chunks().0.iter().map(|[r, g, b, _]| [*r, *g, *b]).collect(),
        ColorType::Rgb | ColorType::Indexed => codes.as_chunks().0.to_vec(),
    };
    Ok(Pixels { width: frame.width, height: frame.height, codes })
}

fn jpeg(content: &[u8], most: usize) -> Result<Pixels, String> {
    let damaged = |error: String| format!("is not a JPEG image ({}); expected one", error.trim_end());
    let options = DecoderOptions::default().jpeg_set_out_colorspace(ColorSpace::RGB);
    let mut decoder = JpegDecoder::new_with_options(ZCursor::new(content), options);
    decoder.decode_headers().map_err(|error| damaged(error.to_string()))?;
    let (width, height) = decoder.dimensions().ok_or_else(|| damaged("no size".to_owned()))?;
    check(width, height, most)?;
    let codes = decoder.decode().map_err(|error| damaged(error.to_string()))?;
    Ok(Pixels { width: width as u32, height: height as u32, codes: codes.as_chunks().0.to_vec() })
}
