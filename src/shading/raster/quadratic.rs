//! The quadratic through the lights of the corners and of the middles of the edges.

use pulp::Simd;

use super::{
    band::{Chunk, Rows},
    channels::Channels,
    lanes::{Lanes, add},
    plane::{Line, Planes, Slopes},
    strips::{WeightPlanes, Weights},
};
use crate::shading::{Frame, boundary::others};

/// Gouraud's light plus 4·w_i·w_j times what each middle has more than the mean of its edge's ends; see
/// [`shaders::quadratic`](crate::shading::shaders::quadratic).
#[derive(Clone, Debug)]
pub(super) struct Quadratic<const C: usize>(Vec<Triangle<C>>);

#[derive(Clone, Copy, Debug)]
struct Triangle<const C: usize> {
    light: Planes<C>,
    weights: WeightPlanes,
    excess: [[f32; C]; 3],
}

impl<const C: usize> Quadratic<C> {
    /// `middles` are the lights at the middles of every triangle's edges.
    pub fn new(frame: &Frame, seen: &[u32], channels: Channels, middles: &[[glam::DVec3; 3]]) -> Self {
        let triangle = |t: &u32| {
            let slopes = Slopes::of_triangle(frame, *t);
            let corners = frame.corners(*t as usize).map(|v| v.light);
            let excess = [0, 1, 2].map(|k| {
                let (i, j) = others(k);
                channels.pick_f32((middles[*t as usize][k] - (corners[i] + corners[j]) / 2.0) * 4.0)
            });
            Triangle { light: channels.planes(&slopes, frame, *t), weights: WeightPlanes::new(&slopes), excess }
        };
        Quadratic(seen.iter().map(triangle).collect())
    }
}

#[derive(Clone, Copy)]
pub(super) struct Row<const C: usize> {
    light: Line<C>,
    weights: Weights,
    excess: [[f32; C]; 3],
}

impl<const C: usize> Rows<C> for Quadratic<C> {
    type Row = Row<C>;

    #[inline(always)]
    fn row(&self, triangle: u32, x: u32, y: u32) -> Row<C> {
        let triangle = &self.0[triangle as usize];
        Row { light: triangle.light.line(x, y), weights: triangle.weights.row(x, y), excess: triangle.excess }
    }

    #[inline(always)]
    fn light<S: Simd>(&self, row: &Row<C>, chunk: Chunk<S>) -> [Lanes<S>; C] {
        let mut light: [Lanes<S>; C] = row.light.along(chunk.steps);
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
