//! Why a prediction fails.

/// Why there is no prediction for an image.
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
    /// A sampling that does not exist.
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
    /// Light that does not exist.
    #[error("light {value} in column {x}, row {y}; expected a number that is not negative")]
    Light {
        /// The value found.
        value: f64,
        /// Column, from 0.
        x: usize,
        /// Row, from 0.
        y: usize,
    },
    /// Black everywhere.
    #[error("all black; expected some light")]
    AllBlack,
}

/// Whether `light` is that of `width` × `height` pixels.
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
