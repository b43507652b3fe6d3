//! The models: how a display's light rises with the encoded value.

use crate::light::Transfer;

/// The families of curves, from the simplest on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Family {
    /// The curve of sRGB.
    Srgb,
    /// A power, V^γ.
    Gamma,
    /// Gain, offset and gamma, (gain·V + offset)^γ with gain + offset = 1.
    Gog,
    /// A monotone table through the readings.
    Table,
}

impl Family {
    /// All of them, the simplest first.
    pub const ALL: [Self; 4] = [Self::Srgb, Self::Gamma, Self::Gog, Self::Table];

    /// The name on the command line and in tables.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Srgb => "srgb",
            Self::Gamma => "gamma",
            Self::Gog => "gog",
            Self::Table => "table",
        }
    }
}

impl std::fmt::Display for Family {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.pad(self.name())
    }
}

/// The light of one channel, L = black + range·transfer(V).
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// At V = 0, cd/m².
    pub black_cd_m2: f64,
    /// Added by V = 1, cd/m².
    pub range_cd_m2: f64,
    /// Between them.
    pub transfer: Transfer,
}

impl Curve {
    /// Luminance of the encoded value `v`, 0…1, cd/m².
    #[must_use]
    pub fn cd_m2(&self, v: f64) -> f64 {
        self.black_cd_m2 + self.range_cd_m2 * self.transfer.linear_from_encoded(v)
    }

    /// The encoded value that gives a luminance; 0 for black and less. Above white, where noise puts readings, the curve
    /// continues as a straight line.
    #[must_use]
    pub fn encoded(&self, cd_m2: f64) -> f64 {
        let light = (cd_m2 - self.black_cd_m2) / self.range_cd_m2;
        let last = 1.0 / 255.0;
        let slope = (1.0 - self.transfer.linear_from_encoded(1.0 - last)) / last;
        if light > 1.0 { 1.0 + (light - 1.0) / slope } else { self.transfer.encoded_from_linear(light) }
    }

    /// The exponent, where there is one.
    #[must_use]
    pub fn gamma(&self) -> Option<f64> {
        match &self.transfer {
            Transfer::Gamma(gamma) => Some(*gamma),
            Transfer::Gog(gog) => Some(gog.gamma),
            _ => None,
        }
    }

    /// Gain and offset, where there are any.
    #[must_use]
    pub fn gain_and_offset(&self) -> Option<(f64, f64)> {
        match &self.transfer {
            Transfer::Gog(gog) => Some((gog.gain, gog.offset)),
            _ => None,
        }
    }
}
