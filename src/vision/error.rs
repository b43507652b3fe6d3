//! What the model cannot predict.

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

/// Whether `light` is that of `width` × `height` places.
pub(super) fn check(
    light: impl Iterator<Item = f64>,
    width: usize,
    height: usize,
    found: usize,
) -> Result<(), VisionError> {
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
