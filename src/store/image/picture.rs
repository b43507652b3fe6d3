//! Reads any PNG as light: what its codes mean, and what says so.

use std::path::{Path, PathBuf};

use png::{ColorType, Info};

use super::read::{content, decode};
use crate::{
    display::Primaries,
    light::{CodeImage, Transfer, TransferTable, Transfers},
    store::{FileErrors, StoreError, error::io},
    system::{entries, found},
    vision::SRGB_WEIGHTS,
};

/// Maximum number of pixels of a picture, unless the user allows more. A 4K screen has 8.3 million.
pub const MAX_PIXELS: u64 = 4096 * 4096;
/// Points at which the tone curve of a color profile is read.
const CURVE_POINTS: u16 = 1024;
/// How far the ends of a tone curve may be from 0 and 1.
const ENDS: f64 = 0.01;
/// Maximum size of a color profile, bytes; those that screens and printers have are smaller.
const MAX_PROFILE: usize = 8 << 20;

/// The codes of a picture, and what they mean.
#[derive(Clone, Debug)]
pub struct Picture {
    pub codes: CodeImage,
    pub transfers: Transfers,
    /// The luminance of full red, green and blue relative to white.
    pub weights: [f64; 3],
    /// Where the meaning of the codes comes from, in words.
    pub origin: &'static str,
    /// The number of bits of a code in the file.
    pub bits: u32,
    /// The number of those that mean something, as far as the file says.
    pub significant_bits: u32,
}

/// Nobody says what codes mean.
pub const ASSUMED: &str = "sRGB is assumed, because nothing says what the codes mean";

impl Picture {
    /// Returns codes whose meaning the user knows.
    pub fn given(codes: CodeImage, transfers: Transfers) -> Picture {
        let bits = codes.bits();
        Picture { codes, transfers, weights: SRGB_WEIGHTS, origin: "as asked", bits, significant_bits: bits }
    }

    /// True if the primaries are sRGB's but for rounding.
    pub fn is_srgb(&self) -> bool {
        are_srgb(self.weights)
    }
}

/// True if primaries of these luminances are sRGB's but for rounding.
fn are_srgb(weights: [f64; 3]) -> bool {
    weights.iter().zip(SRGB_WEIGHTS).all(|(own, srgb)| (own - srgb).abs() <= 1e-3)
}

/// The luminance under D65 of the XYZ that a profile has under D50: a row of the inverse of Bradford's adaptation.
const LUMINANCE_FROM_D50: [f64; 3] = [-0.028_369_697_284_554_4, 1.009_995_320_871_526_9, 0.021_041_443_482_574_77];

/// Reads an opaque PNG (gray, color or palette) of at most `pixels` pixels. Unless `transfers` says what its codes mean,
/// the file does: its iCCP, sRGB or gAMA chunk, in this order (PNG, 3rd edition); with gAMA or alone, cHRM says how bright
/// the primaries are. What no chunk says is assumed to be sRGB's.
///
/// # Errors
/// The file is not readable, not a complete PNG, too large, or not opaque, and its background is unknown; or its codes
/// mean something that is not supported (a cICP chunk; a color profile that is neither gray nor a matrix with curves); or
/// it is not stored upright.
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
    let (codes, info) = decode(name, content, pixels, transfers.is_none(), |_| Ok(()))?;
    let exif = chunks(content).find(|(kind, _)| *kind == b"eXIf");
    if let Some(orientation @ 2..=8) = exif.and_then(|(_, exif)| orientation(exif)) {
        let message = format!(
            "must be rotated or mirrored for display (orientation {orientation} in its eXIf chunk); expected a picture that is stored upright"
        );
        return Err(FileErrors::whole(name, message).into());
    }
    // The bits of a palette's indices are not those of its colors.
    let bits = if info.color_type == ColorType::Indexed { 8 } else { info.bit_depth as u32 };
    let said = info.sbit.as_ref().and_then(|said| said.iter().max());
    let significant_bits = said.map_or(bits, |said| u32::from(*said).min(bits));
    if let Some(transfers) = transfers {
        return Ok(Picture { bits, significant_bits, ..Picture::given(codes, transfers.clone()) });
    }
    let unclear = |message| StoreError::Refused(FileErrors::whole(name, message), "transfer");
    undamaged(content, &info).map_err(unclear)?;
    let (transfers, weights, origin) = declared(&info).map_err(unclear)?;
    Ok(Picture { codes, transfers, weights, origin, bits, significant_bits })
}

/// Refuses a file with a chunk about its codes that could not be read: what is damaged is not absent.
fn undamaged(content: &[u8], info: &Info<'_>) -> Result<(), String> {
    let known = [
        ("iCCP", info.icc_profile.is_some()),
        ("sRGB", info.srgb.is_some()),
        ("gAMA", info.gama_chunk.is_some()),
        ("cHRM", info.chrm_chunk.is_some()),
        ("cICP", info.coding_independent_code_points.is_some()),
    ];
    let is_there = |name: &str| chunks(content).any(|(kind, _)| kind == name.as_bytes());
    known
        .into_iter()
        .find(|(name, is_read)| !is_read && is_there(name))
        .map_or(Ok(()), |(name, _)| Err(format!("has a damaged {name} chunk; expected what its codes mean")))
}

/// Returns the name and the data of each chunk of a PNG.
fn chunks(content: &[u8]) -> impl Iterator<Item = (&[u8; 4], &[u8])> {
    let mut rest = content.get(8..).unwrap_or_default();
    std::iter::from_fn(move || {
        let (length, after) = rest.split_first_chunk()?;
        let (kind, after) = after.split_first_chunk()?;
        let (data, after) = after.split_at_checked(u32::from_be_bytes(*length) as usize)?;
        // The data is followed by its checksum.
        rest = after.get(4..).unwrap_or_default();
        Some((kind, data))
    })
}

/// Returns the orientation that EXIF data state: 1 if the picture is stored upright.
fn orientation(exif: &[u8]) -> Option<usize> {
    let is_little = exif.starts_with(b"II");
    let number = |bytes: &[u8]| {
        let add = |sum: usize, byte: &u8| sum << 8 | usize::from(*byte);
        if is_little { bytes.iter().rev().fold(0, add) } else { bytes.iter().fold(0, add) }
    };
    let (count, entries) = exif.get(number(exif.get(4..8)?)..)?.split_first_chunk::<2>()?;
    let mut entries = entries.chunks_exact(12).take(number(count));
    Some(number(&entries.find(|entry| number(&entry[..2]) == 0x112)?[8..10]))
}

/// Returns what a file says about its codes.
fn declared(info: &Info<'_>) -> Result<(Transfers, [f64; 3], &'static str), String> {
    if let Some(points) = info.coding_independent_code_points {
        return Err(format!(
            "has a cICP chunk (primaries {}, transfer {}), which is not supported and comes before all others; expected a file without it",
            points.color_primaries, points.transfer_function
        ));
    }
    if let Some(profile) = &info.icc_profile {
        let is_gray = matches!(info.color_type, ColorType::Grayscale | ColorType::GrayscaleAlpha);
        let (transfers, weights) = of_profile(profile, is_gray)?;
        return Ok((transfers, weights, "by the file's iCCP chunk"));
    }
    if info.srgb.is_some() {
        return Ok((Transfer::Srgb.into(), SRGB_WEIGHTS, "by the file's sRGB chunk"));
    }
    let primaries = info.chrm_chunk.map(of_primaries).transpose()?;
    // What is sRGB's but for rounding is sRGB's.
    let own = primaries.filter(|own| !are_srgb(*own));
    let weights = own.unwrap_or(SRGB_WEIGHTS);
    let Some(gamma) = info.gama_chunk else {
        let origin = if primaries.is_some() { "by the file's cHRM chunk (with sRGB's curve)" } else { ASSUMED };
        return Ok((Transfer::Srgb.into(), weights, origin));
    };
    let transfer = match gamma.into_scaled() {
        100_000 => Transfer::Linear,
        scaled => Transfer::gamma(100_000.0 / f64::from(scaled))
            .map_err(|error| format!("has a gAMA chunk of {scaled}: {error}"))?,
    };
    let origin = if own.is_some() { "by the file's gAMA and cHRM chunks" } else { "by the file's gAMA chunk" };
    Ok((transfer.into(), weights, origin))
}

/// Returns the luminance of primaries relative to their white.
fn of_primaries(given: png::SourceChromaticities) -> Result<[f64; 3], String> {
    let xy = |(x, y): (png::ScaledFloat, png::ScaledFloat)| [x, y].map(|part| f64::from(part.into_scaled()) / 1e5);
    let [red, green, blue, white] = [given.red, given.green, given.blue, given.white].map(xy);
    let weights = Primaries { red, green, blue, white }.weights();
    weights.ok_or_else(|| "has a cHRM chunk of impossible primaries; expected those of a screen".to_owned())
}

/// Reads the curves of a color profile, and how bright its primaries are.
fn of_profile(profile: &[u8], is_gray: bool) -> Result<(Transfers, [f64; 3]), String> {
    let fail =
        |what: &str| format!("has a color profile {what}; expected a gray profile, or one with a matrix and curves");
    if profile.len() > MAX_PROFILE {
        return Err(fail("that is too large"));
    }
    let read =
        moxcms::ColorProfile::new_from_slice(profile).map_err(|error| fail(&format!("that is damaged ({error})")))?;
    let curve = |curve: &Option<moxcms::ToneReprCurve>| -> Result<Transfer, String> {
        let curve = curve.as_ref().ok_or_else(|| fail("without curves"))?;
        // One number is an exponent, in 256ths.
        if let moxcms::ToneReprCurve::Lut(points) = curve
            && let [gamma] = points[..]
        {
            return Transfer::gamma(f64::from(gamma) / 256.0).map_err(|error| fail(&format!("whose {error}")));
        }
        let curve = curve.make_linear_evaluator().map_err(|error| fail(&format!("with a damaged curve ({error})")))?;
        let at = |i: u16| f64::from(curve.evaluate_value(f32::from(i) / f32::from(CURVE_POINTS - 1)));
        let values: Vec<f64> = (0..CURVE_POINTS).map(at).collect();
        let [first, last] = [values[0], values[values.len() - 1]];
        if !(first.abs() <= ENDS && (last - 1.0).abs() <= ENDS && values.is_sorted()) {
            return Err(fail("whose curve does not rise from 0 to 1"));
        }
        let mut table: (Vec<f64>, Vec<f64>) = (vec![0.0], vec![0.0]);
        for (i, linear) in values.into_iter().enumerate().skip(1) {
            let is_last = i == usize::from(CURVE_POINTS - 1);
            // Where a curve is level, only its ends are kept.
            if is_last || (linear > table.1[table.1.len() - 1] && linear < 1.0) {
                table.0.push(i as f64 / f64::from(CURVE_POINTS - 1));
                table.1.push(if is_last { 1.0 } else { linear });
            }
        }
        let table = TransferTable::new(table.0, table.1)
            .map_err(|error| fail(&format!("whose curve does not rise ({error})")))?;
        Ok(Transfer::Table(table))
    };
    let gray = read.color_space == moxcms::DataColorSpace::Gray;
    if is_gray != gray {
        let [own, other] = if is_gray { ["colors", "gray"] } else { ["gray", "colors"] };
        return Err(format!(
            "has a color profile for {own}, but its pixels are {other}; expected a profile for {other}"
        ));
    }
    if is_gray {
        return Ok((curve(&read.gray_trc)?.into(), SRGB_WEIGHTS));
    }
    if read.color_space != moxcms::DataColorSpace::Rgb || read.lut_a_to_b_colorimetric.is_some() {
        return Err(fail("of another kind"));
    }
    // Colorants are adapted to D50 from the white of the screen, which is taken to be D65: some programs write a matrix of
    // another meaning where a profile would state its own adaptation.
    let luminance =
        |of: moxcms::Xyzd| [of.x, of.y, of.z].iter().zip(LUMINANCE_FROM_D50).map(|(a, b)| a * b).sum::<f64>();
    let weights = [read.red_colorant, read.green_colorant, read.blue_colorant].map(luminance);
    let white: f64 = weights.iter().sum();
    if !(weights.iter().all(|weight| *weight >= -ENDS) && white > 0.0) {
        return Err(fail("without a matrix"));
    }
    let [red, green, blue] = [&read.red_trc, &read.green_trc, &read.blue_trc].map(curve);
    Ok((Transfers::new([red?, green?, blue?]), weights.map(|weight| weight / white)))
}

/// Returns the PNG files in a folder, in the order of their names; none if it is not a folder.
///
/// # Errors
/// The folder cannot be read.
pub fn listed(folder: &Path) -> Result<Vec<PathBuf>, StoreError> {
    if !found(folder).map_err(io(folder, "access"))?.is_some_and(|found| found.is_dir()) {
        return Ok(Vec::new());
    }
    let mut paths = entries(folder).map_err(io(folder, "list"))?;
    paths.retain(|path| path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("png")));
    Ok(paths)
}
