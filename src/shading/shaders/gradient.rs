//! Bangay's second boundary shader, §4.2.1: it is intended to give the light at an edge a slope between the slopes of
//! the two triangles.

use super::{fixed::Fixed, gouraud::ShaderKernel, strips::OTHERS};
use crate::{
    light::Depth,
    shading::{
        frame::{Frame, Neighbor},
        number::{Channels, Constant, Number},
    },
};

/// J(t) = t·I_n(t/b')·(I_A − I_E) + t·I_n((b'−t)/b')·slope + I_E in the strip of the smallest weight. At an edge
/// without a neighbor, it is the light of [`Fixed`].
#[derive(Clone, Debug)]
pub struct Gradient<T, const C: usize> {
    fixed: Fixed<T, C>,
    /// The light of the neighbor's vertex D across each edge.
    apexes: Vec<[Option<[T; C]>; 3]>,
    /// The slope at the edge. As printed, (I_F − I_E)/2 leaves half of Gouraud's bend at the middle of an edge, and
    /// increases the bend elsewhere. Repaired, (I_A − I_F)/2 is the mean of the two slopes, which makes the light C1 at the
    /// middle of the edges of parallelograms.
    is_repaired: bool,
}

impl<T: Constant, const C: usize> Gradient<T, C> {
    /// Prepares the shader for the triangles of `frame`, with strips of width `b`.
    pub fn new(frame: &Frame, channels: Channels, is_repaired: bool, b: f64, depth: Depth) -> Self {
        let apex = |neighbor: Neighbor| channels.pick(frame.vertices[neighbor.apex as usize].light);
        let apexes = frame.each_triangle(|t| frame.triangles[t].across.map(|neighbor| neighbor.map(apex)));
        Gradient { fixed: Fixed::new(frame, channels, b, depth), apexes, is_repaired }
    }

    #[inline(always)]
    fn in_strip<N: Number<Constant = T>>(&self, triangle: usize, k: usize, w: [N; 3]) -> [N; C] {
        let strip = self.fixed.in_strip(triangle, k, w);
        let Some(apex) = &self.apexes[triangle][k] else { return strip.light };
        let (i, j) = OTHERS[k];
        let (lights, zero, one) = (&self.fixed.lights[triangle], w[k].of(0.0), w[k].of(1.0));
        // I_F, the light on the neighbor's far edge, Bangay eqs. 5 and 6: with f = 2a/(1+a) from B, or −2a/(1−a) from C
        // if a = 2w_B/(w_B+w_C) − 1 is negative. This is exact only if D is the reflection of A through the midpoint of
        // the edge.
        let a = w[i] * w[i].of(2.0) / (w[i] + w[j]) - one;
        let nearer_j = a.below(zero);
        let size = a.max(zero - a);
        let f = size * size.of(2.0) / (size + one);
        let fall = w[k] * self.fixed.step.value(one - strip.across) * w[k].of(0.5);
        let mut light = strip.light;
        for c in 0..C {
            let near = N::select(nearer_j, one.all(lights[j][c]), one.all(lights[i][c]));
            let beyond = near * f + (one - f).times(apex[c]);
            let slope = if self.is_repaired { one.all(lights[k][c]) - beyond } else { beyond - strip.on_edge[c] };
            light[c] = light[c] + slope * fall;
        }
        light
    }
}

impl<T: Constant, const C: usize> ShaderKernel<T, C> for Gradient<T, C> {
    #[inline(always)]
    fn light<N: Number<Constant = T>>(&self, triangle: usize, w: [N; 3], gouraud: [N; C]) -> [N; C] {
        self.fixed.in_strips(
            w,
            gouraud,
            #[inline(always)]
            |k| self.in_strip(triangle, k, w),
        )
    }
}
