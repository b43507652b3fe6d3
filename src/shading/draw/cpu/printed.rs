//! Bangay's boundary shaders as printed, and the one with its sign repaired. §4.1, §4.2.

use pulp::Simd;

use super::{
    band::{Chunk, Rows},
    channels::Channels,
    curve::Step,
    lanes::{Lanes, each},
    weights::{WeightPlanes, Weights},
};
use crate::{
    light::Depth,
    shading::{Across, Frame, boundary::others, shaders::gradient::Sign},
};

/// *fixed*, and with a sign *gradient*; see [`shaders`](crate::shading::shaders).
#[derive(Clone, Debug)]
pub(super) struct Printed<const C: usize, const Q: usize> {
    triangles: Vec<Triangle<C, Q>>,
    sign: Option<Sign>,
    strip: f32,
    step: Step,
}

#[derive(Clone, Copy, Debug)]
struct Triangle<const C: usize, const Q: usize> {
    weights: WeightPlanes<Q>,
    corners: Corners<C>,
}

/// The lights that a triangle knows.
#[derive(Clone, Copy, Debug)]
struct Corners<const C: usize> {
    own: [[f32; C]; 3],
    /// Those of the neighbours' vertices across each edge.
    apexes: [Option<[f32; C]>; 3],
}

impl<const C: usize, const Q: usize> Printed<C, Q> {
    pub fn new(frame: &Frame, seen: &[u32], channels: Channels, sign: Option<Sign>, b: f64, depth: Depth) -> Self {
        let triangle = |t: &u32| {
            let apexes = frame.triangles[*t as usize].across.map(|across| match across {
                Across::Triangle { apex, .. } if sign.is_some() => {
                    Some(channels.pick_f32(frame.vertices[apex as usize].light))
                }
                _ => None,
            });
            let own = frame.corners(*t as usize).map(|v| channels.pick_f32(v.light));
            Triangle { weights: WeightPlanes::lit::<C>(frame, *t, channels), corners: Corners { own, apexes } }
        };
        Printed { triangles: seen.iter().map(triangle).collect(), sign, strip: b as f32, step: Step::new(depth) }
    }

    /// The light in the strip opposite corner `k`.
    #[inline(always)]
    fn in_strip<S: Simd>(&self, k: usize, w: &[Lanes<S>; 3], corners: &Corners<C>) -> [Lanes<S>; C] {
        let (i, j) = others(k);
        let (t, one) = (w[k], w[k].all(1.0));
        let width = t.all(self.strip).min((one - w[i]) * 0.5).min((one - w[j]) * 0.5);
        let across = t / width.max(t.all(1e-30));
        let rise = t * self.step.value(across);
        let per_rest = one / (one - t);
        let own = &corners.own;
        let on_edge: [Lanes<S>; C] = each(
            t.simd(),
            #[inline(always)]
            |c| (w[i] * own[i][c] + w[j] * own[j][c]) * per_rest,
        );
        let mut light = on_edge;
        for c in 0..C {
            light[c] = on_edge[c] + (t.all(own[k][c]) - on_edge[c]) * rise;
        }
        let (Some(apex), Some(sign)) = (&corners.apexes[k], self.sign) else { return light };
        // Bangay eqs. 5 and 6: from the nearer corner of the edge toward the neighbour's apex.
        let a = w[i] * 2.0 / (w[i] + w[j]) - 1.0;
        let nearer_j = a.below(a.all(0.0));
        let size = a.max(a.all(0.0) - a);
        let f = size * 2.0 / (size + 1.0);
        let fall = t * self.step.value(one - across) * 0.5;
        for c in 0..C {
            let near = nearer_j.select(t.all(own[j][c]), t.all(own[i][c]));
            let beyond = near * f + (one - f) * apex[c];
            let slope = match sign {
                Sign::Printed => beyond - on_edge[c],
                Sign::Repaired => t.all(own[k][c]) - beyond,
            };
            light[c] = light[c] + slope * fall;
        }
        light
    }
}

#[derive(Clone, Copy)]
pub(super) struct Row<const C: usize, const Q: usize> {
    weights: Weights<Q>,
    corners: Corners<C>,
}

impl<const C: usize, const Q: usize> Rows<C> for Printed<C, Q> {
    type Row = Row<C, Q>;

    #[inline(always)]
    fn row<S: Simd>(&self, _: S, triangle: u32, x: u32, y: u32) -> Row<C, Q> {
        let triangle = &self.triangles[triangle as usize];
        Row { weights: triangle.weights.row(x, y), corners: triangle.corners }
    }

    #[inline(always)]
    fn light<S: Simd>(&self, row: &Row<C, Q>, chunk: Chunk<S>) -> [Lanes<S>; C] {
        let plain: [Lanes<S>; C] = row.weights.light(&chunk);
        let (low, _) = row.weights.range(&chunk);
        let w = row.weights.along(&chunk);
        let mut strips = [plain; 3];
        for k in 0..3 {
            if low[k] < self.strip {
                strips[k] = self.in_strip(k, &w, &row.corners);
            }
        }
        // The smallest weight, the first of equal ones.
        let second = w[1].below(w[0]);
        let smaller = second.select(w[1], w[0]);
        let third = w[2].below(smaller);
        let inside = third.select(w[2], smaller).below(w[0].all(self.strip));
        each(
            chunk.steps.simd(),
            #[inline(always)]
            |c| {
                let strip = third.select(strips[2][c], second.select(strips[1][c], strips[0][c]));
                inside.select(strip, plain[c])
            },
        )
    }
}
