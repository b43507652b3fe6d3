//! The strips at the edges of triangles, Bangay §4: their widths, and I_n, the curve across them.
//!
//! The corners are A, B, C; the edge opposite A runs from B to C. All positions are positions on the **screen**: the
//! weights are affine there, and slopes matched elsewhere would not match in the picture.

use crate::{
    light::{Depth, Interpolation, interpolation::TANH_K},
    shading::number::{Constant, Number, power, select},
};

/// For each corner, the other two, in order.
pub const OTHERS: [(usize, usize); 3] = [(1, 2), (2, 0), (0, 1)];

/// The width used for strips of zero width, to avoid dividing by zero.
pub const MIN_WIDTH: f64 = 1e-30;

/// φ(x) = x − x²/4 below x = 2, where it reaches 1 with slope 0; 1 beyond, and 0 for negative x. For x ≥ 0, φ(x) ≤ x.
#[inline(always)]
pub fn smooth_clamp<N: Number>(x: N) -> N {
    let x = x.within(0.0, 2.0);
    x - x * x * x.of(0.25)
}

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

/// I_n across a strip, and its integral.
///
/// The printed tanh for n = ∞ misses 0 and 1 by 0.0067: unmodified, a strip would match neither the slope at its edge
/// nor the interior. For shaders that promise a continuous slope, the tanh is stretched to reach both: `(T(u) −
/// T(0))/(1 − 2T(0))`, with T(u) = (1 + tanh(5(u − ½)))/2. Then *exact* and *cut* are C1 across an edge for n = ∞ as
/// well. The tanh's own slope at the ends, 0.067, remains: *exact* keeps a kink of 0.067·c where its strip ends; *cut*
/// has none. (The steeper tanh(10(u − ½)) would leave 0.0009, but would double the ripple of the strip.)
#[derive(Clone, Debug)]
pub enum Curve<T> {
    /// The curve of a finite depth.
    Finite {
        /// The depth n.
        n: u32,
        /// C(n−1+k, k), k < n.
        sums: Vec<T>,
        /// ½·C(2n−1, n).
        hump: T,
    },
    /// The curve of n = ∞, as printed.
    Printed(Interpolation),
    /// The curve of n = ∞, stretched to reach 0 and 1.
    Stretched(Interpolation),
}

impl<T: Constant> Curve<T> {
    /// Makes the curve of depth `depth` for shaders that promise a continuous slope.
    #[must_use]
    pub fn new(depth: Depth) -> Self {
        let Depth::Finite(n) = depth else { return Curve::Stretched(Interpolation::new(depth)) };
        let n = u32::from(n.clamp(1, Depth::MAX_FINITE));
        let mut sums = vec![1.0];
        for k in 1..n {
            sums.push(sums[k as usize - 1] * f64::from(n - 1 + k) / f64::from(k));
        }
        let hump = sums[n as usize - 1] * f64::from(2 * n - 1) / f64::from(n) / 2.0;
        Curve::Finite { n, sums: sums.into_iter().map(T::of).collect(), hump: T::of(hump) }
    }

    /// Makes the curve of depth `depth` as Bangay prints it.
    #[must_use]
    pub fn printed(depth: Depth) -> Self {
        match Curve::new(depth) {
            Curve::Stretched(interpolation) => Curve::Printed(interpolation),
            finite => finite,
        }
    }

    /// Returns I_n(u): 0 for u ≤ 0, 1 for u ≥ 1, except that the printed curve of n = ∞ is not 0 at u = 0.
    #[must_use]
    #[inline(always)]
    pub fn value<N: Number<Constant = T>>(&self, u: N) -> N {
        match self {
            Curve::Finite { n, sums, .. } => {
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
            Curve::Printed(interpolation) => each(u, |u| interpolation.value(u)),
            Curve::Stretched(interpolation) => each(u, |u| stretched(interpolation, u)),
        }
    }

    /// Returns Ψ_n(u), the integral of 1 − I_n from u to 1: ½ at 0, and 0 for u ≥ 1.
    ///
    /// With v = 1 − u, this is ∫₀ᵛ I_n = (v − ½)·I_n(v) + ½·C(2n−1, n)·(v(1−v))ⁿ, from the recurrence of the incomplete
    /// beta function; v²/2 for n = 1. For n = ∞, it is the integral of the stretched tanh, which is a logarithm of
    /// cosh.
    #[must_use]
    #[inline(always)]
    pub fn remaining_integral<N: Number<Constant = T>>(&self, u: N) -> N {
        match self {
            Curve::Finite { n: 1, .. } => {
                let v = (u.of(1.0) - u).within(0.0, 1.0);
                v * v * v.of(0.5)
            }
            Curve::Finite { n, hump, .. } => {
                let v = (u.of(1.0) - u).within(0.0, 1.0);
                (v - v.of(0.5)) * self.value(v) + power(v * (v.of(1.0) - v), *n).times(*hump)
            }
            Curve::Printed(interpolation) | Curve::Stretched(interpolation) => {
                each(u, |u| stretched_remaining_integral(interpolation, u))
            }
        }
    }
}

#[inline(always)]
fn each<N: Number>(u: N, of: impl Fn(f64) -> f64) -> N {
    let [value] = N::each([u], |[u]| [of(u)]);
    value
}

fn stretched(interpolation: &Interpolation, u: f64) -> f64 {
    let residual = interpolation.value(0.0);
    if u <= 0.0 {
        0.0
    } else if u >= 1.0 {
        1.0
    } else {
        (interpolation.value(u) - residual) / (1.0 - 2.0 * residual)
    }
}

fn stretched_remaining_integral(interpolation: &Interpolation, u: f64) -> f64 {
    let v = 1.0 - u.clamp(0.0, 1.0);
    // ∫ T = ln(1 + e^(2k(v−½)))/2k
    let primitive = |v: f64| (2.0 * TANH_K * (v - 0.5)).exp().ln_1p() / (2.0 * TANH_K);
    let residual = interpolation.value(0.0);
    (primitive(v) - primitive(0.0) - v * residual) / (1.0 - 2.0 * residual)
}
