//! The eye that looks at a picture.

use super::sensitivity::Sensitivity;
use crate::light::LinearImage;

/// The eye of an average observer, adapted to a screen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Eye {
    /// Mean luminance of the field, cd/m²; above 0.
    pub luminance: f64,
    /// Contrast sensitivity.
    pub sensitivity: Sensitivity,
    pub masking: Masking,
}

/// To what a difference is relative, and how a reference masks it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Masking {
    /// σ of the Gaussian window in which the eye averages light, degrees: it adapts to the light nearby.
    pub adaptation_deg: f64,
    /// σ of a band's Gaussian, given as a ratio of frequencies.
    pub ratio: f64,
    /// The reference's response at which it masks a band to 1/√2.
    pub half: f64,
}

impl Default for Masking {
    /// The bands have 1.5 octaves at half height, close to the median of cells in V1 (1.4 in De Valois, Albrecht &
    /// Thorell 1982, Vis. Res. 22:545). `half` is the peak response to ModelFest's Gabor of 4 cycles per degree at its
    /// measured threshold, which `cargo run --release -p tools -- thresholds` derives.
    fn default() -> Self {
        Self { adaptation_deg: 0.5, ratio: 0.65, half: 1.83 }
    }
}

impl Default for Eye {
    /// 50 cd/m² is half the white of a typical screen.
    fn default() -> Self {
        Self::adapted_to(50.0)
    }
}

impl Eye {
    /// Creates an average eye that is adapted to `luminance` cd/m².
    pub fn adapted_to(luminance: f64) -> Self {
        Self { luminance, sensitivity: Sensitivity::default(), masking: Masking::default() }
    }
}

/// Returns the luminance of a linear sRGB color, 1 for white (IEC 61966-2-1).
pub fn luminance([red, green, blue]: [f32; 3]) -> f64 {
    0.2126 * f64::from(red) + 0.7152 * f64::from(green) + 0.0722 * f64::from(blue)
}

/// Returns the luminance of each pixel of an image.
pub fn luminances(image: &LinearImage) -> Vec<f64> {
    image.data.chunks_exact(3).map(|pixel| luminance([pixel[0], pixel[1], pixel[2]])).collect()
}
