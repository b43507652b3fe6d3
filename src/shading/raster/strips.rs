//! *exact* and *cut*: Gouraud's light, and a correction in the strips along the edges.

use pulp::Simd;

use super::{
    band::{Chunk, Rows},
    channels::Channels,
    curve::Curve,
    lanes::{Lanes, add},
    plane::{Line, Planes, Slopes},
};
use crate::{
    light::Depth,
    shading::{
        Frame,
        boundary::{EdgeConstants, others},
    },
};

/// Stands for the width of a strip that has none.
const NARROWEST: f32 = 1e-30;

/// Weights by which a chunk is taken to be outside a strip. Whether it is must not change what comes out, as the size of
/// a chunk differs between machines: rounding must not reach from here into the strip.
const MARGIN: f32 = 1e-4;

/// The weights of a triangle's corners along a row.
#[derive(Clone, Copy)]
pub(super) struct Weights(Line<3>);

impl Weights {
    #[inline(always)]
    pub fn along<S: Simd>(&self, chunk: &Chunk<S>) -> [Lanes<S>; 3] {
        [self.0.one(0, chunk.steps), self.0.one(1, chunk.steps), self.0.one(2, chunk.steps)]
    }

    /// The smallest and the largest that each weight is within the wanted part of `chunk`.
    #[inline(always)]
    pub fn range<S: Simd>(&self, chunk: &Chunk<S>) -> ([f32; 3], [f32; 3]) {
        let (first, last) = (chunk.first as f32, (chunk.first + chunk.count - 1) as f32);
        let (mut low, mut high) = ([0.0; 3], [0.0; 3]);
        for k in 0..3 {
            let (a, b) = (self.0.at[k] + self.0.step[k] * first, self.0.at[k] + self.0.step[k] * last);
            low[k] = if a < b { a } else { b };
            high[k] = if a < b { b } else { a };
        }
        (low, high)
    }
}

/// The planes of a triangle's weights.
#[derive(Clone, Copy, Debug)]
pub(super) struct WeightPlanes(Planes<3>);

impl WeightPlanes {
    pub fn new(slopes: &Slopes) -> WeightPlanes {
        WeightPlanes::ordered(slopes, [0, 1, 2])
    }

    /// With the weight of corner `order[i]` in place i.
    pub fn ordered(slopes: &Slopes, order: [usize; 3]) -> WeightPlanes {
        WeightPlanes(slopes.planes([0, 1, 2].map(|k| order.map(|of| if of == k { 1.0 } else { 0.0 }))))
    }

    #[inline(always)]
    pub fn row(&self, x: u32, y: u32) -> Weights {
        Weights(self.0.line(x, y))
    }
}

/// φ, [`boundary::ease`](crate::shading::boundary::ease).
#[inline(always)]
fn ease<S: Simd>(x: Lanes<S>) -> Lanes<S> {
    let x = x.max(x.all(0.0)).min(x.all(2.0));
    x - x * x * 0.25
}

/// L + Σ_k c_k·w_k·(1 − I_n(w_k/b'_k)); see [`shaders::exact`](crate::shading::shaders::exact).
#[derive(Clone, Debug)]
pub(super) struct Exact<const C: usize> {
    triangles: Vec<ExactTriangle<C>>,
    strip: f32,
    per_strip: f32,
    curve: Curve,
}

#[derive(Clone, Copy, Debug)]
struct ExactTriangle<const C: usize> {
    light: Planes<C>,
    weights: WeightPlanes,
    c: [[f32; C]; 3],
}

impl<const C: usize> Exact<C> {
    pub fn new(
        frame: &Frame,
        seen: &[u32],
        channels: Channels,
        edges: &[[EdgeConstants; 3]],
        b: f64,
        depth: Depth,
    ) -> Self {
        let triangle = |t: &u32| {
            let slopes = Slopes::of_triangle(frame, *t);
            ExactTriangle {
                light: channels.planes(&slopes, frame, *t),
                weights: WeightPlanes::new(&slopes),
                c: edges[*t as usize].map(|edge| channels.pick_f32(edge.c)),
            }
        };
        let triangles = seen.iter().map(triangle).collect();
        Exact { triangles, strip: b as f32, per_strip: (1.0 / b) as f32, curve: Curve::blend(depth) }
    }
}

#[derive(Clone, Copy)]
pub(super) struct ExactRow<const C: usize> {
    light: Line<C>,
    weights: Weights,
    c: [[f32; C]; 3],
}

impl<const C: usize> Rows<C> for Exact<C> {
    type Row = ExactRow<C>;

    #[inline(always)]
    fn row(&self, triangle: u32, x: u32, y: u32) -> ExactRow<C> {
        let triangle = &self.triangles[triangle as usize];
        ExactRow { light: triangle.light.line(x, y), weights: triangle.weights.row(x, y), c: triangle.c }
    }

    #[inline(always)]
    fn light<S: Simd>(&self, row: &ExactRow<C>, chunk: Chunk<S>) -> [Lanes<S>; C] {
        let light: [Lanes<S>; C] = row.light.along(chunk.steps);
        let (low, high) = row.weights.range(&chunk);
        let outside = self.strip * (1.0 + MARGIN);
        let near = [low[0] < outside, low[1] < outside, low[2] < outside];
        if !(near[0] | near[1] | near[2]) {
            return light;
        }
        let w = row.weights.along(&chunk);
        let corner = 1.0 - 4.0 * self.strip - MARGIN;
        let one = chunk.steps.all(1.0);
        let mut eased = [one; 3];
        if (high[0] > corner) | (high[1] > corner) | (high[2] > corner) {
            let per_strip = 0.5 * self.per_strip;
            eased = [ease((one - w[0]) * per_strip), ease((one - w[1]) * per_strip), ease((one - w[2]) * per_strip)];
        }
        let light = if near[0] { self.bent::<S, 0>(light, row, &w, &eased) } else { light };
        let light = if near[1] { self.bent::<S, 1>(light, row, &w, &eased) } else { light };
        if near[2] { self.bent::<S, 2>(light, row, &w, &eased) } else { light }
    }
}

impl<const C: usize> Exact<C> {
    /// `light` with strip `K`.
    #[inline(always)]
    fn bent<S: Simd, const K: usize>(
        &self,
        light: [Lanes<S>; C],
        row: &ExactRow<C>,
        w: &[Lanes<S>; 3],
        eased: &[Lanes<S>; 3],
    ) -> [Lanes<S>; C] {
        let (i, j) = others(K);
        let (zero, one) = (w[K].all(0.0), w[K].all(1.0));
        let u = w[K] * self.per_strip / (eased[i] * eased[j]).max(one.all(NARROWEST));
        let bump = w[K] * self.curve.value((one - u).max(zero).min(one));
        add(
            light,
            #[inline(always)]
            |c| bump * row.c[K][c],
        )
    }
}

/// L − Σ_k c_k·b'_k·Ψ_n(w_k/b'_k); see [`shaders::cut`](crate::shading::shaders::cut).
#[derive(Clone, Debug)]
pub(super) struct Cut<const C: usize> {
    triangles: Vec<CutTriangle<C>>,
    strip: f32,
    curve: Curve,
}

#[derive(Clone, Copy, Debug)]
struct CutTriangle<const C: usize> {
    light: Planes<C>,
    weights: WeightPlanes,
    c: [[f32; C]; 3],
    /// 1/(b·m) at either end of each edge.
    reach: [[f32; 2]; 3],
    foot: [f32; 3],
}

impl<const C: usize> Cut<C> {
    pub fn new(
        frame: &Frame,
        seen: &[u32],
        channels: Channels,
        edges: &[[EdgeConstants; 3]],
        b: f64,
        depth: Depth,
    ) -> Self {
        let b = b.min(1.0);
        let triangle = |t: &u32| {
            let slopes = Slopes::of_triangle(frame, *t);
            let edges = &edges[*t as usize];
            CutTriangle {
                light: channels.planes(&slopes, frame, *t),
                weights: WeightPlanes::new(&slopes),
                c: edges.map(|edge| channels.pick_f32(edge.c)),
                reach: edges.map(|edge| [edge.start, edge.end].map(|m| (1.0 / (b * m)) as f32)),
                foot: edges.map(|edge| edge.foot as f32),
            }
        };
        Cut { triangles: seen.iter().map(triangle).collect(), strip: b as f32, curve: Curve::rest(depth) }
    }
}

#[derive(Clone, Copy)]
pub(super) struct CutRow<const C: usize> {
    light: Line<C>,
    weights: Weights,
    c: [[f32; C]; 3],
    reach: [[f32; 2]; 3],
    foot: [f32; 3],
}

impl<const C: usize> Rows<C> for Cut<C> {
    type Row = CutRow<C>;

    #[inline(always)]
    fn row(&self, triangle: u32, x: u32, y: u32) -> CutRow<C> {
        let triangle = &self.triangles[triangle as usize];
        CutRow {
            light: triangle.light.line(x, y),
            weights: triangle.weights.row(x, y),
            c: triangle.c,
            reach: triangle.reach,
            foot: triangle.foot,
        }
    }

    #[inline(always)]
    fn light<S: Simd>(&self, row: &CutRow<C>, chunk: Chunk<S>) -> [Lanes<S>; C] {
        let light: [Lanes<S>; C] = row.light.along(chunk.steps);
        let w = row.weights.along(&chunk);
        let (low, _) = row.weights.range(&chunk);
        let outside = self.strip * (1.0 + MARGIN);
        let light = if low[0] < outside { self.bent::<S, 0>(light, row, &w) } else { light };
        let light = if low[1] < outside { self.bent::<S, 1>(light, row, &w) } else { light };
        if low[2] < outside { self.bent::<S, 2>(light, row, &w) } else { light }
    }
}

impl<const C: usize> Cut<C> {
    /// `light` with the corner at edge `K` cut.
    #[inline(always)]
    fn bent<S: Simd, const K: usize>(&self, light: [Lanes<S>; C], row: &CutRow<C>, w: &[Lanes<S>; 3]) -> [Lanes<S>; C] {
        let (i, j) = others(K);
        let from_start = w[j] + w[K] * row.foot[K];
        let from_end = w[i] + w[K] * (1.0 - row.foot[K]);
        let width = ease(from_start * row.reach[K][0]) * ease(from_end * row.reach[K][1]) * self.strip;
        let u = w[K] / width.max(width.all(NARROWEST));
        let corner = width * self.curve.value((u.all(1.0) - u).max(u.all(0.0)).min(u.all(1.0)));
        add(
            light,
            #[inline(always)]
            |c| corner * -row.c[K][c],
        )
    }
}
