//! Transfer functions: from an encoded value to light, and from light to an encoded value. Shoaff §2.1.1.
//!
//! Both quantities are relative, 0…1. The name of each function states the direction of the conversion.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Deserializer, Serialize, Serializer, de::Error as _};

/// IEC 61966-2-1: the encoded value up to which sRGB is a straight line.
const SRGB_ENCODED_KNEE: f64 = 0.04045;
/// IEC 61966-2-1: the slope of the straight line, encoded value per linear value.
const SRGB_SLOPE: f64 = 12.92;
/// IEC 61966-2-1: the offset of the power part; the factor 1.055 is 1 plus this offset.
const SRGB_OFFSET: f64 = 0.055;
/// IEC 61966-2-1: the exponent of the power part.
const SRGB_EXPONENT: f64 = 2.4;

/// The range of plausible display exponents.
const GAMMA_RANGE: std::ops::RangeInclusive<f64> = 0.1..=10.0;

/// How a display turns encoded values into light. Written `linear`, `gamma:2.2`, `gog:2.2,1.05,-0.05` (γ, gain, offset)
/// or `srgb`; a table has no short text form.
#[derive(Clone, Debug, PartialEq)]
pub enum Transfer {
    /// Light is proportional to the encoded value.
    Linear,
    /// linear = encoded^γ, Shoaff's L = K·V^γ with K = 1. Made by [`Transfer::gamma`], with γ within 0.1…10.
    Gamma(f64),
    /// Gain, offset and gamma. Made by [`Transfer::gog`].
    Gog(Gog),
    /// sRGB, IEC 61966-2-1: a straight line up to 0.04045, then a power of 2.4.
    Srgb,
    /// A measured table, interpolated linearly between its points.
    Table(TransferTable),
}

/// Says that an exponent is implausible for a display.
fn not_a_gamma(gamma: impl fmt::Display) -> String {
    format!("gamma {gamma} is outside 0.1…10; expected the display's exponent, such as 2.2")
}

impl Transfer {
    /// Makes linear = encoded^`gamma`.
    ///
    /// # Errors
    /// Returns an error if `gamma` is not within 0.1…10.
    pub fn gamma(gamma: f64) -> Result<Transfer, String> {
        if GAMMA_RANGE.contains(&gamma) { Ok(Transfer::Gamma(gamma)) } else { Err(not_a_gamma(gamma)) }
    }

    /// Makes linear ∝ max(`gain`·encoded + `offset`, 0)^`gamma`, the model of gain, offset and gamma; see [`Gog`].
    ///
    /// # Errors
    /// Returns an error if `gamma` is not within 0.1…10, if `gain` is not above 0 and at most 10, if `offset` is not
    /// within −1…1, or if gain and offset together leave the largest code dark.
    pub fn gog(gamma: f64, gain: f64, offset: f64) -> Result<Transfer, String> {
        if !GAMMA_RANGE.contains(&gamma) {
            return Err(not_a_gamma(gamma));
        }
        if gain > 0.0 && gain <= 10.0 && (-1.0..=1.0).contains(&offset) && gain + offset > 0.0 {
            Ok(Transfer::Gog(Gog { gamma, gain, offset }))
        } else {
            Err(format!(
                "gain {gain} with offset {offset} describes no display; expected a gain above 0 and up to 10, an offset of -1…1, and light at the largest code (gain + offset above 0)"
            ))
        }
    }

    /// Returns the encoded value, 0…1, that produces the relative luminance `linear`, which is first clamped to 0…1.
    /// NaN stays NaN.
    ///
    /// The result never decreases as `linear` rises. For sRGB, the standard's rounded constants leave a gap of 2.3e-9
    /// at 0.00313 in the light that encoded values produce; light within the gap is encoded as its lower end, 0.04045.
    /// Everywhere else, this function and [`Transfer::linear_from_encoded`] are inverses.
    pub fn encoded_from_linear(&self, linear: f64) -> f64 {
        let linear = linear.clamp(0.0, 1.0);
        match self {
            Transfer::Linear => linear,
            Transfer::Gamma(gamma) => linear.powf(gamma.recip()),
            Transfer::Gog(gog) => gog.encoded_from_linear(linear),
            Transfer::Srgb if linear <= SRGB_ENCODED_KNEE / SRGB_SLOPE => linear * SRGB_SLOPE,
            // 1.055 − 0.055 is not quite 1 in f64.
            Transfer::Srgb if linear == 1.0 => 1.0,
            Transfer::Srgb => {
                ((1.0 + SRGB_OFFSET) * linear.powf(SRGB_EXPONENT.recip()) - SRGB_OFFSET).clamp(SRGB_ENCODED_KNEE, 1.0)
            }
            Transfer::Table(table) => piecewise(&table.linear, &table.encoded, linear),
        }
    }

    /// Returns the relative luminance, 0…1, that the encoded value `encoded` produces; `encoded` is first clamped to
    /// 0…1. NaN stays NaN.
    pub fn linear_from_encoded(&self, encoded: f64) -> f64 {
        let encoded = encoded.clamp(0.0, 1.0);
        match self {
            Transfer::Linear => encoded,
            Transfer::Gamma(gamma) => encoded.powf(*gamma),
            Transfer::Gog(gog) => gog.linear_from_encoded(encoded),
            Transfer::Srgb if encoded <= SRGB_ENCODED_KNEE => encoded / SRGB_SLOPE,
            Transfer::Srgb => ((encoded + SRGB_OFFSET) / (1.0 + SRGB_OFFSET)).powf(SRGB_EXPONENT),
            Transfer::Table(table) => piecewise(&table.encoded, &table.linear, encoded),
        }
    }
}

impl fmt::Display for Transfer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Transfer::Linear => f.write_str("linear"),
            Transfer::Gamma(gamma) => write!(f, "gamma:{gamma}"),
            Transfer::Gog(Gog { gamma, gain, offset }) => write!(f, "gog:{gamma},{gain},{offset}"),
            Transfer::Srgb => f.write_str("srgb"),
            Transfer::Table(_) => f.write_str("table"),
        }
    }
}

impl FromStr for Transfer {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let text = text.trim();
        let (name, list) = text.split_once(':').unwrap_or((text, ""));
        let numbers: Option<Vec<f64>> = list.split(',').map(|number| number.trim().parse().ok()).collect();
        match (name, numbers.as_deref()) {
            ("linear", _) if name == text => Ok(Transfer::Linear),
            ("srgb", _) if name == text => Ok(Transfer::Srgb),
            ("gog", Some(&[gamma, gain, offset])) => Transfer::gog(gamma, gain, offset),
            ("gamma", Some(&[gamma])) => Transfer::gamma(gamma),
            ("gamma", _) => Err(not_a_gamma(format!("{list:?}"))),
            _ => Err(format!(
                "transfer {text:?} is not known; expected srgb, linear, gamma:G such as gamma:2.2, or gog:GAMMA,GAIN,OFFSET"
            )),
        }
    }
}

/// The model of gain, offset and gamma (Berns, Motta and Gorzynski 1993, doi:10.1002/col.5080180504): the light is
/// proportional to max(gain·V + offset, 0)^γ, where V is the encoded value, and lies between the light at V = 0 and the
/// light at V = 1.
///
/// As a transfer function, it is scaled to 0…1; a profile records the light at V = 0, the display's black, in cd/m².
/// With an offset below 0, the lowest encoded values are all dark; zero light is then encoded as 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gog {
    /// The exponent γ.
    pub gamma: f64,
    /// The gain; only its ratio to the offset matters for relative light.
    pub gain: f64,
    /// The offset, in encoded values.
    pub offset: f64,
}

impl Gog {
    fn drive(&self, encoded: f64) -> f64 {
        // `max` would turn NaN into 0.
        let drive = self.gain * encoded + self.offset;
        if drive < 0.0 { 0.0 } else { drive }
    }

    /// Returns the light at the encoded values 0 and 1, before scaling to 0…1.
    fn ends(&self) -> (f64, f64) {
        (self.drive(0.0).powf(self.gamma), self.drive(1.0).powf(self.gamma))
    }

    fn linear_from_encoded(&self, encoded: f64) -> f64 {
        let (black, white) = self.ends();
        let linear = (self.drive(encoded).powf(self.gamma) - black) / (white - black);
        if encoded >= 1.0 { 1.0 } else { linear }
    }

    fn encoded_from_linear(&self, linear: f64) -> f64 {
        let (black, white) = self.ends();
        let drive = (black + linear * (white - black)).powf(self.gamma.recip());
        // The ends are exact; zero light is encoded as 0.
        if linear <= 0.0 || linear >= 1.0 { linear } else { ((drive - self.offset) / self.gain).clamp(0.0, 1.0) }
    }
}

/// A measured transfer function: pairs of an encoded value and a relative luminance, joined by straight lines.
#[derive(Clone, Debug, PartialEq)]
pub struct TransferTable {
    encoded: Vec<f64>,
    linear: Vec<f64>,
}

impl TransferTable {
    /// Creates the table in which the encoded value `encoded[i]` produces the relative luminance `linear[i]`.
    ///
    /// # Errors
    /// Returns an error if the columns differ in length, or if one of them does not rise from 0 to 1 at every step (NaN
    /// included).
    pub fn new(encoded: Vec<f64>, linear: Vec<f64>) -> Result<Self, String> {
        let expected = "expected two lists of one length that rise from 0 to 1, relative to the display's range";
        let is_whole = |values: &[f64]| values.first() == Some(&0.0) && values.last() == Some(&1.0);
        if encoded.len() != linear.len() || !is_whole(&encoded) || !is_whole(&linear) {
            return Err(format!("encoded and linear are no table; {expected}"));
        }
        for (name, values) in [("encoded", &encoded), ("linear", &linear)] {
            if let Some(at) = (1..values.len()).find(|at| values[*at].is_nan() || values[*at] <= values[at - 1]) {
                return Err(format!("{name} value {} at index {at} does not rise; {expected}", values[at]));
            }
        }
        Ok(Self { encoded, linear })
    }

    /// The encoded values, rising from 0 to 1.
    pub fn encoded(&self) -> &[f64] {
        &self.encoded
    }

    /// The relative luminances, rising from 0 to 1.
    pub fn linear(&self) -> &[f64] {
        &self.linear
    }
}

/// Interpolates linearly between the points (`x[i]`, `y[i]`) at `at`. Both columns rise from 0 to 1, and `at` is within
/// 0…1 or NaN.
fn piecewise(x: &[f64], y: &[f64], at: f64) -> f64 {
    // The last segment also covers at = 1 and NaN, which propagates through the arithmetic.
    let i = x.partition_point(|&x| x <= at).clamp(1, x.len() - 1);
    let t = (at - x[i - 1]) / (x[i] - x[i - 1]);
    if t >= 1.0 { y[i] } else { y[i - 1] + t * (y[i] - y[i - 1]) }
}

/// The transfer functions of a display's three channels. Written as one [`Transfer`] if they are equal, otherwise as
/// three joined by `/`: `gamma:2.2/gamma:2.1/gamma:2.3`.
#[derive(Clone, Debug, PartialEq)]
pub struct Transfers([Transfer; 3]);

impl Transfers {
    /// Makes the transfer functions of red, green and blue, in this order.
    pub fn new(channels: [Transfer; 3]) -> Self {
        Self(channels)
    }

    /// The transfer functions of red, green and blue, in this order.
    pub fn channels(&self) -> &[Transfer; 3] {
        &self.0
    }

    /// Returns the transfer function that all channels share; `None` if they differ.
    pub fn uniform(&self) -> Option<&Transfer> {
        let [red, green, blue] = &self.0;
        (red == green && green == blue).then_some(red)
    }

    /// True if any channel is a measured table, which has no short text form.
    pub fn has_table(&self) -> bool {
        self.0.iter().any(|transfer| matches!(transfer, Transfer::Table(_)))
    }

    /// Returns [`Transfer::linear_from_encoded`] for each channel.
    pub fn linear_from_encoded(&self, encoded: [f64; 3]) -> [f64; 3] {
        std::array::from_fn(|channel| self.0[channel].linear_from_encoded(encoded[channel]))
    }
}

impl From<Transfer> for Transfers {
    fn from(transfer: Transfer) -> Self {
        Self([transfer.clone(), transfer.clone(), transfer])
    }
}

impl fmt::Display for Transfers {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.uniform() {
            Some(transfer) => transfer.fmt(f),
            None => write!(f, "{}/{}/{}", self.0[0], self.0[1], self.0[2]),
        }
    }
}

impl FromStr for Transfers {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let parts: Vec<&str> = text.split('/').collect();
        match parts[..] {
            [one] => Ok(one.parse::<Transfer>()?.into()),
            [red, green, blue] => Ok(Self([red.parse()?, green.parse()?, blue.parse()?])),
            _ => Err(format!(
                "{text:?} has {} transfer functions; expected one, or three joined by / for red, green and blue",
                parts.len()
            )),
        }
    }
}

/// A transfer function as files store it.
#[derive(Serialize, Deserialize)]
#[serde(untagged, deny_unknown_fields)]
enum Form {
    Text(String),
    Table { encoded: Vec<f64>, linear: Vec<f64> },
}

/// The transfer functions of all channels, or of each of red, green and blue.
#[derive(Serialize, Deserialize)]
#[serde(
    untagged,
    expecting = "transfer is neither text nor a table with encoded and linear; expected one of these, or a list of three"
)]
enum Forms {
    All(Form),
    Each([Form; 3]),
}

impl Form {
    fn of(transfer: &Transfer) -> Self {
        match transfer {
            Transfer::Table(TransferTable { encoded, linear }) => {
                Self::Table { encoded: encoded.clone(), linear: linear.clone() }
            }
            other => Self::Text(other.to_string()),
        }
    }

    fn read<T: FromStr<Err = String> + From<Transfer>>(self) -> Result<T, String> {
        match self {
            Self::Text(text) => text.parse().map_err(|error| format!("{error} (or a table with encoded and linear)")),
            Self::Table { encoded, linear } => TransferTable::new(encoded, linear).map(|it| Transfer::Table(it).into()),
        }
    }
}

impl Serialize for Transfers {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let each = || Forms::Each(self.0.each_ref().map(Form::of));
        self.uniform().map_or_else(each, |all| Forms::All(Form::of(all))).serialize(serializer)
    }
}

impl<'de> Deserialize<'de> for Transfers {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let read = match Forms::deserialize(deserializer)? {
            Forms::All(all) => all.read(),
            Forms::Each([red, green, blue]) => red.read().and_then(|red| Ok(Self([red, green.read()?, blue.read()?]))),
        };
        read.map_err(D::Error::custom)
    }
}
