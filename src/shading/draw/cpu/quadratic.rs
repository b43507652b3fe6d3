//! The quadratic through the lights of the corners and of the middles of the edges.

use pulp::Simd;

use super::{
    band::{Chunk, Rows},
    channels::Channels,
    lanes::{Lanes, add},
    weights::{WeightPlanes, Weights},
};
use crate::shading::{Frame, boundary::others};

/// Gouraud's light plus 4·w_i·w_j times what each middle has more than the mean of its edge's ends; see
/// [`shaders::quadratic`](crate::shading::shaders::quadratic).
#[derive(Clone, Debug)]
pub(super) struct Quadratic<const C: usize, const Q: usize>(Vec<Triangle<C, Q>>);

#[derive(Clone, Copy, Debug)]
struct Triangle<const C: usize, const Q: usize> {
    weights: WeightPlanes<Q>,
    excess: [[f32; C]; 3],
}

impl<const C: usize, const Q: usize> Quadratic<C, Q> {
    /// `middles` are the lights at the middles of every triangle's edges.
    pub fn new(frame: &Frame, seen: &[u32], channels: Channels, middles: &[[glam::DVec3; 3]]) -> Self {
        let triangle = |t: &u32| {
            let corners = frame.corners(*t as usize).map(|v| v.light);
            let excess = [0, 1, 2].map(|k| {
                let (i, j) = others(k);
                channels.pick_f32((middles[*t as usize][k] - (corners[i] + corners[j]) / 2.0) * 4.0)
            });
            Triangle { weights: WeightPlanes::lit::<C>(frame, *t, channels), excess }
        };
        Quadratic(seen.iter().map(triangle).collect())
    }
}

#[derive(Clone, Copy)]
pub(super) struct Row<const C: usize, const Q: usize> {
    weights: Weights<Q>,
    excess: [[f32; C]; 3],
}

impl<const C: usize, const Q: usize> Rows<C> for Quadratic<C, Q> {
    type Row = Row<C, Q>;

    #[inline(always)]
    fn row<S: Simd>(&self, _: S, triangle: u32, x: u32, y: u32) -> Row<C, Q> {
        let triangle = &self.0[triangle as usize];
        Row { weights: triangle.weights.row(x, y), excess: triangle.excess }
    }

    #[inline(always)]
    fn light<S: Simd>(&self, row: &Row<C, Q>, chunk: Chunk<S>) -> [Lanes<S>; C] {
        let mut light: [Lanes<S>; C] = row.weights.light(&chunk);
        let w = row.weights.along(&chunk);
        for k in 0..3 {
            let (i, j) = others(k);
            let bulge = w[i] * w[j];
            light = add(
                light,
                #[inline(always)]
                |c| bulge * row.excess[k][c],
            );
        }
        light
    }
}
