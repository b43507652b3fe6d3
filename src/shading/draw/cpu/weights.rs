//! The weights of a triangle's corners, and its light, along a row.

use pulp::Simd;

use super::{
    band::Chunk,
    channels::Channels,
    lanes::{Lanes, each},
    plane::{Line, Planes, Slopes},
};
use crate::shading::Frame;

/// The three weights, then the light of up to Q − 3 channels: Q is 4 or 8, which suits vectors.
#[derive(Clone, Copy, Debug)]
pub(super) struct WeightPlanes<const Q: usize>(Planes<Q>);

/// The same along a row.
#[derive(Clone, Copy, Debug)]
pub(super) struct Weights<const Q: usize>(Line<Q>);

impl<const Q: usize> WeightPlanes<Q> {
    /// Those of triangle `t`, with its corners' lights.
    pub fn lit<const C: usize>(frame: &Frame, t: u32, channels: Channels) -> Self {
        let lights = frame.corners(t as usize).map(|v| channels.pick::<C>(v.light));
        WeightPlanes(Slopes::of_triangle(frame, t).planes([0, 1, 2].map(|k| {
            let mut values = [0.0; Q];
            values[k] = 1.0;
            values[3..3 + C].copy_from_slice(&lights[k]);
            values
        })))
    }

    /// Those of triangle `t` without light, the weight of corner `order[i]` in place i.
    pub fn ordered(frame: &Frame, t: u32, order: [usize; 3]) -> Self {
        WeightPlanes(Slopes::of_triangle(frame, t).planes([0, 1, 2].map(|k| {
            let mut values = [0.0; Q];
            for (value, of) in values.iter_mut().zip(order) {
                *value = if of == k { 1.0 } else { 0.0 };
            }
            values
        })))
    }

    /// Along row `y` from pixel `x` on.
    #[inline(always)]
    pub fn row(&self, x: u32, y: u32) -> Weights<Q> {
        Weights(self.0.line(x, y))
    }
}

impl<const Q: usize> Weights<Q> {
    /// The weights.
    #[inline(always)]
    pub fn along<S: Simd>(&self, chunk: &Chunk<S>) -> [Lanes<S>; 3] {
        [self.0.one(0, chunk.steps), self.0.one(1, chunk.steps), self.0.one(2, chunk.steps)]
    }

    /// The light.
    #[inline(always)]
    pub fn light<S: Simd, const C: usize>(&self, chunk: &Chunk<S>) -> [Lanes<S>; C] {
        each(
            chunk.steps.simd(),
            #[inline(always)]
            |c| self.0.one(3 + c, chunk.steps),
        )
    }

    /// The smallest and the largest that each weight is within the wanted part of `chunk`. Fourth comes something else.
    #[inline(always)]
    pub fn range<S: Simd>(&self, chunk: &Chunk<S>) -> ([f32; 4], [f32; 4]) {
        let (first, last) = (chunk.first as f32, (chunk.first + chunk.count - 1) as f32);
        let (mut low, mut high) = ([0.0; 4], [0.0; 4]);
        for k in 0..4 {
            let (a, b) = (self.0.at[k] + self.0.step[k] * first, self.0.at[k] + self.0.step[k] * last);
            low[k] = if a < b { a } else { b };
            high[k] = if a < b { b } else { a };
        }
        (low, high)
    }
}
