//! Steps of equal brightness on a screen (Shoaff §2.1.1): the levels I_j = r^j·I₀ with r = (1/I₀)^(1/n), and the codes
//! nearest to them.

use super::DisplayProfile;
use crate::light::{
    Bits, Quantizer,
    transfer::{equal_brightness_levels, nearest_equal_brightness_level},
};

/// One level and its codes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// The index j, from 0 at the screen's black to n at its white.
    pub level: usize,
    /// I_j relative to white; includes the light of the screen's black.
    pub intensity: f64,
    /// I_j in cd/m²; `None` if white was not measured.
    pub cd_m2: Option<f64>,
    /// The nearest 8-bit codes of red, green and blue under the profile.
    pub codes: [u8; 3],
    /// The light of the green code relative to white; includes the light of the screen's black.
    pub emitted: f64,
    /// The index of the level nearest to that light; differs from j if 8 bits are too few.
    pub nearest: usize,
}

/// Returns the n + 1 levels from `i0`, the light of code 0 relative to white, up to white.
///
/// A profile's linear light is the light that a code adds to black, so level I_j needs the linear light (I_j − I₀)/(1 −
/// I₀).
///
/// # Errors
/// Returns an error if `i0` is not strictly between 0 and 1, or if `n` is 0.
pub fn steps(profile: &DisplayProfile, i0: f64, n: usize) -> Result<Vec<Step>, String> {
    let quantizer = Quantizer::new(&profile.transfers, Bits::Eight);
    let step = |(level, intensity): (usize, f64)| {
        let linear = ((intensity - i0) / (1.0 - i0)).clamp(0.0, 1.0);
        let codes = quantizer.codes([linear as f32; 3]);
        let emitted = i0 + quantizer.linear(codes)[1] * (1.0 - i0);
        Step {
            level,
            intensity,
            cd_m2: profile.luminance.map(|range| range.white_cd_m2 * intensity),
            codes: codes.map(|code| code.min(255) as u8),
            emitted,
            nearest: nearest_equal_brightness_level(emitted, i0, n),
        }
    };
    Ok(equal_brightness_levels(i0, n)?.into_iter().enumerate().map(step).collect())
}
