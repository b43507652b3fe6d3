//! New in machband: Gouraud's light with the corner cut off at every edge. The slope changes from one side's value to
//! the other's without overshoot.

use super::{
    gouraud::ShaderKernel,
    strips::{Curve, OTHERS, smooth_clamp},
};
use crate::{
    light::Depth,
    shading::{
        frame::{Bend, Frame, bends},
        number::{Channels, Constant, Number, plus},
    },
};

/// L − Σ_k c_k·b'_k·Ψ_n(w_k/b'_k), where Ψ is [`Curve::remaining_integral`]. The light is C1 across edges. On an edge
/// itself, it changes by −c·b'/2. b may be up to 1; n = 1 is best.
///
/// The width of a strip is b' = `b·φ(σ/(b·m_B))·φ((1−σ)/(b·m_C))`. σ = w_C + w_A·s_A is the point's perpendicular
/// projection onto the edge. The width therefore does not change perpendicular to the edge, and it falls below w_A
/// before the other two edges are reached.
#[derive(Clone, Debug)]
pub struct Cut<T, const C: usize> {
    edges: Vec<[Edge<T, C>; 3]>,
    strip: T,
    curve: Curve<T>,
}

/// The data of an edge for *cut*; see [`Bend`].
#[derive(Clone, Copy, Debug)]
struct Edge<T, const C: usize> {
    /// −c.
    fall: [T; C],
    foot: T,
    /// 1/(b·m) at either end.
    per_reach: [T; 2],
}

impl<T: Constant, const C: usize> Cut<T, C> {
    /// Prepares the shader for the triangles of `frame`, with strips of width `b`, above 0 and at most 1.
    pub fn new(frame: &Frame, channels: Channels, b: f64, depth: Depth) -> Self {
        let b = b.min(1.0);
        let edge = |bend: Bend| Edge {
            fall: channels.pick(-bend.c),
            foot: T::of(bend.foot),
            per_reach: [bend.start, bend.end].map(|m| T::of(1.0 / (b * m))),
        };
        Cut {
            edges: bends(frame).into_iter().map(|bends| bends.map(edge)).collect(),
            strip: T::of(b),
            curve: Curve::new(depth),
        }
    }
}

impl<T: Constant, const C: usize> ShaderKernel<T, C> for Cut<T, C> {
    #[inline(always)]
    fn light<N: Number<Constant = T>>(&self, triangle: usize, w: [N; 3], gouraud: [N; C]) -> [N; C] {
        let zero = w[0].of(0.0);
        let mut light = gouraud;
        for k in 0..3 {
            // No strip is wider than this.
            if !N::any(w[k].below(zero.all(self.strip))) {
                continue;
            }
            let (i, j) = OTHERS[k];
            let Edge { fall, foot, per_reach: [per_start, per_end] } = &self.edges[triangle][k];
            let over = w[k].times(*foot);
            let (from_start, from_end) = (w[j] + over, w[i] + w[k] - over);
            let width =
                (smooth_clamp(from_start.times(*per_start)) * smooth_clamp(from_end.times(*per_end))).times(self.strip);
            let corner = width * self.curve.remaining_integral(w[k] / width);
            light = plus(light, N::select(w[k].below(width), corner, zero), fall);
        }
        light
    }
}
