//! The hue of a stimulus: how much of its luminance goes to red, green and blue.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// Weights of red, green and blue, linear in light, each 0…1 and not all 0. A pixel of relative
/// luminance L lights L times these. Written by name, `yellow` or `gray`, or as `R,G,B`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StimulusColor {
    rgb: [f64; 3],
}

/// The colors that have a name. The first of equal ones is the one that is written.
const NAMED: [(&str, [f64; 3]); 3] =
    [("yellow", [1.0, 1.0, 0.0]), ("gray", [1.0, 1.0, 1.0]), ("grey", [1.0, 1.0, 1.0])];

/// A text or triple that is no color.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("color {0} is not known; expected yellow, gray or three numbers R,G,B from 0 to 1, not all 0, linear in light")]
pub struct ColorError(String);

impl StimulusColor {
    /// Equal quantities of red and green: Bangay §3.1.
    pub const YELLOW: StimulusColor = StimulusColor { rgb: [1.0, 1.0, 0.0] };
    /// The display's white, dimmed.
    pub const GRAY: StimulusColor = StimulusColor { rgb: [1.0, 1.0, 1.0] };

    /// The color of the weights `rgb`.
    ///
    /// # Errors
    /// When one is not within 0…1, or all are 0.
    pub fn new(rgb: [f64; 3]) -> Result<Self, ColorError> {
        let in_range = rgb.iter().all(|weight| (0.0..=1.0).contains(weight));
        if in_range && rgb.iter().any(|&weight| weight > 0.0) {
            // −0 is within the range; it must not be written.
            Ok(Self { rgb: rgb.map(|weight| weight + 0.0) })
        } else {
            let [r, g, b] = rgb;
            Err(ColorError(format!("{r},{g},{b}")))
        }
    }

    /// Weights of red, green and blue, 0…1, linear in light.
    #[must_use]
    pub const fn rgb(self) -> [f64; 3] {
        self.rgb
    }
}

impl fmt::Display for StimulusColor {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some((name, _)) = NAMED.iter().find(|(_, rgb)| *rgb == self.rgb) {
            return f.write_str(name);
        }
        let [r, g, b] = self.rgb;
        write!(f, "{r},{g},{b}")
    }
}

impl FromStr for StimulusColor {
    type Err = ColorError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let text = text.trim();
        if let Some((_, rgb)) = NAMED.iter().find(|(name, _)| *name == text) {
            return Ok(Self { rgb: *rgb });
        }
        let unknown = || ColorError(format!("{text:?}"));
        let weights: Vec<f64> =
            text.split(',').map(|weight| weight.trim().parse()).collect::<Result<_, _>>().map_err(|_| unknown())?;
        Self::new(weights.try_into().map_err(|_| unknown())?)
    }
}

impl Serialize for StimulusColor {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

impl<'de> Deserialize<'de> for StimulusColor {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let text = std::borrow::Cow::<'de, str>::deserialize(deserializer)?;
        text.parse().map_err(serde::de::Error::custom)
    }
}
