//! The shaders with strips at the edges of triangles, Bangay §4; the widths of the strips, and I_n, the curve across them.
//!
//! The corners are A, B, C; the edge opposite A runs from B to C. All positions are positions on the **screen**: the
//! weights are affine there, and slopes matched elsewhere would not match in the picture.

use glam::DVec3;

use super::interpolated::OTHERS;
use crate::{
    light::{Depth, Interpolation},
    shading::frame::Frame,
};

/// The width used for strips of zero width, to avoid dividing by zero.
pub const MIN_WIDTH: f64 = 1e-30;

/// Returns the smallest of the weights.
pub fn least(w: [f64; 3]) -> f64 {
    w[0].min(w[1]).min(w[2])
}

/// Returns the width of the strip of the smallest weight, narrowed toward the corners as in Bangay's pseudocode:
/// `min(b, (1−w_i)/2, (1−w_j)/2)`. It has a kink at w = 1 − 2b.
pub fn narrowed(w: [f64; 3], b: f64) -> f64 {
    b.min((1.0 - w[0].max(w[1]).max(w[2])) * 0.5)
}

/// I_n across a strip.
///
/// The printed tanh for n = ∞ misses 0 and 1 by 0.0067. The repaired vertex shading must reach both, so that it begins
/// and ends without a step; for it, the tanh is stretched: `(T(u) − T(0))/(1 − 2T(0))`, with T(u) = (1 + tanh(5(u −
/// ½)))/2.
#[derive(Clone, Copy, Debug)]
pub struct Curve {
    interpolation: Interpolation,
    /// T(0), what the curve misses of 0 and 1; as printed, 0.
    missing: f64,
}

impl Curve {
    /// Makes the curve of depth `depth` that reaches 0 and 1.
    pub fn new(depth: Depth) -> Self {
        let interpolation = Interpolation::new(depth);
        Curve { interpolation, missing: interpolation.value(0.0) }
    }

    /// Makes the curve of depth `depth` as Bangay prints it.
    pub fn printed(depth: Depth) -> Self {
        Curve { missing: 0.0, ..Curve::new(depth) }
    }

    /// Returns I_n(u): 0 for u ≤ 0, 1 for u ≥ 1, except that the printed curve of n = ∞ is not 0 at u = 0.
    pub fn value(&self, u: f64) -> f64 {
        ((self.interpolation.value(u) - self.missing) / (1.0 - 2.0 * self.missing)).clamp(0.0, 1.0)
    }
}

/// Bangay's boundary shaders: in the strip of the smallest weight t,
/// J(t) = I_E + t·I_n(t/b')·(I_A − I_E) + t·I_n((b'−t)/b')·slope, and elsewhere Gouraud's light. This follows the text of the paper; its pseudocode uses the first weight below b,
/// which makes the light jump.
///
/// The fixed shader, eq. 4, has no slope: it flattens the light at every edge, also that of linear fields. The light is
/// continuous and, at the edge, has no slope along the line from A. It is not C1 across the edge because these lines bend
/// there. The second shader, §4.2.1, is intended to give the light at an edge a slope between the slopes of the two
/// triangles; at an edge without a neighbor, it is the fixed one.
pub struct Strips<'f> {
    pub frame: &'f Frame,
    /// b, the width of the strips.
    pub strip: f64,
    /// I_n as printed.
    pub step: Curve,
    pub slope: Slope,
}

/// The slope of the light at an edge.
pub enum Slope {
    /// 0.
    Fixed,
    /// (I_F − I_E)/2 leaves half of Gouraud's bend at the middle of an edge, and increases the bend elsewhere.
    Printed,
    /// (I_A − I_F)/2 is the mean of the two slopes, which makes the light C1 at the middle of the edges of parallelograms.
    Repaired,
}

impl Strips<'_> {
    /// Returns I_F, the light on the far edge of the neighbor across the edge opposite corner `k`, Bangay eqs. 5 and 6: with
    /// f = 2a/(1+a) from B, or −2a/(1−a) from C if a = 2w_B/(w_B+w_C) − 1 is negative. This is exact only if D is the
    /// reflection of A through the midpoint of the edge.
    fn beyond(&self, triangle: usize, k: usize, w: [f64; 3]) -> Option<DVec3> {
        let neighbor = self.frame.triangles[triangle].across[k]?;
        let (apex, (i, j)) = (self.frame.vertices[neighbor.apex as usize].light, OTHERS[k]);
        let a = w[i] * 2.0 / (w[i] + w[j]) - 1.0;
        let size = a.abs();
        let f = size * 2.0 / (size + 1.0);
        Some(self.frame.corners(triangle)[if a < 0.0 { j } else { i }].light * f + (1.0 - f) * apex)
    }

    /// Returns the light at these weights, where Gouraud's is `gouraud`.
    pub fn light(&self, triangle: usize, w: [f64; 3], gouraud: DVec3) -> DVec3 {
        let least = least(w);
        // The first of equal weights.
        let Some(k) = (0..3).find(|k| w[*k] <= least && least.max(0.0) < self.strip) else { return gouraud };
        let (i, j) = OTHERS[k];
        let [a, b, c] = self.frame.corners(triangle);
        let lights = [a.light, b.light, c.light];
        // t/b'; 0 at the corners, where the strip has no width.
        let across = w[k] / narrowed(w, self.strip).max(MIN_WIDTH);
        // I_E, the light where the line from the corner through the point meets the edge. Bangay eq. 3.
        let on_edge = (w[i] * lights[i] + w[j] * lights[j]) * (1.0 / (1.0 - w[k]));
        let fixed = on_edge + (lights[k] - on_edge) * (w[k] * self.step.value(across));
        let slope = match (&self.slope, self.beyond(triangle, k, w)) {
            (Slope::Printed, Some(beyond)) => beyond - on_edge,
            (Slope::Repaired, Some(beyond)) => lights[k] - beyond,
            _ => return fixed,
        };
        fixed + slope * (w[k] * self.step.value(1.0 - across) * 0.5)
    }
}
