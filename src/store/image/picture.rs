//! Reads any PNG as light: what its codes mean, and where that is said.

use std::{io::BufReader, path::Path};

use png::{ColorType, Decoder, Info};

use super::read::{content, decode};
use crate::{
    light::{CodeImage, Transfer, TransferTable, Transfers},
    stimulus::recipe::MAX_SIZE,
    store::{FileErrors, StoreError, error::io, open::open_regular},
    vision,
};

/// Maximum number of pixels of a picture, unless the user allows more. A 4K screen has 8.3 million.
pub const MAX_PIXELS: u64 = 4096 * 4096;
/// Points at which the tone curve of a color profile is read.
const CURVE_POINTS: u16 = 1024;
/// Maximum size of a color profile, bytes; those that screens and printers have are smaller.
const MAX_PROFILE: usize = 8 << 20;

/// The codes of a picture, and what they mean.
#[derive(Clone, Debug)]
pub struct Picture {
    pub codes: CodeImage,
    pub transfers: Transfers,
    /// The luminance of full red, green and blue relative to white.
    pub weights: [f64; 3],
    /// Where the meaning of the codes comes from.
    pub origin: Origin,
}

/// Where the meaning of a picture's codes comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Origin {
    /// The user said it.
    Given,
    /// The file says it, in this chunk.
    Chunk(&'static str),
    /// Nobody says it: sRGB is assumed.
    Assumed,
}

impl Picture {
    /// Returns codes whose meaning the user knows.
    #[must_use]
    pub fn given(codes: CodeImage, transfers: Transfers) -> Picture {
        Picture { codes, transfers, weights: SRGB.map(vision::luminance), origin: Origin::Given }
    }

    /// Returns the relative luminance of each pixel, row by row, 1 for white.
    #[must_use]
    pub fn luminances(&self) -> Vec<f64> {
        let light = self.codes.light(&self.transfers);
        let sum =
            |pixel: &[f32]| pixel.iter().zip(self.weights).map(|(light, weight)| f64::from(*light) * weight).sum();
        light.data.chunks_exact(3).map(sum).collect()
    }
}

/// Full red, green and blue.
const SRGB: [[f32; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// Reads an opaque PNG (gray, color or palette) of at most `pixels` pixels. Unless `transfers` says what its codes mean,
/// the file does: its iCCP, sRGB or gAMA chunk, in this order (PNG, 3rd edition). If it has none, sRGB is assumed.
///
/// # Errors
/// The file is not readable, not a complete PNG, too large, or not opaque, and its background is unknown; or its codes
/// mean something that is not supported (a cICP chunk; a color profile that is neither gray nor a matrix with curves).
pub fn read_picture(path: &Path, transfers: Option<&Transfers>, pixels: u64) -> Result<Picture, StoreError> {
    parse_picture(&path.display().to_string(), &content(path)?, transfers, pixels)
}

/// Reads the content of a PNG like [`read_picture`]; `name` identifies it in messages.
///
/// # Errors
/// The same errors as [`read_picture`].
pub fn parse_picture(
    name: &str,
    content: &[u8],
    transfers: Option<&Transfers>,
    pixels: u64,
) -> Result<Picture, StoreError> {
    let (codes, info) = decode(name, content, pixels, transfers.is_none(), |_| Ok(MAX_SIZE))?;
    if let Some(transfers) = transfers {
        return Ok(Picture::given(codes, transfers.clone()));
    }
    let (transfers, weights, origin) = declared(&info).map_err(|message| FileErrors::whole(name, message))?;
    Ok(Picture { codes, transfers, weights, origin })
}

/// Returns what a file says about its codes.
fn declared(info: &Info<'_>) -> Result<(Transfers, [f64; 3], Origin), String> {
    let srgb = SRGB.map(vision::luminance);
    if let Some(points) = info.coding_independent_code_points {
        return Err(format!(
            "has a cICP chunk (primaries {}, transfer {}), which is not supported; expected an iCCP, sRGB or gAMA chunk, or --transfer",
            points.color_primaries, points.transfer_function
        ));
    }
    if let Some(profile) = &info.icc_profile {
        let is_gray = matches!(info.color_type, ColorType::Grayscale | ColorType::GrayscaleAlpha);
        let (transfers, weights) = of_profile(profile, is_gray)?;
        return Ok((transfers, weights, Origin::Chunk("iCCP")));
    }
    if info.srgb.is_some() {
        return Ok((Transfer::Srgb.into(), srgb, Origin::Chunk("sRGB")));
    }
    let Some(gamma) = info.gama_chunk else { return Ok((Transfer::Srgb.into(), srgb, Origin::Assumed)) };
    let transfer = match gamma.into_scaled() {
        100_000 => Transfer::Linear,
        scaled => Transfer::gamma(100_000.0 / f64::from(scaled))
            .map_err(|error| format!("has a gAMA chunk of {scaled}: {error}"))?,
    };
    Ok((transfer.into(), srgb, Origin::Chunk("gAMA")))
}

/// Reads the curves of a color profile, and how bright its primaries are.
fn of_profile(profile: &[u8], is_gray: bool) -> Result<(Transfers, [f64; 3]), String> {
    let fail = |what: &str| {
        format!("has a color profile {what}; expected a gray profile, or one with a matrix and curves, or --transfer")
    };
    if profile.len() > MAX_PROFILE {
        return Err(fail("that is too large"));
    }
    let read =
        moxcms::ColorProfile::new_from_slice(profile).map_err(|error| fail(&format!("that is damaged ({error})")))?;
    let curve = |curve: &Option<moxcms::ToneReprCurve>| -> Result<Transfer, String> {
        let curve = curve.as_ref().ok_or_else(|| fail("without curves"))?;
        let curve = curve.make_linear_evaluator().map_err(|error| fail(&format!("with a damaged curve ({error})")))?;
        let mut table: (Vec<f64>, Vec<f64>) = (vec![0.0], vec![0.0]);
        for i in 1..CURVE_POINTS {
            let encoded = f64::from(i) / f64::from(CURVE_POINTS - 1);
            let linear = f64::from(curve.evaluate_value(encoded as f32)).min(1.0);
            // Where a curve is level, only its ends are kept.
            if i == CURVE_POINTS - 1 || (linear > table.1[table.1.len() - 1] && linear < 1.0) {
                table.0.push(encoded);
                table.1.push(if i == CURVE_POINTS - 1 { 1.0 } else { linear });
            }
        }
        let table = TransferTable::new(table.0, table.1)
            .map_err(|error| fail(&format!("whose curve does not rise ({error})")))?;
        Ok(Transfer::Table(table))
    };
    if is_gray {
        return Ok((curve(&read.gray_trc)?.into(), SRGB.map(vision::luminance)));
    }
    if read.color_space != moxcms::DataColorSpace::Rgb || read.lut_a_to_b_colorimetric.is_some() {
        return Err(fail("of another kind"));
    }
    let weights = [read.red_colorant, read.green_colorant, read.blue_colorant].map(|colorant| colorant.y);
    let white: f64 = weights.iter().sum();
    if weights.iter().any(|weight| *weight < 0.0) || white <= 0.0 {
        return Err(fail("without a matrix"));
    }
    let [red, green, blue] = [&read.red_trc, &read.green_trc, &read.blue_trc].map(curve);
    Ok((Transfers::new([red?, green?, blue?]), weights.map(|weight| weight / white)))
}

/// Returns the number of pixels that the header of an image states; 0 if it is not a PNG.
///
/// # Errors
/// The file cannot be opened.
pub fn pixels(path: &Path) -> Result<u64, StoreError> {
    let file = open_regular(path).map_err(io(path, "open"))?;
    let header = Decoder::new(BufReader::new(file)).read_info();
    Ok(header.map_or(0, |reader| u64::from(reader.info().width) * u64::from(reader.info().height)))
}
