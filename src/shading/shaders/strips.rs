//! The strips at the edges of triangles. Bangay §4.
//!
//! Corners are A, B, C; the edge opposite A runs from B to C. All places are those on the **screen**: the weights are
//! affine there, and slopes matched elsewhere do not match in the picture.

use crate::shading::number::{Number, select};

/// The other two corners, in order.
pub const OTHERS: [(usize, usize); 3] = [(1, 2), (2, 0), (0, 1)];

/// Stands for the width of a strip that has none, so that nothing is divided by zero.
pub const NARROWEST: f64 = 1e-30;

/// φ(x) = x − x²/4 below 2, where it reaches 1 with slope 0; 1 beyond; 0 for negative x. φ(x) ≤ x.
#[inline(always)]
pub fn ease<N: Number>(x: N) -> N {
    let x = x.within(0.0, 2.0);
    x - x * x * x.of(0.25)
}

/// The smallest of the weights.
#[inline(always)]
pub fn least<N: Number>(w: [N; 3]) -> N {
    w[0].min(w[1]).min(w[2])
}

/// The width of the strip with the smallest weight as Bangay's pseudo-code narrows it toward the corners: `min(b,
/// (1−w_i)/2, (1−w_j)/2)`. It has a kink at w = 1 − 2b.
#[inline(always)]
pub fn narrowed<N: Number>(w: [N; 3], b: N::Constant) -> N {
    let most = w[0].max(w[1]).max(w[2]);
    most.all(b).min((most.of(1.0) - most) * most.of(0.5))
}

/// `inside(k)` where corner k has the smallest weight, the first of equal ones, and `wanted` says so; `outside` elsewhere.
#[inline(always)]
pub fn by_smallest<N: Number, const C: usize>(
    w: [N; 3],
    wanted: N::Mask,
    outside: [N; C],
    inside: impl Fn(usize) -> [N; C],
) -> [N; C] {
    // Where two weights are equal the last chosen wins, which is the first corner.
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
