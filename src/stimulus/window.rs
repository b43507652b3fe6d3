//! From a formula to the pixels of a square window.
//!
//! An edge that runs along the pixels is exactly sharp; an oblique one is anti-aliased by the share of each pixel's
//! area that lies on either side, in linear light.

use super::orientation::Grid;
use crate::light::LinearImage;

/// A luminance that varies along one direction only.
pub(super) trait Profile {
    /// Relative luminance at `x` window sides from the centre line, positive towards the orientation; at a jump, the
    /// value beyond it.
    fn value(&self, x: f64) -> f64;

    /// Where the luminance jumps, and by how much.
    fn jumps(&self) -> Vec<(f64, f64)>;
}

/// The light of a window that varies along its orientation.
pub(super) fn across(size: u32, orientation_deg: f64, weights: [f64; 3], profile: &impl Profile) -> LinearImage {
    let grid = Grid::new(size, orientation_deg);
    let jumps = if is_sharp(&grid) { Vec::new() } else { profile.jumps() };
    let (reach, side) = (half_extent(&grid), f64::from(size));
    LinearImage::from_fn(size, size, |ix, iy| {
        let x = grid.across(ix, iy);
        let smoothed: f64 = jumps
            .iter()
            .map(|(at, height)| ((x - at) * side, height))
            .filter(|(distance, _)| distance.abs() < reach)
            .map(|(distance, height)| {
                let sharp = if distance >= 0.0 { 1.0 } else { 0.0 };
                height * (share_beyond(&grid, distance) - sharp)
            })
            .sum();
        light(weights, profile.value(x) + smoothed)
    })
}

/// The light of a pixel of relative luminance `luminance`.
pub(super) fn light(weights: [f64; 3], luminance: f64) -> [f32; 3] {
    weights.map(|weight| (weight * luminance) as f32)
}

/// Whether the edges of this orientation run along the pixels.
pub(super) fn is_sharp(grid: &Grid) -> bool {
    grid.cos == 0.0 || grid.sin == 0.0
}

/// Half the extent of a pixel along the orientation, pixels.
fn half_extent(grid: &Grid) -> f64 {
    (grid.cos.abs() + grid.sin.abs()) / 2.0
}

/// The share of a pixel's area that lies beyond an edge which its centre is `distance` pixels past (negative: before).
///
/// The distance of a random point of the pixel is the sum of two uniform variables of widths |cos θ| and |sin θ|; this
/// is its distribution function, a quadratic, a line and a quadratic.
fn share_beyond(grid: &Grid, distance: f64) -> f64 {
    let (a, b) = (grid.cos.abs(), grid.sin.abs());
    let (outer, inner) = ((a + b) / 2.0, (a - b).abs() / 2.0);
    let d = distance.abs();
    let beyond = if d >= outer {
        1.0
    } else if d <= inner {
        0.5 + d / a.max(b)
    } else {
        1.0 - (outer - d).powi(2) / (2.0 * a * b)
    };
    if distance >= 0.0 { beyond } else { 1.0 - beyond }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against counting the points of a fine grid within the pixel.
    #[test]
    fn the_share_is_that_of_the_area() {
        for degrees in [0.5, 13.0, 45.0, 77.7, 123.0, 200.0, 359.0] {
            let grid = Grid::new(16, degrees);
            for distance in [-0.8, -0.6, -0.3, -0.05, 0.0, 0.11, 0.42, 0.66, 0.75] {
                let fine = 400;
                let inside = (0..fine * fine)
                    .filter(|i| {
                        let at = |i: i32| (f64::from(i) + 0.5) / f64::from(fine) - 0.5;
                        distance + at(i % fine) * grid.cos + at(i / fine) * grid.sin >= 0.0
                    })
                    .count();
                let counted = inside as f64 / f64::from(fine * fine);
                assert!((share_beyond(&grid, distance) - counted).abs() < 3e-3, "{degrees}° {distance}");
            }
        }
    }
}
