//! The strips at the edges of triangles, Bangay §4: their widths, and I_n, the curve across them.
//!
//! The corners are A, B, C; the edge opposite A runs from B to C. All positions are positions on the **screen**: the
//! weights are affine there, and slopes matched elsewhere would not match in the picture.

use crate::{
    light::{Depth, Interpolation},
    shading::number::{Constant, Number, power, select},
};

/// For each corner, the other two, in order.
pub const OTHERS: [(usize, usize); 3] = [(1, 2), (2, 0), (0, 1)];

/// The width used for strips of zero width, to avoid dividing by zero.
pub const MIN_WIDTH: f64 = 1e-30;

/// Returns the smallest of the weights.
#[inline(always)]
pub fn least<N: Number>(w: [N; 3]) -> N {
    w[0].min(w[1]).min(w[2])
}

/// Returns the width of the strip of the smallest weight, narrowed toward the corners as in Bangay's pseudocode:
/// `min(b, (1−w_i)/2, (1−w_j)/2)`. It has a kink at w = 1 − 2b.
#[inline(always)]
pub fn narrowed<N: Number>(w: [N; 3], b: N::Constant) -> N {
    let most = w[0].max(w[1]).max(w[2]);
    most.all(b).min((most.of(1.0) - most) * most.of(0.5))
}

/// Returns `inside(k)` where `wanted` is true and corner k has the smallest weight (the first of equal weights), and
/// `outside` elsewhere.
#[inline(always)]
pub fn select_by_smallest_weight<N: Number, const C: usize>(
    w: [N; 3],
    wanted: N::Mask,
    outside: [N; C],
    inside: impl Fn(usize) -> [N; C],
) -> [N; C] {
    // Where weights are equal, the corner that is processed last takes precedence, which is the first corner.
    let least = least(w);
    let mut light = outside;
    for k in [2, 1, 0] {
        let here = w[k].at_most(least) & wanted;
        if N::any(here) {
            light = select(here, inside(k), light);
        }
    }
    light
}

/// I_n across a strip.
///
/// The printed tanh for n = ∞ misses 0 and 1 by 0.0067. The repaired vertex shading must reach both, so that it begins
/// and ends without a step; for it, the tanh is stretched: `(T(u) − T(0))/(1 − 2T(0))`, with T(u) = (1 + tanh(5(u −
/// ½)))/2.
#[derive(Clone, Debug)]
pub struct Curve<T> {
    interpolation: Interpolation,
    /// C(n−1+k, k), k < n, of a finite depth n; empty for n = ∞.
    sums: Vec<T>,
    /// T(0), what the curve of n = ∞ misses of 0 and 1; as printed, 0.
    missing: f64,
}

impl<T: Constant> Curve<T> {
    /// Makes the curve of depth `depth` that reaches 0 and 1.
    pub fn new(depth: Depth) -> Self {
        let interpolation = Interpolation::new(depth);
        let sums = if let Interpolation::Polynomial(sums) = interpolation { sums } else { &[] };
        Curve { sums: sums.iter().map(|c| T::of(*c)).collect(), missing: interpolation.value(0.0), interpolation }
    }

    /// Makes the curve of depth `depth` as Bangay prints it.
    pub fn printed(depth: Depth) -> Self {
        Curve { missing: 0.0, ..Curve::new(depth) }
    }

    /// Returns I_n(u): 0 for u ≤ 0, 1 for u ≥ 1, except that the printed curve of n = ∞ is not 0 at u = 0.
    #[inline(always)]
    pub fn value<N: Number<Constant = T>>(&self, u: N) -> N {
        let Curve { interpolation, sums, missing } = self;
        if sums.is_empty() {
            let stretched = |u| (interpolation.value(u) - missing) / (1.0 - 2.0 * missing);
            let [value] = N::each([u], |[u]| [stretched(u).clamp(0.0, 1.0)]);
            return value;
        }
        // uⁿ·Σ C(n−1+k, k)·(1−u)^k below ½ and 1 − I_n(1−u) above, so no powers cancel.
        let (half, one) = (u.of(0.5), u.of(1.0));
        let u = u.within(0.0, 1.0);
        let low = u.min(one - u);
        let rest = one - low;
        let mut sum = u.of(0.0);
        for k in (0..sums.len()).rev() {
            sum = sum * rest + u.all(sums[k]);
        }
        let value = power(low, sums.len() as u32) * sum;
        N::select(half.below(u), one - value, value)
    }
}
