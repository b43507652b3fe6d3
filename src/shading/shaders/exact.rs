//! New in machband: Gouraud's light, with the slope across every edge matched to the neighbor's.

use super::{
    gouraud::ShaderKernel,
    strips::{Curve, OTHERS, smooth_clamp},
};
use crate::{
    light::Depth,
    shading::{
        frame::{Frame, bends},
        number::{Channels, Constant, Number, plus},
    },
};

/// L + Σ_k c_k·w_k·(1 − I_n(w_k/b'_k)), where b'_k = `b·φ((1−w_i)/2b)·φ((1−w_j)/2b)`: the strip narrows toward the
/// corners without a kink.
///
/// The light is Cⁿ across the entire edge of any two triangles; a linear field stays linear (all c are 0). The strip
/// adds no net change: the added slope runs from +c through −0.69c (n = 2) or −0.78c (n = 3) to 0, which makes a bump
/// of at most 0.27·b·c.
#[derive(Clone, Debug)]
pub struct Exact<T, const C: usize> {
    /// c of each edge.
    bends: Vec<[[T; C]; 3]>,
    strip: T,
    /// 1/2b.
    per_corner: T,
    curve: Curve<T>,
}

impl<T: Constant, const C: usize> Exact<T, C> {
    /// Prepares the shader for the triangles of `frame`, with strips of width `b`, above 0.
    pub fn new(frame: &Frame, channels: Channels, b: f64, depth: Depth) -> Self {
        let bends = bends(frame).iter().map(|edges| edges.map(|edge| channels.pick(edge.c))).collect();
        Exact { bends, strip: T::of(b), per_corner: T::of(0.5 / b), curve: Curve::new(depth) }
    }
}

impl<T: Constant, const C: usize> ShaderKernel<T, C> for Exact<T, C> {
    #[inline(always)]
    fn light<N: Number<Constant = T>>(&self, triangle: usize, w: [N; 3], gouraud: [N; C]) -> [N; C] {
        let (zero, one) = (w[0].of(0.0), w[0].of(1.0));
        let mut light = gouraud;
        for k in 0..3 {
            // No strip is wider than this.
            if !N::any(w[k].below(one.all(self.strip))) {
                continue;
            }
            let (i, j) = OTHERS[k];
            let narrowed =
                smooth_clamp((one - w[i]).times(self.per_corner)) * smooth_clamp((one - w[j]).times(self.per_corner));
            let width = narrowed.times(self.strip);
            let bump = w[k] * (one - self.curve.value(w[k] / width));
            // At a corner, two strips have zero width and zero weight.
            light = plus(light, N::select(w[k].below(width), bump, zero), &self.bends[triangle][k]);
        }
        light
    }
}
