//! Whatever has no fast way: the reference, pixel by pixel, over threads at least.

use glam::DVec2;
use pulp::Simd;

use super::{
    band::{Chunk, Rows},
    lanes::{Lanes, MOST_LANES, each},
};
use crate::shading::{Frame, Reference};

/// Any shader with any correction, in f64.
#[derive(Clone, Debug)]
pub(super) struct Pixels<'f> {
    pub frame: &'f Frame,
    pub reference: Reference<'f>,
    /// Which of the frame's triangles.
    pub seen: Vec<u32>,
}

/// A place: the triangle, and its first pixel.
#[derive(Clone, Copy)]
pub(super) struct Row {
    triangle: usize,
    x: u32,
    y: u32,
}

impl Rows<3> for Pixels<'_> {
    type Row = Row;

    #[inline(always)]
    fn row<S: Simd>(&self, _: S, triangle: u32, x: u32, y: u32) -> Row {
        Row { triangle: self.seen[triangle as usize] as usize, x, y }
    }

    #[inline(always)]
    fn light<S: Simd>(&self, row: &Row, chunk: Chunk<S>) -> [Lanes<S>; 3] {
        let light = self.lights(row, chunk.first, chunk.count);
        each(
            chunk.steps.simd(),
            #[inline(always)]
            |c| Lanes::load(chunk.steps.simd(), &light[c]),
        )
    }
}

impl Pixels<'_> {
    fn lights(&self, row: &Row, first: u32, count: u32) -> [[f32; MOST_LANES]; 3] {
        let mut lights = [[0.0; MOST_LANES]; 3];
        for i in 0..count {
            let centre = DVec2::new(f64::from(row.x + first + i) + 0.5, f64::from(row.y) + 0.5);
            let light = self.reference.light(row.triangle, self.frame.weights(row.triangle, centre)).as_vec3();
            for (lights, light) in lights.iter_mut().zip(light.to_array()) {
                lights[i as usize] = light;
            }
        }
        lights
    }
}
