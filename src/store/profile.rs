//! Display profiles (TOML).

use std::path::Path;

use serde::Deserialize;
use serde_json::{Map, Value};

use super::{
    FileErrors, StoreError, Writer,
    error::io,
    file::{read_text, sha256},
    toml::{self as toml_file, Document},
};
use crate::{
    display::{DisplayProfile, LuminanceRange, Measurement, Primaries},
    light::{Transfer, Transfers},
};

/// Reads a display profile.
///
/// ```toml
/// schema = 1
/// name = "Left monitor"
/// transfer = "gog:2.2,1.05,-0.05"   # srgb | linear | gamma:G | gog:GAMMA,GAIN,OFFSET; or encoded values and their light,
///                                   # both increasing from 0 to 1: { encoded = [0, 0.5, 1], linear = [0, 0.22, 1] };
///                                   # or a list of three of these, for red, green and blue
/// black_cd_m2 = 0.12
/// white_cd_m2 = 251.0
/// bits = 8
/// screen_width_cm = 53.1
/// native_px = [2560, 1440]
///
/// [measured]
/// on = "2026-01-31"
/// by = "N. N."
/// with = "a photometer"
///
/// [primaries]                       # CIE 1931 x, y; how bright the channels are to `compare`. Stimuli have sRGB's
/// red = [0.64, 0.33]
/// green = [0.3, 0.6]
/// blue = [0.15, 0.06]
/// white = [0.3127, 0.329]
/// ```
///
/// # Errors
/// Reports every error, with its line and column.
pub fn open(path: &Path) -> Result<DisplayProfile, FileErrors> {
    parse(&path.display().to_string(), &read_text(path)?)
}

/// Parses the text of a display profile; `file` identifies it in messages.
///
/// # Errors
/// Reports every error, with its line and column.
pub fn parse(file: &str, text: &str) -> Result<DisplayProfile, FileErrors> {
    let (form, mut document) = toml_file::read::<ProfileForm>(file, text)?;
    let profile = DisplayProfile {
        luminance: luminance(&form, &mut document),
        transfers: form.transfer.unwrap_or_else(|| {
            document.error("transfer", "transfer is missing; expected transfer = …");
            Transfer::Srgb.into()
        }),
        name: form.name,
        primaries: form.primaries,
        bits: form.bits.map(|bits| u8::try_from(bits).unwrap_or(u8::MAX)),
        measured: form.measured,
        screen_width_cm: form.screen_width_cm,
        native_px: form.native_px,
    };
    let [darkest, brightest] = LuminanceRange::WHITE_CD_M2;
    for (key, value, range) in [
        ("black_cd_m2", form.black_cd_m2, 0.0..=brightest),
        ("white_cd_m2", form.white_cd_m2, darkest..=brightest),
        ("bits", form.bits.map(f64::from), 1.0..=16.0),
        ("screen_width_cm", profile.screen_width_cm, 1.0..=1000.0),
    ] {
        document.check_range(key, value.as_slice(), range);
    }
    if let Some(size) = profile.native_px.filter(|size| size.iter().any(|side| !(16..=65_536).contains(side))) {
        document.error("native_px", format!("native_px is {size:?}; expected columns and rows, such as [2560, 1440]"));
    }
    if let Some(primaries) = profile.primaries {
        let Primaries { red, green, blue, white } = primaries;
        for (key, [x, y]) in [("red", red), ("green", green), ("blue", blue), ("white", white)] {
            if !(x >= 0.0 && y > 0.0 && x + y <= 1.0) {
                let expected = "expected CIE 1931 [x, y] with x ≥ 0, y > 0 and x + y ≤ 1";
                let path = format!("primaries.{key}");
                document.error(&path, format!("{path} is [{x}, {y}]; {expected}"));
            }
        }
        if primaries.weights().is_none() {
            let message =
                "white does not lie within the triangle of red, green and blue; expected the primaries of a screen";
            document.error("primaries", message.to_owned());
        }
    }
    if profile.name.trim().is_empty() {
        document.error("name", "name is empty; expected the name of the screen".to_owned());
    }
    document.finish(profile)
}

/// A profile in the structure of its file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ProfileForm {
    name: String,
    transfer: Option<Transfers>,
    black_cd_m2: Option<f64>,
    white_cd_m2: Option<f64>,
    bits: Option<u32>,
    screen_width_cm: Option<f64>,
    native_px: Option<[u32; 2]>,
    measured: Option<Measurement>,
    primaries: Option<Primaries>,
}

fn luminance(form: &ProfileForm, document: &mut Document<'_>) -> Option<LuminanceRange> {
    let (black, white) = ("black_cd_m2", "white_cd_m2");
    for (own, other) in [(black, white), (white, black)] {
        if document.has(own) && !document.has(other) {
            document.error(own, format!("{own} is given without {other}; expected both"));
        }
    }
    let (black_cd_m2, white_cd_m2) = form.black_cd_m2.zip(form.white_cd_m2)?;
    if black_cd_m2 < white_cd_m2 {
        return Some(LuminanceRange { black_cd_m2, white_cd_m2 });
    }
    let message = format!("{white} {white_cd_m2} is not above {black} {black_cd_m2}; expected a larger number");
    document.error(white, message);
    None
}

/// Returns the known values of the profile, in the structure of its file.
pub fn value(profile: &DisplayProfile) -> Value {
    let mut all = Map::from_iter([("schema".to_owned(), 1.into())]);
    if let Ok(Value::Object(own)) = serde_json::to_value(profile) {
        all.extend(own.into_iter().filter(|(_, value)| !value.is_null()));
    }
    Value::Object(all)
}

/// Returns the SHA-256 of the profile's content, in lowercase hexadecimal; it is the same for every file with the same
/// content.
pub fn hash(profile: &DisplayProfile) -> String {
    let canonical = value(profile).to_string();
    sha256(canonical.as_bytes())
}

/// Writes a profile; [`open`](fn@open) reads it back unchanged.
///
/// # Errors
/// The same errors as [`Writer::write`].
pub fn write(writer: &Writer, path: &Path, profile: &DisplayProfile) -> Result<(), StoreError> {
    let text = ::toml::to_string(&value(profile)).map_err(|error| io(path, "encode")(std::io::Error::other(error)))?;
    writer.write(path, text.as_bytes())
}
