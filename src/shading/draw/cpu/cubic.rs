//! *patch*: the cubics of [`Patches`].

use glam::DVec3;
use pulp::Simd;

use super::{
    band::{Chunk, Rows},
    channels::Channels,
    lanes::{Lanes, each},
    outline::Heights,
    weights::{WeightPlanes, Weights},
};
use crate::shading::{Frame, Patches, boundary::others};

/// Three cubics a triangle, each where one weight is the smallest.
///
/// As polynomials of Y, 0 at the height of the top corner and 1 at that of the bottom one, and the middle corner's weight
/// w: in these two even the longest and thinnest triangle is well shaped. Y is constant along a row, so a row is three
/// cubics of w.
#[derive(Clone, Debug)]
pub(super) struct Cubics<const C: usize>(Vec<Triangle<C>>);

/// Four numbers for each of four parts, the fourth without meaning: a whole vector.
type Block = [f32; 16];

/// Where the coefficient of w^q of part `part` is.
const fn place(part: usize, q: usize) -> usize {
    4 * q + part
}

#[derive(Clone, Copy, Debug)]
struct Triangle<const C: usize> {
    /// Of the middle corner, the top one and the bottom one.
    weights: WeightPlanes<4>,
    /// The top's row, and 1/height.
    top: f64,
    per_height: f64,
    /// Of each channel, the coefficients of Y⁰…Y³, each of which has those of w⁰…w³ of each part, the parts in the
    /// order of the weights that are smallest there.
    terms: [[Block; 4]; C],
}

impl<const C: usize> Cubics<C> {
    pub fn new(frame: &Frame, seen: &[u32], channels: Channels, patches: &Patches) -> Self {
        Cubics(seen.iter().map(|t| triangle(frame, *t, channels, patches)).collect())
    }
}

fn triangle<const C: usize>(frame: &Frame, t: u32, channels: Channels, patches: &Patches) -> Triangle<C> {
    let corners = frame.corners(t as usize).map(|v| v.screen);
    let Heights { top, middle, bottom } = Heights::of(corners);
    let per_height = 1.0 / (corners[bottom].y - corners[top].y);
    let down = (corners[middle].y - corners[top].y) * per_height;
    // Weights at Y = w = 0, and their change with Y and with w.
    let (mut origin, mut along_y, mut along_w) = ([0.0; 3], [0.0; 3], [0.0; 3]);
    origin[top] = 1.0;
    (along_y[top], along_y[bottom]) = (-1.0, 1.0);
    (along_w[middle], along_w[bottom], along_w[top]) = (1.0, -down, down - 1.0);
    let mut terms = [[[0.0; 16]; 4]; C];
    let order = [middle, top, bottom];
    for (part, k) in order.into_iter().enumerate() {
        let (i, j) = others(k);
        let local = |w: [f64; 3]| [w[i] - w[k], w[j] - w[k], 3.0 * w[k]];
        let (origin, along_y, along_w) = (local(origin), local(along_y), local(along_w));
        let cubic = patches.cubic(t as usize, k);
        for p in 0..4 {
            for q in 0..4 - p {
                let term = coefficient(&cubic, (p, along_y), (q, along_w), origin);
                for (terms, term) in terms.iter_mut().zip(channels.pick::<C>(term)) {
                    terms[p][place(part, q)] = term as f32;
                }
            }
        }
    }
    let weights = WeightPlanes::ordered(frame, t, order);
    Triangle { weights, top: corners[top].y - 0.5, per_height, terms }
}

/// The coefficient of Y^p·w^q of the cubic with the Bézier ordinates `b`, given the local weights (u, v, s) at the
/// origin and their change with Y and w: 3!/(p!·q!·r!) times its multilinear form at p times Y, q times w and the rest
/// the origin.
fn coefficient(
    b: &[DVec3; 10],
    (p, along_y): (usize, [f64; 3]),
    (q, along_w): (usize, [f64; 3]),
    origin: [f64; 3],
) -> DVec3 {
    let mut at = [origin; 3];
    at[..p].fill(along_y);
    at[p..p + q].fill(along_w);
    let factorial = [1.0, 1.0, 2.0, 6.0];
    blossom(b, at[0], at[1], at[2]) * (6.0 / (factorial[p] * factorial[q] * factorial[3 - p - q]))
}

/// The multilinear form of the cubic with ordinates as in [`Patches::cubic`].
fn blossom(b: &[DVec3; 10], x: [f64; 3], y: [f64; 3], z: [f64; 3]) -> DVec3 {
    let mix = |w: [f64; 3], p: DVec3, q: DVec3, r: DVec3| p * w[0] + q * w[1] + r * w[2];
    let uu = mix(x, b[0], b[1], b[4]);
    let uv = mix(x, b[1], b[2], b[5]);
    let vv = mix(x, b[2], b[3], b[6]);
    let us = mix(x, b[4], b[5], b[7]);
    let vs = mix(x, b[5], b[6], b[8]);
    let ss = mix(x, b[7], b[8], b[9]);
    mix(z, mix(y, uu, uv, us), mix(y, uv, vv, vs), mix(y, us, vs, ss))
}

#[derive(Clone, Copy)]
pub(super) struct Row<const C: usize> {
    weights: Weights<4>,
    /// Coefficients of w⁰…w³ of each part.
    terms: [Block; C],
}

impl<const C: usize> Rows<C> for Cubics<C> {
    type Row = Row<C>;

    #[inline(always)]
    fn row<S: Simd>(&self, simd: S, triangle: u32, x: u32, y: u32) -> Row<C> {
        let triangle = &self.0[triangle as usize];
        let height = Lanes::splat(simd, ((f64::from(y) - triangle.top) * triangle.per_height) as f32);
        let mut terms = [[0.0; 16]; C];
        for (row, [a, b, c, d]) in terms.iter_mut().zip(&triangle.terms) {
            for at in (0..16).step_by(S::F32_LANES) {
                let load = |of: &Block| Lanes::load(simd, &of[at..]);
                let sum = ((load(d) * height + load(c)) * height + load(b)) * height + load(a);
                sum.store(&mut row[at..]);
            }
        }
        Row { weights: triangle.weights.row(x, y), terms }
    }

    #[inline(always)]
    fn light<S: Simd>(&self, row: &Row<C>, chunk: Chunk<S>) -> [Lanes<S>; C] {
        let w = row.weights.along(&chunk);
        let middle = w[0];
        let second = w[1].below(w[0]);
        let third = w[2].below(second.select(w[1], w[0]));
        each(
            chunk.steps.simd(),
            #[inline(always)]
            |c| {
                let second = second.select(cubic::<S, C, 1>(row, c, middle), cubic::<S, C, 0>(row, c, middle));
                third.select(cubic::<S, C, 2>(row, c, middle), second)
            },
        )
    }
}

/// Channel `c` of part `K` at the weights `w` of the middle corner.
#[inline(always)]
fn cubic<S: Simd, const C: usize, const K: usize>(row: &Row<C>, c: usize, w: Lanes<S>) -> Lanes<S> {
    let terms = &row.terms[c];
    let [a, b, c, d] = [terms[place(K, 0)], terms[place(K, 1)], terms[place(K, 2)], terms[place(K, 3)]];
    ((w * d + c) * w + b) * w + a
}
