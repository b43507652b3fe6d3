//! *patch*: the cubics of [`Patches`].

use glam::DVec3;
use pulp::Simd;

use super::{
    band::{Chunk, Rows},
    channels::Channels,
    lanes::{Lanes, each},
    outline::Heights,
    plane::Slopes,
    strips::{WeightPlanes, Weights},
};
use crate::shading::{Frame, Patches, boundary::others};

/// Three cubics a triangle, each where one weight is the smallest.
///
/// As polynomials of Y, 0 at the height of the top corner and 1 at that of the bottom one, and the middle corner's weight
/// w: in these two even the longest and thinnest triangle is well shaped. Y is constant along a row, so a row is three
/// cubics of w.
#[derive(Clone, Debug)]
pub(super) struct Cubics<const C: usize>(Vec<Triangle<C>>);

/// Terms of a cubic of two variables.
const TERMS: usize = 10;

/// Exponents of Y and w: the terms in w⁰, w¹, w² and w³, each in rising powers of Y.
const POWERS: [(usize, usize); TERMS] =
    [(0, 0), (1, 0), (2, 0), (3, 0), (0, 1), (1, 1), (2, 1), (0, 2), (1, 2), (0, 3)];

#[derive(Clone, Copy, Debug)]
struct Triangle<const C: usize> {
    /// Of the middle corner, the top one and the bottom one.
    weights: WeightPlanes,
    /// The top's row, and 1/height.
    top: f64,
    per_height: f64,
    /// Terms of each channel of each part, the parts in the order of the weights that are smallest there. A fourth part of zeros fills a vector.
    terms: [[[f32; 4]; C]; TERMS],
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
    let mut terms = [[[0.0; 4]; C]; TERMS];
    let order = [middle, top, bottom];
    for (part, k) in order.into_iter().enumerate() {
        let (i, j) = others(k);
        let local = |w: [f64; 3]| [w[i] - w[k], w[j] - w[k], 3.0 * w[k]];
        let polynomial = polynomial(&patches.cubic(t as usize, k), local(origin), local(along_y), local(along_w));
        for (terms, coefficient) in terms.iter_mut().zip(polynomial) {
            for (channel, term) in terms.iter_mut().zip(channels.pick::<C>(coefficient)) {
                channel[part] = term as f32;
            }
        }
    }
    let weights = WeightPlanes::ordered(&Slopes::of_triangle(frame, t), order);
    Triangle { weights, top: corners[top].y - 0.5, per_height, terms }
}

/// The cubic with the Bézier ordinates `b` in powers of Y and w, given the local weights (u, v, s) at the origin and
/// their change with Y and w. Its blossom B is multilinear: the coefficient of Y^p·w^q is 3!/(p!q!r!)·B(Y^p, w^q, o^r).
fn polynomial(b: &[DVec3; 10], origin: [f64; 3], along_y: [f64; 3], along_w: [f64; 3]) -> [DVec3; TERMS] {
    POWERS.map(|(p, q)| {
        let direction = |n: usize| {
            if n < p {
                along_y
            } else if n < p + q {
                along_w
            } else {
                origin
            }
        };
        let factorial = |n: usize| [1.0, 1.0, 2.0, 6.0][n];
        let count = 6.0 / (factorial(p) * factorial(q) * factorial(3 - p - q));
        blossom(b, direction(0), direction(1), direction(2)) * count
    })
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
    weights: Weights,
    /// Coefficients of w⁰…w³ of each channel of each part.
    terms: [[[f32; 4]; C]; 4],
}

impl<const C: usize> Rows<C> for Cubics<C> {
    type Row = Row<C>;

    #[inline(always)]
    fn row(&self, triangle: u32, x: u32, y: u32) -> Row<C> {
        let triangle = &self.0[triangle as usize];
        let height = ((f64::from(y) - triangle.top) * triangle.per_height) as f32;
        let t = &triangle.terms;
        let mut terms = [[[0.0; 4]; C]; 4];
        for c in 0..C {
            for k in 0..4 {
                terms[0][c][k] = ((t[3][c][k] * height + t[2][c][k]) * height + t[1][c][k]) * height + t[0][c][k];
                terms[1][c][k] = (t[6][c][k] * height + t[5][c][k]) * height + t[4][c][k];
                terms[2][c][k] = t[8][c][k] * height + t[7][c][k];
                terms[3][c][k] = t[9][c][k];
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
    let [a, b, c, d] = [row.terms[0][c][K], row.terms[1][c][K], row.terms[2][c][K], row.terms[3][c][K]];
    ((w * d + c) * w + b) * w + a
}
