//! *exact* and *cut*: Gouraud's light, and a correction in the strips along the edges.

use pulp::Simd;

use super::{
    band::{Chunk, Rows},
    channels::Channels,
    curve::Curve,
    lanes::{Lanes, add},
    weights::{WeightPlanes, Weights},
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

/// φ, [`boundary::ease`](crate::shading::boundary::ease).
#[inline(always)]
fn ease<S: Simd>(x: Lanes<S>) -> Lanes<S> {
    let x = x.max(x.all(0.0)).min(x.all(2.0));
    x - x * x * 0.25
}

/// L + Σ_k c_k·w_k·(1 − I_n(w_k/b'_k)); see [`shaders::exact`](crate::shading::shaders::exact).
#[derive(Clone, Debug)]
pub(super) struct Exact<const C: usize, const Q: usize> {
    triangles: Vec<ExactTriangle<C, Q>>,
    strip: f32,
    per_strip: f32,
    curve: Curve,
}

#[derive(Clone, Copy, Debug)]
struct ExactTriangle<const C: usize, const Q: usize> {
    weights: WeightPlanes<Q>,
    c: [[f32; C]; 3],
}

impl<const C: usize, const Q: usize> Exact<C, Q> {
    pub fn new(
        frame: &Frame,
        seen: &[u32],
        channels: Channels,
        edges: &[[EdgeConstants; 3]],
        b: f64,
        depth: Depth,
    ) -> Self {
        let triangle = |t: &u32| ExactTriangle {
            weights: WeightPlanes::lit::<C>(frame, *t, channels),
            c: edges[*t as usize].map(|edge| channels.pick_f32(edge.c)),
        };
        let triangles = seen.iter().map(triangle).collect();
        Exact { triangles, strip: b as f32, per_strip: (1.0 / b) as f32, curve: Curve::blend(depth) }
    }
}

#[derive(Clone, Copy)]
pub(super) struct ExactRow<const Q: usize> {
    weights: Weights<Q>,
    triangle: u32,
}

impl<const C: usize, const Q: usize> Rows<C> for Exact<C, Q> {
    type Row = ExactRow<Q>;

    #[inline(always)]
    fn row<S: Simd>(&self, _: S, triangle: u32, x: u32, y: u32) -> ExactRow<Q> {
        ExactRow { weights: self.triangles[triangle as usize].weights.row(x, y), triangle }
    }

    #[inline(always)]
    fn light<S: Simd>(&self, row: &ExactRow<Q>, chunk: Chunk<S>) -> [Lanes<S>; C] {
        let light: [Lanes<S>; C] = row.weights.light(&chunk);
        let w = row.weights.along(&chunk);
        let outside = w[0].all(self.strip * (1.0 + MARGIN));
        let near = [
            w[0].below(outside).any(chunk.wanted),
            w[1].below(outside).any(chunk.wanted),
            w[2].below(outside).any(chunk.wanted),
        ];
        if !(near[0] | near[1] | near[2]) {
            return light;
        }
        let corner = w[0].all(1.0 - 4.0 * self.strip - MARGIN);
        if corner.below(w[0].max(w[1]).max(w[2])).any(chunk.wanted) {
            let eased = [self.eased(w[0]), self.eased(w[1]), self.eased(w[2])];
            let light = if near[0] { self.bent::<S, 0>(light, row, w[0], Some(eased[1] * eased[2])) } else { light };
            let light = if near[1] { self.bent::<S, 1>(light, row, w[1], Some(eased[2] * eased[0])) } else { light };
            if near[2] { self.bent::<S, 2>(light, row, w[2], Some(eased[0] * eased[1])) } else { light }
        } else {
            let light = if near[0] { self.bent::<S, 0>(light, row, w[0], None) } else { light };
            let light = if near[1] { self.bent::<S, 1>(light, row, w[1], None) } else { light };
            if near[2] { self.bent::<S, 2>(light, row, w[2], None) } else { light }
        }
    }
}

impl<const C: usize, const Q: usize> Exact<C, Q> {
    /// By how much a corner of weight `w` narrows the strips of the edges that meet in it.
    #[inline(always)]
    fn eased<S: Simd>(&self, w: Lanes<S>) -> Lanes<S> {
        ease((w.all(1.0) - w) * (0.5 * self.per_strip))
    }

    /// `light` with strip `K`, where its weight is `w`, `narrowed` by corners nearby. Far from them nothing is divided,
    /// with the same result as by 1.
    #[inline(always)]
    fn bent<S: Simd, const K: usize>(
        &self,
        light: [Lanes<S>; C],
        row: &ExactRow<Q>,
        w: Lanes<S>,
        narrowed: Option<Lanes<S>>,
    ) -> [Lanes<S>; C] {
        let (zero, one) = (w.all(0.0), w.all(1.0));
        let mut u = w * self.per_strip;
        if let Some(narrowed) = narrowed {
            u = u / narrowed.max(w.all(NARROWEST));
        }
        let bump = w * self.curve.value((one - u).max(zero).min(one));
        let size = &self.triangles[row.triangle as usize].c[K];
        add(
            light,
            #[inline(always)]
            |c| bump * size[c],
        )
    }
}

/// L − Σ_k c_k·b'_k·Ψ_n(w_k/b'_k); see [`shaders::cut`](crate::shading::shaders::cut).
#[derive(Clone, Debug)]
pub(super) struct Cut<const C: usize, const Q: usize> {
    triangles: Vec<CutTriangle<C, Q>>,
    strip: f32,
    curve: Curve,
}

#[derive(Clone, Copy, Debug)]
struct CutTriangle<const C: usize, const Q: usize> {
    weights: WeightPlanes<Q>,
    c: [[f32; C]; 3],
    /// 1/(b·m) at either end of each edge.
    reach: [[f32; 2]; 3],
    foot: [f32; 3],
}

impl<const C: usize, const Q: usize> Cut<C, Q> {
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
            let edges = &edges[*t as usize];
            CutTriangle {
                weights: WeightPlanes::lit::<C>(frame, *t, channels),
                c: edges.map(|edge| channels.pick_f32(edge.c)),
                reach: edges.map(|edge| [edge.start, edge.end].map(|m| (1.0 / (b * m)) as f32)),
                foot: edges.map(|edge| edge.foot as f32),
            }
        };
        Cut { triangles: seen.iter().map(triangle).collect(), strip: b as f32, curve: Curve::rest(depth) }
    }
}

#[derive(Clone, Copy)]
pub(super) struct CutRow<const C: usize, const Q: usize> {
    weights: Weights<Q>,
    c: [[f32; C]; 3],
    reach: [[f32; 2]; 3],
    foot: [f32; 3],
}

impl<const C: usize, const Q: usize> Rows<C> for Cut<C, Q> {
    type Row = CutRow<C, Q>;

    #[inline(always)]
    fn row<S: Simd>(&self, _: S, triangle: u32, x: u32, y: u32) -> CutRow<C, Q> {
        let triangle = &self.triangles[triangle as usize];
        CutRow { weights: triangle.weights.row(x, y), c: triangle.c, reach: triangle.reach, foot: triangle.foot }
    }

    #[inline(always)]
    fn light<S: Simd>(&self, row: &CutRow<C, Q>, chunk: Chunk<S>) -> [Lanes<S>; C] {
        let light: [Lanes<S>; C] = row.weights.light(&chunk);
        let w = row.weights.along(&chunk);
        let outside = w[0].all(self.strip * (1.0 + MARGIN));
        let near = |w: Lanes<S>| w.below(outside).any(chunk.wanted);
        let light = if near(w[0]) { self.bent::<S, 0>(light, row, &w) } else { light };
        let light = if near(w[1]) { self.bent::<S, 1>(light, row, &w) } else { light };
        if near(w[2]) { self.bent::<S, 2>(light, row, &w) } else { light }
    }
}

impl<const C: usize, const Q: usize> Cut<C, Q> {
    /// `light` with the corner at edge `K` cut.
    #[inline(always)]
    fn bent<S: Simd, const K: usize>(
        &self,
        light: [Lanes<S>; C],
        row: &CutRow<C, Q>,
        w: &[Lanes<S>; 3],
    ) -> [Lanes<S>; C] {
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
