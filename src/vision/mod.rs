//! Floor 1: a model of vision: where an image has bright and dark bands, and how visible they are.
//!
//! A model of local energy, as Morrone and Burr's (1988, Proc. R. Soc. B 235:221; Ross, Morrone & Burr 1989, Vis. Res.
//! 29:699): the eye looks for lines and edges where the energy of an even and an odd response, in quadrature, is
//! highest; the phase says which of both it is. At a sharp step the phase is that of an edge in every channel: no band.
//! At the end of a ramp it is that of a line: a band.
//!
//! ```text
//! light → sensitivity (optics, neurons) → channels (log-Gabor, quarter octaves): even, odd
//!       → peaks of the energy that stand out on both sides → even beyond odd, over the mean light → over channels
//! ```
//!
//! Strengths are contrast times sensitivity: at 1 a grating of that contrast would be just visible. Every constant has its
//! source where it is defined. [`Line`] is for stimuli that vary in one direction, [`Picture`] for images; they agree.

mod band;
mod eye;
pub mod fft;
mod line;
mod picture;
mod rating;

use crate::light::LinearImage;

pub use band::{Band, Polarity, Visibility, pooled, vertex};
pub use eye::{Channel, Eye};
pub use line::{Line, LineView};
pub use picture::{BandMap, Picture, PictureView};
pub use rating::Criterion;

/// What lies beyond the edges of an image or profile.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Border {
    /// It continues as it ends: a ramp between endless plateaus.
    Continues,
    /// Something else: a channel ignores anything within 1.5 periods of an edge.
    Cut,
}

/// A channel ignores bands within this many of its periods from an edge.
const MARGIN_PERIODS: f64 = 1.5;
/// Nearer than this, the edge itself makes the response, which is not used at all.
const BESIDE_PERIODS: f64 = 0.75;

impl Border {
    /// Width of the margin along the edges in which bands are ignored, degrees.
    fn margin_deg(self, frequency: f64) -> f64 {
        match self {
            Border::Continues => 0.0,
            Border::Cut => MARGIN_PERIODS / frequency,
        }
    }

    /// Width of the margin along the edges in which the response is not used, degrees.
    fn beside_deg(self, frequency: f64) -> f64 {
        match self {
            Border::Continues => 0.0,
            Border::Cut => BESIDE_PERIODS / frequency,
        }
    }
}

/// Why an image cannot be predicted.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum VisionError {
    /// Too few pixels.
    #[error("an image of {width} × {height} pixels is too small; expected at least {least} on each side")]
    TooSmall {
        /// Columns.
        width: usize,
        /// Rows.
        height: usize,
        /// Pixels that a side needs.
        least: usize,
    },
    /// A sampling that is not possible.
    #[error("{0} pixels per degree; expected a number above 0")]
    Sampling(f64),
    /// A number of samples that does not match the size.
    #[error("{found} samples of light; expected {expected}")]
    Count {
        /// How many there are.
        found: usize,
        /// How many the size needs.
        expected: usize,
    },
    /// Light that is not possible.
    #[error("light {value} in column {x}, row {y}; expected a number that is not negative")]
    NoLight {
        /// The value found.
        value: f64,
        /// Column, from 0.
        x: usize,
        /// Row, from 0.
        y: usize,
    },
    /// No light at all.
    #[error("all black; expected some light")]
    AllBlack,
}

/// Luminance of linear light in the primaries of a common screen, 1 for white (IEC 61966-2-1).
#[must_use]
pub fn luminance([red, green, blue]: [f32; 3]) -> f64 {
    0.2126 * f64::from(red) + 0.7152 * f64::from(green) + 0.0722 * f64::from(blue)
}

/// Luminance of every pixel of an image.
#[must_use]
pub fn luminances(image: &LinearImage) -> Vec<f64> {
    image.data.chunks_exact(3).map(|pixel| luminance([pixel[0], pixel[1], pixel[2]])).collect()
}

fn check(light: impl Iterator<Item = f64>, width: usize, height: usize, found: usize) -> Result<(), VisionError> {
    if found != width * height {
        return Err(VisionError::Count { found, expected: width * height });
    }
    let mut some = false;
    for (i, value) in light.enumerate() {
        if !(value.is_finite() && value >= 0.0) {
            return Err(VisionError::NoLight { value, x: i % width, y: i / width });
        }
        some |= value > 0.0;
    }
    if some { Ok(()) } else { Err(VisionError::AllBlack) }
}
