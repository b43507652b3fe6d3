//! Flat and Gouraud shading: light that changes by a constant from pixel to pixel. Bangay eq. 2.

use pulp::Simd;

use super::{
    band::{Chunk, Rows},
    lanes::{Lanes, each},
    plane::{Line, Planes},
};

/// One light a triangle.
#[derive(Clone, Debug)]
pub(super) struct Flat<const C: usize>(pub Vec<[f32; C]>);

impl<const C: usize> Rows<C> for Flat<C> {
    type Row = [f32; C];

    #[inline(always)]
    fn row<S: Simd>(&self, _: S, triangle: u32, _: u32, _: u32) -> [f32; C] {
        self.0[triangle as usize]
    }

    #[inline(always)]
    fn light<S: Simd>(&self, row: &[f32; C], chunk: Chunk<S>) -> [Lanes<S>; C] {
        each(
            chunk.steps.simd(),
            #[inline(always)]
            |c| chunk.steps.all(row[c]),
        )
    }
}

/// Light interpolated between the vertices.
#[derive(Clone, Debug)]
pub(super) struct Gouraud<const C: usize>(pub Vec<Planes<C>>);

impl<const C: usize> Rows<C> for Gouraud<C> {
    type Row = Line<C>;

    #[inline(always)]
    fn row<S: Simd>(&self, _: S, triangle: u32, x: u32, y: u32) -> Line<C> {
        self.0[triangle as usize].line(x, y)
    }

    #[inline(always)]
    fn light<S: Simd>(&self, row: &Line<C>, chunk: Chunk<S>) -> [Lanes<S>; C] {
        row.along(chunk.steps)
    }
}
