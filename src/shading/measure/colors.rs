//! The colors of maps.

use glam::DVec3;

/// The scale from nothing to the largest value, as encoded sRGB: from blue through gray to yellow, with increasing lightness,
/// so that all trichromats and dichromats see the same order.
const MAP: [[f64; 3]; 5] =
    [[0.13, 0.19, 0.42], [0.27, 0.36, 0.58], [0.55, 0.53, 0.52], [0.86, 0.72, 0.33], [1.0, 0.96, 0.62]];

/// Returns the color of a value that is this share of the largest, as encoded sRGB.
pub fn color(share: f64) -> [f64; 3] {
    let at = share.clamp(0.0, 1.0) * (MAP.len() - 1) as f64;
    let low = (at as usize).min(MAP.len() - 2);
    let (a, b) = (DVec3::from_array(MAP[low]), DVec3::from_array(MAP[low + 1]));
    a.lerp(b, at - low as f64).to_array()
}
