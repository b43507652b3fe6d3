//! The continuity depth n: how smoothly a ramp joins its plateaus.

use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// Continuity depth n of Bangay eq. 1: n − 1 derivatives of the interpolation vanish at both ends of
/// the ramp.
///
/// Written `1` … `32`, or `inf`, in text and in files.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Depth {
    /// A polynomial of degree 2n − 1, n from 1 (linear) to [`Depth::MAX_FINITE`]. Made by
    /// [`Depth::finite`].
    Finite(u8),
    /// Bangay's n = ∞, a scaled tanh. Not the limit of the finite depths, which is a step.
    Infinite,
}

impl Depth {
    /// Largest finite depth that is evaluated to 1e-12.
    pub const MAX_FINITE: u8 = 32;

    /// The finite depth `n`.
    ///
    /// # Errors
    /// When `n` is not within 1…32.
    pub fn finite(n: u32) -> Result<Depth, DepthError> {
        match u8::try_from(n) {
            Ok(n @ 1..=Depth::MAX_FINITE) => Ok(Depth::Finite(n)),
            _ => Err(DepthError::OutOfRange(n.to_string())),
        }
    }
}

/// Why something is not a [`Depth`].
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum DepthError {
    /// A whole number, but none that is supported.
    #[error("depth {0} is outside 1…32; expected a whole number from 1 to 32, or inf")]
    OutOfRange(String),
    /// Not a whole number at all.
    #[error("depth {0} is not a whole number; expected a whole number from 1 to 32, or inf")]
    NotWhole(String),
}

impl fmt::Display for Depth {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Depth::Finite(n) => n.fmt(f),
            Depth::Infinite => "inf".fmt(f),
        }
    }
}

impl FromStr for Depth {
    type Err = DepthError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let text = text.trim();
        if text == "inf" {
            return Ok(Depth::Infinite);
        }
        match text.parse::<i128>() {
            Ok(n) => u32::try_from(n).map_err(|_| DepthError::OutOfRange(text.to_owned())).and_then(Depth::finite),
            Err(_) => Err(DepthError::NotWhole(format!("{text:?}"))),
        }
    }
}

impl Serialize for Depth {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Depth::Finite(n) => serializer.serialize_u8(*n),
            Depth::Infinite => serializer.serialize_str("inf"),
        }
    }
}

impl<'de> Deserialize<'de> for Depth {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        #[derive(Deserialize)]
        #[serde(untagged, expecting = "expected a whole number from 1 to 32, or inf")]
        enum Written {
            Number(f64),
            Text(String),
        }

        match Written::deserialize(deserializer)? {
            // TOML has a float called inf; it can only mean one depth.
            Written::Number(n) if n == f64::INFINITY => Ok(Depth::Infinite),
            Written::Number(n) => n.to_string().parse(),
            Written::Text(text) => text.parse(),
        }
        .map_err(serde::de::Error::custom)
    }
}
