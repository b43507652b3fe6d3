//! Properties of a screen: its transfer functions, luminance, colors, and size.

use jiff::civil::Date;
use nalgebra::{Matrix3, Vector3};
use serde::{Deserialize, Serialize};

use crate::light::{Transfer, Transfers};

/// Days after which a measurement should be repeated.
pub const VALID_DAYS: i32 = 30;

/// A display profile. Without a measurement, it is an assumption.
///
/// Linear light, 0…1, is the light that a code adds to the screen's black, relative to the light that the largest code
/// adds. [`DisplayProfile::luminance`] gives the luminance of both ends.
///
/// It is stored in this form, without what is not known.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DisplayProfile {
    pub name: String,
    /// How encoded values become linear light, channel by channel.
    #[serde(rename = "transfer")]
    pub transfers: Transfers,
    /// Luminance of code 0 and of the largest code in all channels, if measured.
    #[serde(flatten)]
    pub luminance: Option<LuminanceRange>,
    /// Bits per channel that the panel itself shows, if known.
    pub bits: Option<u8>,
    /// Width of the visible part of the screen in cm, if known.
    pub screen_width_cm: Option<f64>,
    /// The native pixels of the screen, columns and rows, if known.
    pub native_px: Option<[u32; 2]>,
    /// Who measured the screen, when, and with what; `None` for an assumption.
    pub measured: Option<Measurement>,
    /// Chromaticities of the channels and of white, if known.
    pub primaries: Option<Primaries>,
}

/// Black and white of a screen, cd/m².
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LuminanceRange {
    /// Code 0 in every channel.
    pub black_cd_m2: f64,
    /// The largest code in every channel.
    pub white_cd_m2: f64,
}

impl LuminanceRange {
    /// The least and the largest luminance that a screen's white can have, cd/m².
    pub const WHITE_CD_M2: [f64; 2] = [1e-3, 1e5];

    /// Returns the luminance of the linear light `linear`, 0…1, in cd/m².
    pub fn cd_m2(&self, linear: f64) -> f64 {
        self.black_cd_m2 + linear * (self.white_cd_m2 - self.black_cd_m2)
    }

    /// Formats both luminances, as in "0.251 to 134 cd/m²".
    pub fn sentence(&self) -> String {
        format!("{} to {} cd/m²", short(self.black_cd_m2), short(self.white_cd_m2))
    }
}

/// CIE 1931 chromaticities x, y.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Primaries {
    /// Chromaticity of the red channel.
    pub red: [f64; 2],
    /// Chromaticity of the green channel.
    pub green: [f64; 2],
    /// Chromaticity of the blue channel.
    pub blue: [f64; 2],
    /// Chromaticity of all channels together.
    pub white: [f64; 2],
}

impl Primaries {
    /// Returns the luminance of full red, green and blue relative to white; `None` if no screen has such primaries.
    pub fn weights(&self) -> Option<[f64; 3]> {
        let xyz = |[x, y]: [f64; 2]| Vector3::new(x / y, 1.0, (1.0 - x - y) / y);
        Matrix3::from_columns(&[self.red, self.green, self.blue].map(xyz))
            .try_inverse()
            .map(|inverse| <[f64; 3]>::from(inverse * xyz(self.white)))
            .filter(|weights| weights.iter().all(|weight| (0.0..=1.0).contains(weight)))
    }
}

/// How a screen was measured.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Measurement {
    /// The day of the measurement, if known.
    #[serde(default, deserialize_with = "day", skip_serializing_if = "Option::is_none")]
    pub on: Option<Date>,
    /// Who measured it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub by: Option<String>,
    /// The instrument: the photometer, or the eye and the procedure.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub with: Option<String>,
}

/// Reads a valid day; `serde(default)` covers a missing one.
fn day<'de, D: serde::Deserializer<'de>>(deserializer: D) -> Result<Option<Date>, D::Error> {
    let text = String::deserialize(deserializer)?;
    let wrong = |_| serde::de::Error::custom(format!("measured.on is {text:?}; expected a day such as \"2026-01-31\""));
    text.parse().map(Some).map_err(wrong)
}

impl Default for DisplayProfile {
    /// An sRGB display, assumed and not measured.
    fn default() -> Self {
        Self {
            name: "sRGB".to_owned(),
            transfers: Transfer::Srgb.into(),
            luminance: None,
            primaries: None,
            bits: None,
            measured: None,
            screen_width_cm: None,
            native_px: None,
        }
    }
}

impl DisplayProfile {
    /// Describes the profile in one sentence.
    pub fn sentence(&self) -> String {
        let transfer = match self.transfers.uniform() {
            Some(transfer) => described(transfer),
            None => self.transfers.channels().each_ref().map(described).join(" / "),
        };
        let luminance = self.luminance.map_or_else(String::new, |range| format!(", {}", range.sentence()));
        let Some(measured) = &self.measured else {
            let what = format!("{transfer}{luminance}");
            let what = if self.name.eq_ignore_ascii_case(&what) { String::new() } else { format!(" ({what})") };
            return format!("{}{what}, assumed: this screen was not measured", self.name);
        };
        let part =
            |word: &str, value: Option<String>| value.map_or_else(String::new, |value| format!(" {word}{value}"));
        format!(
            "{} ({transfer}{luminance}), measured{}{}{}",
            self.name,
            part("on ", measured.on.map(|day| day.to_string())),
            part("with ", measured.with.clone()),
            part("by ", measured.by.clone()),
        )
    }

    /// Says in one sentence why a measurement may be unreliable on the day `today`; `None` if there is no reason, or no
    /// measurement.
    pub fn warning(&self, today: Date) -> Option<String> {
        let since = self.measured.as_ref()?.on.map(|on| on.until((jiff::Unit::Day, today)));
        match since.and_then(Result::ok).map(|since| since.get_days()) {
            None => Some("The profile does not say when the screen was measured.".to_owned()),
            Some(days) if days > VALID_DAYS => Some(format!(
                "The screen was measured {days} days ago; after {VALID_DAYS} days it should be measured again."
            )),
            Some(days) if days < 0 => Some("The profile's date of measurement is in the future.".to_owned()),
            Some(_) => None,
        }
    }
}

/// Formats a transfer function with no more digits than a measurement provides.
fn described(transfer: &Transfer) -> String {
    match transfer {
        Transfer::Gamma(gamma) => format!("γ {gamma:.3}"),
        Transfer::Gog(gog) => format!("γ {:.3}, gain {:.3}, offset {:+.3}", gog.gamma, gog.gain, gog.offset),
        Transfer::Linear | Transfer::Srgb | Transfer::Table(_) => transfer.to_string(),
    }
}

/// Formats a number with three significant digits and at most six decimals.
fn short(value: f64) -> String {
    let digits = (2 - value.abs().max(1e-9).log10().floor() as i32).clamp(0, 6) as usize;
    format!("{value:.digits$}")
}
