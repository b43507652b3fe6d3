//! The strips at the edges of triangles, Bangay §4: their widths, and I_n, the curve across them.
//!
//! The corners are A, B, C; the edge opposite A runs from B to C. All positions are positions on the **screen**: the
//! weights are affine there, and slopes matched elsewhere would not match in the picture.

use crate::light::{Depth, Interpolation};

/// For each corner, the other two, in order.
pub const OTHERS: [(usize, usize); 3] = [(1, 2), (2, 0), (0, 1)];

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
