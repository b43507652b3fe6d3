//! Bangay's fixed boundary shader, eq. 4, as printed: it flattens the light at every edge. The light is continuous and,
//! at the edge, has no slope along the line from A. It is not C1 across the edge because these lines bend there. The
//! shader flattens the edges of linear fields, too.

use super::{
    gouraud::ShaderKernel,
    strips::{Curve, MIN_WIDTH, OTHERS, least, narrowed, select_by_smallest_weight},
};
use crate::{
    light::Depth,
    shading::{
        frame::Frame,
        number::{Channels, Constant, Number},
    },
};

/// Bangay eq. 4, J(t) = t·I_n(t/b')·(I_A − I_E) + I_E, in the strip of the smallest weight t, and Gouraud's light
/// elsewhere. This follows the text of the paper; its pseudocode uses the first weight below b, which makes the light
/// jump.
#[derive(Clone, Debug)]
pub struct Fixed<T, const C: usize> {
    /// The light values at the corners of each triangle.
    pub(super) lights: Vec<[[T; C]; 3]>,
    strip: T,
    /// I_n as printed.
    pub(super) step: Curve<T>,
}

/// A point in the strip opposite a corner.
pub(super) struct InStrip<N: Number, const C: usize> {
    /// The relative position across the strip, t/b'; 0 at the corners, where the strip has no width.
    pub across: N,
    /// I_E, the light where the line from the corner through the point meets the edge. Bangay eq. 3.
    pub on_edge: [N; C],
    /// The light J(t).
    pub light: [N; C],
}

impl<T: Constant, const C: usize> Fixed<T, C> {
    /// Prepares the shader for the triangles of `frame`, with strips of width `b`.
    pub fn new(frame: &Frame, channels: Channels, b: f64, depth: Depth) -> Self {
        let lights = frame.each_triangle(|t| frame.corners(t).map(|v| channels.pick(v.light)));
        Fixed { lights, strip: T::of(b), step: Curve::printed(depth) }
    }

    /// Returns `strip(k)` in the strip opposite corner k and Gouraud's light elsewhere.
    #[inline(always)]
    pub(super) fn in_strips<N: Number<Constant = T>>(
        &self,
        w: [N; 3],
        gouraud: [N; C],
        strip: impl Fn(usize) -> [N; C],
    ) -> [N; C] {
        select_by_smallest_weight(w, least(w).below(w[0].all(self.strip)), gouraud, strip)
    }

    /// Computes a point in the strip opposite corner `k`.
    #[inline(always)]
    pub(super) fn in_strip<N: Number<Constant = T>>(&self, triangle: usize, k: usize, w: [N; 3]) -> InStrip<N, C> {
        let (i, j) = OTHERS[k];
        let (lights, one) = (&self.lights[triangle], w[k].of(1.0));
        let across = w[k] / narrowed(w, self.strip).max(w[k].of(MIN_WIDTH));
        let per_rest = one / (one - w[k]);
        let rise = w[k] * self.step.value(across);
        let (mut on_edge, mut light) = ([w[k]; C], [w[k]; C]);
        for c in 0..C {
            on_edge[c] = (w[i].times(lights[i][c]) + w[j].times(lights[j][c])) * per_rest;
            light[c] = on_edge[c] + (w[k].all(lights[k][c]) - on_edge[c]) * rise;
        }
        InStrip { across, on_edge, light }
    }
}

impl<T: Constant, const C: usize> ShaderKernel<T, C> for Fixed<T, C> {
    #[inline(always)]
    fn light<N: Number<Constant = T>>(&self, triangle: usize, w: [N; 3], gouraud: [N; C]) -> [N; C] {
        self.in_strips(
            w,
            gouraud,
            #[inline(always)]
            |k| self.in_strip(triangle, k, w).light,
        )
    }
}
