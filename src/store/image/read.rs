//! Reads PNG files, and compares this program's own images with their recipes.

use std::{
    io::{BufReader, Cursor, ErrorKind},
    path::Path,
};

use png::{BitDepth, ColorType, Decoder, DecodingError, Info, Limits, Transformations};

use super::write::{KEYWORD, SHADED_KEYWORD, recipe_png};
use crate::{
    light::{CodeImage, Samples, Transfer},
    stimulus::recipe::{Finish, MAX_SIZE, Recipe},
    store::{FileErrors, StoreError, file::read_bytes, open::open_regular},
    system::unless_missing,
};

/// Maximum file size in bytes; more than the largest stimulus needs without compression.
const MAX_FILE: u64 = 2 << 30;
/// Maximum number of bytes that one byte of PNG data can expand to; DEFLATE reaches 1032.
const MAX_EXPANSION: usize = 1040;

/// Reads the content of an image file.
pub(super) fn content(path: &Path) -> Result<Vec<u8>, FileErrors> {
    read_bytes(path, MAX_FILE, "an image")
}

/// Decodes an opaque PNG of at most `pixels` pixels into its codes and its other chunks, with its color profile if
/// `profile` is true. `accept` sees the header before any pixel is decoded; it may return the reason why the image is
/// refused.
pub(super) fn decode(
    name: &str,
    content: &[u8],
    pixels: u64,
    profile: bool,
    accept: impl Fn(&Info<'_>) -> Result<(), String>,
) -> Result<(CodeImage, Info<'static>), StoreError> {
    let fail = |message: String| StoreError::from(FileErrors::whole(name, message));
    if !content.starts_with(b"\x89PNG\r\n\x1a\n") {
        return Err(fail(format!("is {}; expected a PNG", kind_of(content))));
    }
    let broken = |error: DecodingError| {
        // What follows is the crate's own name of the chunk.
        let error = error.to_string();
        let reason = error.split(" while decoding ").next().unwrap_or_default().trim_end_matches('.');
        fail(format!("is not a complete PNG: {reason}; expected an image"))
    };
    let mut decoder = Decoder::new_with_limits(Cursor::new(content), Limits { bytes: 512 << 20 });
    decoder.set_transformations(Transformations::EXPAND | Transformations::ALPHA);
    // A color profile may expand a thousandfold when it is decompressed.
    decoder.set_ignore_iccp_chunk(!profile);
    let mut reader = decoder.read_info().map_err(broken)?;
    let info = reader.info().clone();
    let (width, height) = (info.width, info.height);
    accept(&info).map_err(fail)?;
    if width.max(height) > MAX_SIZE {
        return Err(fail(format!("has {width} × {height} pixels; expected at most {MAX_SIZE} per side")));
    }
    if u64::from(width) * u64::from(height) > pixels {
        let message = format!("has {width} × {height} pixels; expected at most {pixels} pixels");
        return Err(StoreError::Refused(FileErrors::whole(name, message), "large"));
    }
    if info.animation_control.is_some_and(|animation| animation.num_frames > 1) {
        return Err(fail("is animated; expected one picture".to_owned()));
    }
    let (color, depth) = reader.output_color_type();
    // Samples per pixel with its alpha, and how often each of the others is repeated.
    let (channels, copies) = if color == ColorType::GrayscaleAlpha { (2, 3) } else { (4, 1) };
    // Without this check, a small file that claims to contain a huge image would exhaust the memory.
    if info.raw_bytes() > content.len().saturating_mul(MAX_EXPANSION) {
        return Err(fail(format!("is too short for {width} × {height} pixels; expected a complete PNG")));
    }
    let size = reader.output_buffer_size().unwrap_or_default();
    let mut raw = vec![0; size];
    reader.next_frame(&mut raw).map_err(broken)?;
    if is_beyond_palette(content, &info).map_err(broken)? {
        return Err(fail("has a pixel whose color is not in its palette; expected a color of the palette".to_owned()));
    }
    let transparent =
        || fail("has transparent pixels, and their background is not known; expected an opaque image".to_owned());
    let samples = if depth == BitDepth::Sixteen {
        let codes: Vec<u16> = raw.as_chunks::<2>().0.iter().map(|pair| u16::from_be_bytes(*pair)).collect();
        Samples::Sixteen(colors(&codes, channels, copies, u16::MAX).ok_or_else(transparent)?)
    } else {
        Samples::Eight(colors(&raw, channels, copies, u8::MAX).ok_or_else(transparent)?)
    };
    Ok((CodeImage { width, height, samples }, info))
}

/// Says what a file is that is not a PNG.
fn kind_of(content: &[u8]) -> &'static str {
    match content {
        [0xff, 0xd8, 0xff, ..] => "a JPEG image",
        [b'G', b'I', b'F', b'8', ..] => "a GIF image",
        [b'B', b'M', ..] => "a BMP image",
        [b'I', b'I', b'*' | b'+', 0, ..] | [b'M', b'M', 0, b'*' | b'+', ..] => "a TIFF image",
        [b'R', b'I', b'F', b'F', _, _, _, _, b'W', b'E', b'B', b'P', ..] => "a WebP image",
        [0x76, 0x2f, 0x31, 0x01, ..] => "an OpenEXR image",
        _ => "not a PNG",
    }
}

/// True if the palette has no color for a pixel: the crate makes such pixels black.
fn is_beyond_palette(content: &[u8], info: &Info<'_>) -> Result<bool, DecodingError> {
    let colors = info.palette.as_ref().map_or(0, |palette| palette.len() / 3);
    let bits = info.bit_depth as usize;
    if info.color_type != ColorType::Indexed || colors >= 1 << bits {
        return Ok(false);
    }
    // Without transformations, codes are indices.
    let mut decoder = Decoder::new_with_limits(Cursor::new(content), Limits { bytes: 512 << 20 });
    decoder.set_ignore_iccp_chunk(true);
    let mut reader = decoder.read_info()?;
    let mut raw = vec![0; reader.output_buffer_size().unwrap_or_default()];
    let line = reader.next_frame(&mut raw)?.line_size.max(1);
    let index = |row: &[u8], x: usize| row[x * bits / 8] >> (8 - bits - x * bits % 8) & (u8::MAX >> (8 - bits));
    let is_beyond = |row: &[u8]| (0..info.width as usize).any(|x| usize::from(index(row, x)) >= colors);
    Ok(raw.chunks_exact(line).any(is_beyond))
}

/// Returns red, green and blue of each pixel without its alpha; `None` if a pixel is not opaque.
fn colors<T: Copy + PartialEq>(samples: &[T], channels: usize, copies: usize, opaque: T) -> Option<Vec<T>> {
    let pixels = samples.chunks_exact(channels);
    if pixels.clone().any(|pixel| pixel[channels - 1] != opaque) {
        return None;
    }
    let mut colors = Vec::with_capacity(3 * pixels.len());
    pixels.for_each(|pixel| colors.extend([0, 1, 2].map(|channel| pixel[channel / copies])));
    Some(colors)
}

fn text(info: &Info<'_>, keyword: &str) -> Option<String> {
    let chunks = &info.uncompressed_latin1_text;
    chunks.iter().find(|chunk| chunk.keyword == keyword).map(|chunk| chunk.text.clone())
}

/// Returns the recipe's text in an image file without reading the pixels; `None` if there is no file or no recipe.
///
/// # Errors
/// I/O errors.
pub(crate) fn recipe_text(path: &Path) -> std::io::Result<Option<String>> {
    let Some(file) = unless_missing(open_regular(path))? else { return Ok(None) };
    match Decoder::new(BufReader::new(file)).read_info() {
        Ok(reader) => Ok(text(reader.info(), KEYWORD)),
        // A file that ends too early is not an image of ours.
        Err(DecodingError::IoError(error)) if error.kind() != ErrorKind::UnexpectedEof => Err(error),
        Err(_) => Ok(None),
    }
}

/// Returns the valid recipe in the header of an image.
fn recipe_of(info: &Info<'_>) -> Result<Recipe, String> {
    let recipe =
        text(info, KEYWORD).ok_or("has no text chunk `machband`; expected an image that machband wrote".to_owned())?;
    let recipe: Recipe = serde_json::from_str(&recipe)
        .map_err(|error| format!("its text chunk `machband` cannot be read: {error}; expected a recipe"))?;
    let joined = |errors: Vec<_>| errors.iter().map(ToString::to_string).collect::<Vec<_>>().join("; ");
    recipe.stimulus.validate().map_err(joined)?;
    Ok(recipe)
}

/// Verifies an image of at most `pixels` pixels by re-rendering its recipe and comparing every code. Returns a sentence
/// that describes the image.
///
/// # Errors
/// The file is not readable, is not a PNG from this program, or is too large; or its codes differ.
pub fn verify(path: &Path, pixels: u64) -> Result<String, StoreError> {
    verify_content(&path.display().to_string(), &content(path)?, pixels)
}

/// Verifies the content of an image, like [`verify`]; `name` identifies it in messages.
///
/// # Errors
/// The same errors as [`verify`].
pub fn verify_content(name: &str, content: &[u8], pixels: u64) -> Result<String, StoreError> {
    let fail = |message: String| StoreError::from(FileErrors::whole(name, message));
    let (image, info) = decode(name, content, pixels, false, |info| {
        if let Some(parameters) = text(info, SHADED_KEYWORD) {
            return Err(format!(
                "is a shaded mesh, which cannot be verified; expected an image written by `stimulus` or `stimuli`. It was made with {parameters}"
            ));
        }
        recipe_of(info).map(drop)
    })?;
    let recipe = recipe_of(&info).map_err(fail)?;
    let (width, height, side) = (image.width, image.height, recipe.side());
    if (width, height) != (side, side) {
        return Err(fail(format!("has {width} × {height} pixels; expected {side} per side, according to its recipe")));
    }
    let made = recipe_png(Path::new(name), &recipe, &recipe.quantizer())?;
    let (expected, _) = decode(name, &made, u64::MAX, false, |_| Ok(()))?;
    if image != expected {
        return Err(fail("has other codes than its recipe makes; expected an image that nobody changed".to_owned()));
    }
    let Recipe { stimulus, size, bits, dither, transfers, finish, .. } = &recipe;
    let transfer = match transfers.uniform() {
        Some(Transfer::Table(_)) => "measured table".to_owned(),
        _ => transfers.to_string(),
    };
    let finish = match finish {
        None => String::new(),
        Some(Finish::Palette(reduction)) => format!(", palette {reduction}"),
        Some(Finish::Halftone(screen)) => format!(", halftone {screen}"),
    };
    let kind = stimulus.kind();
    Ok(format!(
        "image of {kind}, {size} pixels per side, {bits} bits, {transfer}, dither {dither}{finish}: every code matches its recipe"
    ))
}
