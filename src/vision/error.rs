//! The reasons why a prediction can fail.

/// The reason why an image cannot be predicted.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum VisionError {
    /// The image has too few pixels.
    #[error("an image of {width} × {height} pixels is too small; expected at least {least} on each side")]
    TooSmall {
        width: usize,
        height: usize,
        /// Minimum number of pixels per side.
        least: usize,
    },
    /// The number of pixels per degree is not a positive number.
    #[error("{0} pixels per degree; expected a number above 0")]
    Sampling(f64),
    /// The number of samples does not match the size of the image.
    #[error("{found} samples of light; expected {expected}")]
    Count {
        /// Number of samples found.
        found: usize,
        /// Number of samples that the size requires.
        expected: usize,
    },
    /// A light value is negative or not a finite number.
    #[error("light {value} in column {x}, row {y}; expected a number that is not negative")]
    Light {
        /// The value found.
        value: f64,
        /// Column, from 0.
        x: usize,
        /// Row, from 0.
        y: usize,
    },
    /// The image is black everywhere.
    #[error("all black; expected some light")]
    AllBlack,
}

/// Checks that `light` holds `width` × `height` valid values, that some of them are above 0, and that `px_per_deg` is
/// positive.
pub(super) fn check(light: &[f64], width: usize, height: usize, px_per_deg: f64) -> Result<(), VisionError> {
    if !(px_per_deg.is_finite() && px_per_deg > 0.0) {
        return Err(VisionError::Sampling(px_per_deg));
    }
    if light.len() != width * height {
        return Err(VisionError::Count { found: light.len(), expected: width * height });
    }
    if let Some(i) = light.iter().position(|value| !(value.is_finite() && *value >= 0.0)) {
        return Err(VisionError::Light { value: light[i], x: i % width, y: i / width });
    }
    if light.iter().all(|value| *value == 0.0) { Err(VisionError::AllBlack) } else { Ok(()) }
}
