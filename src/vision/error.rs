//! The reasons why a prediction can fail.

/// Maximum number of pixels per degree: 16,384 pixels in a window of 0.01 degrees. The surround of a line needs 16
/// degrees of samples.
const MAX_PX_PER_DEG: f64 = 2e6;
/// Maximum extent of an image, degrees. Wider images do not exist, and their masking would need unlimited memory.
pub const MAX_DEG: f64 = 360.0;

/// The reason why an image cannot be predicted.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum VisionError {
    /// The image has no pixels.
    #[error("an image of {width} × {height} pixels is too small; expected at least 1 on each side")]
    TooSmall { width: usize, height: usize },
    /// The number of pixels per degree is not a positive number, or is so large that the surround does not fit into
    /// memory.
    #[error("{} pixels per degree; expected a number above 0 and at most {MAX_PX_PER_DEG}", told(*.0))]
    Sampling(f64),
    /// The image is wider or higher than the whole field around the eye.
    #[error("the image extends over {} degrees; expected at most {MAX_DEG}", told(*.0))]
    Extent(f64),
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
    /// A picture that is compared has no light at a place.
    #[error("no light in column {x}, row {y}; expected a display whose black is above 0 cd/m²")]
    Black {
        /// Column, from 0.
        x: usize,
        /// Row, from 0.
        y: usize,
    },
    /// The image is black everywhere.
    #[error("all black; expected some light")]
    AllBlack,
}

/// Returns a number with as many digits as people can read.
fn told(number: f64) -> String {
    if number < 1e6 { ((number * 1e4).ceil() / 1e4).to_string() } else { format!("{:e}", number.ceil()) }
}

/// Checks that the values of `light` are valid, that some of them are above 0, and what [`check_extent`] does.
///
/// # Panics
/// Panics unless there is a value for each pixel.
pub(super) fn check(light: &[f64], width: usize, height: usize, px_per_deg: f64) -> Result<(), VisionError> {
    check_extent(width, height, px_per_deg)?;
    assert_eq!(light.len(), width * height, "there is one value for each pixel");
    if let Some(i) = light.iter().position(|value| !(value.is_finite() && *value >= 0.0)) {
        return Err(VisionError::Light { value: light[i], x: i % width, y: i / width });
    }
    if light.iter().all(|value| *value == 0.0) { Err(VisionError::AllBlack) } else { Ok(()) }
}

/// Checks that there are pixels, that `px_per_deg` is positive, and that the picture fits into the field around the eye.
///
/// # Errors
/// Returns the [`VisionError`] of the first that does not hold.
pub fn check_extent(width: usize, height: usize, px_per_deg: f64) -> Result<(), VisionError> {
    if width == 0 || height == 0 {
        return Err(VisionError::TooSmall { width, height });
    }
    if !(px_per_deg > 0.0 && px_per_deg <= MAX_PX_PER_DEG) {
        return Err(VisionError::Sampling(px_per_deg));
    }
    let extent = width.max(height) as f64 / px_per_deg;
    if extent > MAX_DEG {
        return Err(VisionError::Extent(extent));
    }
    Ok(())
}
