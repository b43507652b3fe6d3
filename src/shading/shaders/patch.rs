//! New in machband: light with a continuous slope, determined by the light values and slopes at the vertices. It uses
//! the reduced Clough–Tocher cubics of [`Patches`]. *c1-phong* uses the same cubics for normals.

use glam::DVec3;
use rayon::prelude::*;

use super::{gouraud::ShaderKernel, strips::select_by_smallest_weight};
use crate::shading::{
    frame::{ControlPoints, Frame, Patches, sub_triangle_ordinates},
    number::{Channels, Constant, Number},
};

/// Three cubics per triangle, one for each part in which a weight w_k is the smallest. They are polynomials in u = w_i
/// − w_k and v = w_j − w_k, the weights of the ends of the edge opposite corner k after the centroid's weight, 3·w_k,
/// has been subtracted.
#[derive(Clone, Debug)]
pub struct Patch<T, const C: usize>(Vec<[[Cubic<T>; C]; 3]>);

/// Coefficients of 1, u, u², u³, v, uv, u²v, v², uv², v³.
type Cubic<T> = [T; 10];

impl<T: Constant, const C: usize> Patch<T, C> {
    /// Prepares the shader for the triangles of `frame`.
    pub fn new(frame: &Frame, channels: Channels, patches: &Patches) -> Self {
        let triangles = (0..frame.triangles.len()).into_par_iter();
        Patch(triangles.map(|t| thirds(channels, &patches.control_points[t])).collect())
    }
}

fn thirds<T: Constant, const C: usize>(channels: Channels, points: &ControlPoints) -> [[Cubic<T>; C]; 3] {
    [0, 1, 2].map(|k| {
        let powers = powers(sub_triangle_ordinates(points, k)).map(|power| channels.pick::<T, C>(power));
        std::array::from_fn(|c| powers.map(|power| power[c]))
    })
}

/// Returns the coefficients of the powers of u and v for the cubic with the Bézier ordinates `b`, row by row from the
/// edge: u³b₀ + 3u²v·b₁ + 3uv²·b₂ + v³b₃ + 3s(u²b₄ + 2uv·b₅ + v²b₆) + 3s²(u·b₇ + v·b₈) + s³b₉ with s = 1 − u − v. The
/// coefficients are differences of the ordinates, starting at the centroid.
fn powers(b: [DVec3; 10]) -> [DVec3; 10] {
    let [b0, b1, b2, b3, b4, b5, b6, b7, b8, b9] = b;
    [
        b9,
        3.0 * (b7 - b9),
        3.0 * (b4 - 2.0 * b7 + b9),
        b0 - b9 - 3.0 * (b4 - b7),
        3.0 * (b8 - b9),
        6.0 * (b5 - b7 - b8 + b9),
        3.0 * (b1 - b4 - 2.0 * b5 + 2.0 * b7 + b8 - b9),
        3.0 * (b6 - 2.0 * b8 + b9),
        3.0 * (b2 - b6 - 2.0 * b5 + b7 + 2.0 * b8 - b9),
        b3 - b9 - 3.0 * (b6 - b8),
    ]
}

impl<T: Constant, const C: usize> ShaderKernel<T, C> for Patch<T, C> {
    #[inline(always)]
    fn light<N: Number<Constant = T>>(&self, triangle: usize, w: [N; 3], gouraud: [N; C]) -> [N; C] {
        let everywhere = w[0].of(0.0).below(w[0].of(1.0));
        let thirds = &self.0[triangle];
        select_by_smallest_weight(
            w,
            everywhere,
            gouraud,
            #[inline(always)]
            |k| third(&thirds[k], w[(k + 1) % 3] - w[k], w[(k + 2) % 3] - w[k]),
        )
    }
}

#[inline(always)]
fn third<N: Number, const C: usize>(cubics: &[Cubic<N::Constant>; C], u: N, v: N) -> [N; C] {
    let mut light = [u; C];
    for c in 0..C {
        let [one, u1, u2, u3, v1, uv, u2v, v2, uv2, v3] = cubics[c].map(|constant| u.all(constant));
        let along = ((u3 * u + u2v * v + u2) * u + (uv2 * v + uv) * v + u1) * u;
        light[c] = along + ((v3 * v + v2) * v + v1) * v + one;
    }
    light
}
