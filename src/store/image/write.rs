//! Writes images as PNG, in grayscale if possible, with the meaning of the codes and the recipe.

use std::{borrow::Cow, path::Path};

use crate::{
    light::{CodeImage, Quantizer, Samples, Transfer, Transfers, dither::enlarged, palette::reduce},
    stimulus::recipe::{Finish, MAX_SIZE, Recipe},
    store::{FileErrors, StoreError, Writer, error::io, file::sha256},
};

/// Keyword of the text chunk that holds the recipe as JSON.
pub(super) const KEYWORD: &str = "machband";
/// Keyword of the text chunk that holds the parameters of a shaded mesh as JSON.
pub(super) const SHADED_KEYWORD: &str = "machband-shading";
/// Chromaticities of D65 and of the sRGB primaries (IEC 61966-2-1), in hundred-thousandths as PNG requires.
const SRGB_CHROMATICITIES: [[u32; 2]; 4] = [[31_270, 32_900], [64_000, 33_000], [30_000, 60_000], [15_000, 6_000]];
/// Number of entries in each tone curve of an embedded profile.
const CURVE_POINTS: u16 = 4096;
/// Where a profile has the date of its creation: year, month, day, hours, minutes and seconds, two bytes each.
const PROFILE_DATE: std::ops::Range<usize> = 24..36;

/// Renders a recipe and writes it as a PNG.
///
/// # Errors
/// The same errors as [`recipe_png`] and [`Writer::write`].
pub fn write_recipe(writer: &Writer, path: &Path, recipe: &Recipe, quantizer: &Quantizer) -> Result<(), StoreError> {
    writer.write(path, &recipe_png(path, recipe, quantizer)?)
}

/// Renders a recipe as the content of the PNG file at `path`.
///
/// # Errors
/// The image is too large for a PNG, or a halftone would have more than [`MAX_SIZE`] pixels on a side; or the recipe has 16
/// bits, which a palette cannot have.
pub fn recipe_png(path: &Path, recipe: &Recipe, quantizer: &Quantizer) -> Result<Vec<u8>, StoreError> {
    let (transfers, texts) = (&recipe.transfers, [(KEYWORD, describe(recipe))]);
    let png = match recipe.finish {
        None => encode(&recipe.codes(quantizer), transfers, &texts),
        Some(Finish::Palette(reduction)) => {
            let image = reduce(&recipe.codes(quantizer), transfers, reduction).map_err(|error| failed(path, error))?;
            let mut info = png::Info::with_size(recipe.size, recipe.size);
            info.color_type = png::ColorType::Indexed;
            info.palette = Some(Cow::Owned(image.palette.concat()));
            with_meaning(info, transfers, false, &texts, &image.indices)
        }
        Some(Finish::Halftone(screen)) => {
            let side = recipe.side();
            if side > MAX_SIZE {
                let message = format!("the halftone {screen} has {side} pixels on a side; expected at most {MAX_SIZE}");
                return Err(FileErrors::whole(path, message).into());
            }
            encode(&enlarged(&recipe.linear(), screen, transfers), transfers, &texts)
        }
    };
    png.map_err(|error| failed(path, error))
}

/// Writes codes for a screen with these transfer functions; of a shaded mesh, with the `parameters` it was made with.
///
/// # Errors
/// The same errors as [`Writer::write`].
pub fn write_codes(
    writer: &Writer,
    path: &Path,
    image: &CodeImage,
    transfers: &Transfers,
    parameters: Option<&serde_json::Value>,
) -> Result<(), StoreError> {
    // Text chunks are Latin-1, but the path of a mesh may contain any character; JSON can escape it in ASCII.
    let escape = |c: char| {
        let units = |c: char| c.encode_utf16(&mut [0; 2]).iter().map(|u| format!("\\u{u:04x}")).collect::<String>();
        if c.is_ascii() { c.to_string() } else { units(c) }
    };
    let text = parameters.map(|given| (SHADED_KEYWORD, given.to_string().chars().map(escape).collect()));
    writer.write(path, &encode(image, transfers, text.as_slice()).map_err(|error| failed(path, error))?)
}

/// Returns the SHA-256 of an image's codes, in lowercase hexadecimal. The order is row by row from the top left, with
/// red, green and blue for each pixel; 16-bit codes have their high byte first.
pub fn hash(image: &CodeImage) -> String {
    sha256(&raw_samples(&image.samples, false))
}

fn failed(path: &Path, error: impl Into<Box<dyn std::error::Error + Send + Sync>>) -> StoreError {
    io(path, "encode")(std::io::Error::other(error))
}

/// Returns the recipe as the text that an image contains.
pub fn describe(recipe: &Recipe) -> String {
    serde_json::to_string(recipe).unwrap_or_default()
}

/// Encodes an image as the bytes of a PNG file. The same input always gives the same bytes.
fn encode(image: &CodeImage, transfers: &Transfers, texts: &[(&str, String)]) -> Result<Vec<u8>, png::EncodingError> {
    // Equal codes mean gray only if the channels have the same transfer function.
    let gray = transfers.uniform().is_some() && is_gray(&image.samples);
    let mut info = png::Info::with_size(image.width, image.height);
    info.color_type = if gray { png::ColorType::Grayscale } else { png::ColorType::Rgb };
    info.bit_depth = match image.samples {
        Samples::Eight(_) => png::BitDepth::Eight,
        Samples::Sixteen(_) => png::BitDepth::Sixteen,
    };
    with_meaning(info, transfers, gray, texts, &raw_samples(&image.samples, gray))
}

/// Adds the meaning of the codes and the recipe, and encodes the image.
fn with_meaning(
    mut info: png::Info<'_>,
    transfers: &Transfers,
    gray: bool,
    texts: &[(&str, String)],
    samples: &[u8],
) -> Result<Vec<u8>, png::EncodingError> {
    let curve = match transfers.uniform() {
        Some(Transfer::Srgb) => None,
        Some(Transfer::Linear) => Some(1.0),
        Some(Transfer::Gamma(gamma)) => Some(*gamma),
        Some(Transfer::Gog(_) | Transfer::Table(_)) | None => {
            let profile = profile(transfers, gray).map_err(std::io::Error::other)?;
            info.icc_profile = Some(Cow::Owned(profile));
            None
        }
    };
    if let Some(gamma) = curve {
        let [white, red, green, blue] = SRGB_CHROMATICITIES.map(|pair| pair.map(png::ScaledFloat::from_scaled).into());
        info.source_gamma = Some(png::ScaledFloat::from_scaled((100_000.0 / gamma).round() as u32));
        info.source_chromaticities = Some(png::SourceChromaticities { white, red, green, blue });
    }
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::with_info(&mut bytes, info)?;
    if transfers.uniform() == Some(&Transfer::Srgb) {
        encoder.set_source_srgb(png::SrgbRenderingIntent::RelativeColorimetric);
    }
    // Neighboring rows of a stimulus are almost equal, so their differences are mostly zero and fast compression is
    // enough.
    encoder.set_compression(png::Compression::Fast);
    encoder.set_filter(png::Filter::Up);
    for (keyword, text) in texts {
        encoder.add_text_chunk((*keyword).to_owned(), text.clone())?;
    }
    let mut writer = encoder.write_header()?;
    writer.write_image_data(samples)?;
    writer.finish()?;
    Ok(bytes)
}

fn is_gray(samples: &Samples) -> bool {
    fn equal<T: PartialEq>(codes: &[T]) -> bool {
        codes.chunks_exact(3).all(|pixel| pixel[0] == pixel[1] && pixel[1] == pixel[2])
    }
    match samples {
        Samples::Eight(codes) => equal(codes),
        Samples::Sixteen(codes) => equal(codes),
    }
}

/// Returns the samples as PNG stores them: one per pixel for gray, and 16-bit samples with the most significant byte
/// first.
fn raw_samples(samples: &Samples, gray: bool) -> Cow<'_, [u8]> {
    let step = if gray { 3 } else { 1 };
    match samples {
        Samples::Eight(codes) if !gray => Cow::Borrowed(codes),
        Samples::Eight(codes) => codes.iter().step_by(step).copied().collect(),
        Samples::Sixteen(codes) => codes.iter().step_by(step).flat_map(|code| code.to_be_bytes()).collect(),
    }
}

/// Returns the measured transfer functions as an ICC profile with the sRGB primaries.
fn profile(transfers: &Transfers, gray: bool) -> Result<Vec<u8>, moxcms::CmsError> {
    let curve = |transfer: &Transfer| {
        let points = (0..CURVE_POINTS).map(|i| {
            let linear = transfer.linear_from_encoded(f64::from(i) / f64::from(CURVE_POINTS - 1));
            (linear * f64::from(u16::MAX)).round() as u16
        });
        Some(moxcms::ToneReprCurve::Lut(points.collect()))
    };
    let [red, green, blue] = transfers.channels();
    let mut profile =
        if gray { moxcms::ColorProfile::new_gray_with_gamma(1.0) } else { moxcms::ColorProfile::new_srgb() };
    profile.cicp = None;
    if gray {
        profile.gray_trc = curve(red);
    } else {
        profile.red_trc = curve(red);
        profile.green_trc = curve(green);
        profile.blue_trc = curve(blue);
    }
    let mut bytes = profile.encode()?;
    // The crate writes the present time. A fixed date, so that the same input always gives the same bytes.
    bytes[PROFILE_DATE].copy_from_slice(&[0x07, 0xea, 0, 1, 0, 1, 0, 0, 0, 0, 0, 0]);
    Ok(bytes)
}
