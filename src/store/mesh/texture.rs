//! Decodes the textures of meshes.

use std::io::Cursor;

use png::{ColorType, Decoder, Transformations};
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

/// Decodes a PNG or JPEG image of at most `most` pixels.
///
/// # Errors
/// A sentence without its subject: the content is of neither format, is damaged or has too many pixels.
pub(super) fn decode(content: &[u8], most: usize) -> Result<Pixels, String> {
    let pixels = if content.starts_with(b"\x89PNG") { png(content, most) } else { jpeg(content, most) }?;
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
    let damaged = |error| format!("is not a PNG or JPEG image ({error}); expected one");
    let options = DecoderOptions::default().jpeg_set_out_colorspace(ColorSpace::RGB);
    let mut decoder = JpegDecoder::new_with_options(ZCursor::new(content), options);
    decoder.decode_headers().map_err(|error| damaged(error.to_string()))?;
    let (width, height) = decoder.dimensions().ok_or_else(|| damaged("no size".to_owned()))?;
    check(width, height, most)?;
    let codes = decoder.decode().map_err(|error| damaged(error.to_string()))?;
    Ok(Pixels { width: width as u32, height: height as u32, codes: codes.as_chunks().0.to_vec() })
}
