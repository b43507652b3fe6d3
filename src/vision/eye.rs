//! The eye that looks at a picture, and how it treats the borders of the picture.

use super::sensitivity::Sensitivity;
use crate::light::LinearImage;

/// The eye of an average observer, adapted to a screen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Eye {
    /// Mean luminance of the field, cd/m²; above 0.
    pub luminance: f64,
    /// Contrast sensitivity.
    pub sensitivity: Sensitivity,
}

impl Default for Eye {
    /// 50 cd/m² is half the white of a typical screen.
    fn default() -> Self {
        Self::adapted_to(50.0)
    }
}

impl Eye {
    /// Creates an average eye that is adapted to `luminance` cd/m².
    #[must_use]
    pub fn adapted_to(luminance: f64) -> Self {
        Self { luminance, sensitivity: Sensitivity::default() }
    }
}

/// σ of the Gaussian window in which the eye averages light, degrees: the eye adapts locally, not to the whole field.
pub(super) const ADAPTATION_DEG: f64 = 0.5;

/// Returns the luminance of a linear sRGB color, 1 for white (IEC 61966-2-1).
#[must_use]
pub fn luminance([red, green, blue]: [f32; 3]) -> f64 {
    0.2126 * f64::from(red) + 0.7152 * f64::from(green) + 0.0722 * f64::from(blue)
}

/// Returns the luminance of each pixel of an image.
#[must_use]
pub fn luminances(image: &LinearImage) -> Vec<f64> {
    image.data.chunks_exact(3).map(|pixel| luminance([pixel[0], pixel[1], pixel[2]])).collect()
}

/// What lies beyond the ends of a profile or the edges of an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Border {
    /// The end values continue, as for a ramp between endless plateaus.
    Continues,
    /// The image is cut off: nobody knows what would lie beyond, so a channel ignores what is close to the border.
    Cut,
}

/// A channel ignores anything closer to the border than this, in its periods, and counts in full at twice this distance.
/// With less, the border changes the response to gratings; with more, pictures lack the coarse channels of their middle.
const MARGIN_PERIODS: f64 = 0.7;

impl Border {
    /// Returns the weight, 0…1, of a place at a distance from the border, given in periods of the channel.
    pub(super) fn weight(self, periods: f64) -> f64 {
        match self {
            Border::Continues => 1.0,
            Border::Cut => (periods / MARGIN_PERIODS - 1.0).clamp(0.0, 1.0),
        }
    }
}
