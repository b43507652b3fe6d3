//! The curves that are fitted: how a display's light rises with the encoded value.

use crate::light::{Transfer, TransferError};

/// The families of curves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Family {
    /// The shape of sRGB: L = B + S·sRGB(V).
    Srgb,
    /// A power: L = B + S·V^γ.
    Gamma,
    /// Gain, offset and gamma: L = B + S·(max(V + k, 0)^γ − k₊^γ)/((1 + k)^γ − k₊^γ), k the offset divided by the gain.
    Gog,
    /// The best of these, bent to the readings where they ask for it; monotone.
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
        f.write_str(self.name())
    }
}

/// A curve from 0 at V = 0 to 1 at V = 1. It goes on above 1, where noise puts readings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    /// sRGB.
    Srgb,
    /// V^γ.
    Gamma(f64),
    /// γ, and the offset divided by the gain.
    Gog(f64, f64),
}

impl Shape {
    /// The light of an encoded value of 0 or more.
    pub(super) fn light(self, v: f64) -> f64 {
        match self {
            Self::Srgb if v <= 1.0 => Transfer::Srgb.linear_from_encoded(v),
            Self::Srgb => ((v + 0.055) / 1.055).powf(2.4),
            Self::Gamma(gamma) => v.powf(gamma),
            Self::Gog(gamma, k) => {
                let dark = k.max(0.0).powf(gamma);
                ((v + k).max(0.0).powf(gamma) - dark) / ((1.0 + k).powf(gamma) - dark)
            }
        }
    }

    /// The encoded value of a light of 0 or more.
    pub(super) fn encoded(self, light: f64) -> f64 {
        let light = light.max(0.0);
        match self {
            Self::Srgb if light <= 1.0 => Transfer::Srgb.encoded_from_linear(light),
            Self::Srgb => 1.055 * light.powf(2.4f64.recip()) - 0.055,
            Self::Gamma(gamma) => light.powf(gamma.recip()),
            Self::Gog(_, _) if light == 0.0 => 0.0,
            Self::Gog(gamma, k) => {
                let dark = k.max(0.0).powf(gamma);
                (dark + light * ((1.0 + k).powf(gamma) - dark)).powf(gamma.recip()) - k
            }
        }
    }

    /// What the offset alone gives at V = 0, relative to all that is added to it.
    pub(super) fn offset_light(self) -> f64 {
        match self {
            Self::Gog(gamma, k) if k > 0.0 => k.powf(gamma) / ((1.0 + k).powf(gamma) - k.powf(gamma)),
            _ => 0.0,
        }
    }

    /// The exponent.
    #[must_use]
    pub fn gamma(self) -> Option<f64> {
        match self {
            Self::Srgb => None,
            Self::Gamma(gamma) | Self::Gog(gamma, _) => Some(gamma),
        }
    }

    /// Gain and offset, with gain + offset = 1.
    #[must_use]
    pub fn gain_and_offset(self) -> Option<(f64, f64)> {
        match self {
            Self::Gog(_, k) => Some(((1.0 + k).recip(), k / (1.0 + k))),
            _ => None,
        }
    }

    /// As a transfer function.
    ///
    /// # Errors
    /// When the curve is no display's.
    pub fn transfer(self) -> Result<Transfer, TransferError> {
        match self {
            Self::Srgb => Ok(Transfer::Srgb),
            Self::Gamma(gamma) => Transfer::gamma(gamma),
            Self::Gog(gamma, k) => Transfer::gog(gamma, (1.0 + k).recip(), k / (1.0 + k)),
        }
    }
}

/// The light of one channel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Curve {
    /// At V = 0, cd/m².
    pub black_cd_m2: f64,
    /// Added by V = 1, cd/m².
    pub range_cd_m2: f64,
    /// Between them.
    pub shape: Shape,
}

impl Curve {
    /// Luminance of the encoded value `v`, cd/m².
    #[must_use]
    pub fn cd_m2(&self, v: f64) -> f64 {
        self.black_cd_m2 + self.range_cd_m2 * self.shape.light(v)
    }

    /// The encoded value that gives a luminance; 0 for black and less.
    #[must_use]
    pub fn encoded(&self, cd_m2: f64) -> f64 {
        self.shape.encoded((cd_m2 - self.black_cd_m2) / self.range_cd_m2)
    }
}
