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
pub enum Curve<T> {
    /// The curve of a finite depth.
    Finite {
        /// The depth n.
        n: u32,
        /// C(n−1+k, k), k < n.
        sums: Vec<T>,
    },
    /// The curve of n = ∞, stretched to reach 0 and 1 by what it misses of them; as printed, by nothing.
    Infinite {
        /// The curve as printed.
        interpolation: Interpolation,
        /// T(0), or 0.
        missing: f64,
    },
}

impl<T: Constant> Curve<T> {
    /// Makes the curve of depth `depth` that reaches 0 and 1.
    #[must_use]
    pub fn new(depth: Depth) -> Self {
        let Depth::Finite(n) = depth else {
            let interpolation = Interpolation::new(depth);
            return Curve::Infinite { missing: interpolation.value(0.0), interpolation };
        };
        let n = u32::from(n.clamp(1, Depth::MAX_FINITE));
        let mut sums = vec![1.0];
        for k in 1..n {
            sums.push(sums[k as usize - 1] * f64::from(n - 1 + k) / f64::from(k));
        }
        Curve::Finite { n, sums: sums.into_iter().map(T::of).collect() }
    }

    /// Makes the curve of depth `depth` as Bangay prints it.
    #[must_use]
    pub fn printed(depth: Depth) -> Self {
        match Curve::new(depth) {
            Curve::Infinite { interpolation, .. } => Curve::Infinite { interpolation, missing: 0.0 },
            finite => finite,
        }
    }

    /// Returns I_n(u): 0 for u ≤ 0, 1 for u ≥ 1, except that the printed curve of n = ∞ is not 0 at u = 0.
    #[must_use]
    #[inline(always)]
    pub fn value<N: Number<Constant = T>>(&self, u: N) -> N {
        match self {
            Curve::Finite { n, sums } => {
                // uⁿ·Σ C(n−1+k, k)·(1−u)^k below ½ and 1 − I_n(1−u) above, so no powers cancel.
                let (half, one) = (u.of(0.5), u.of(1.0));
                let u = u.within(0.0, 1.0);
                let low = u.min(one - u);
                let rest = one - low;
                let mut sum = u.of(0.0);
                for k in (0..*n as usize).rev() {
                    sum = sum * rest + u.all(sums[k]);
                }
                let value = power(low, *n) * sum;
                N::select(half.below(u), one - value, value)
            }
            Curve::Infinite { interpolation, missing } => {
                let stretched = |u| (interpolation.value(u) - missing) / (1.0 - 2.0 * missing);
                let [value] = N::each([u], |[u]| [stretched(u).clamp(0.0, 1.0)]);
                value
            }
        }
    }
}
