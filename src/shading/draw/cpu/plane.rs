//! Numbers that change by a constant from pixel to pixel and from row to row of a triangle.

use glam::DVec2;
use pulp::Simd;

use super::lanes::{Lanes, each};
use crate::shading::Frame;

/// `Q` such numbers of one triangle. Found anew for every row in f64, so that long thin triangles lose nothing; along
/// the row f32 is enough.
#[derive(Clone, Copy, Debug)]
pub(super) struct Planes<const Q: usize> {
    /// A corner, from the centre of the first pixel.
    x: f64,
    y: f64,
    /// The numbers there.
    at: [f64; Q],
    right: [f64; Q],
    down: [f64; Q],
    /// `right` in f32.
    step: [f32; Q],
}

/// The numbers along a row: at its first pixel, and the step to the next.
#[derive(Clone, Copy, Debug)]
pub(super) struct Line<const Q: usize> {
    pub at: [f32; Q],
    pub step: [f32; Q],
}

/// How the weights of the second and third corner change per pixel right and down.
#[derive(Clone, Copy, Debug)]
pub(super) struct Slopes {
    origin: DVec2,
    weights: [DVec2; 3],
}

impl Slopes {
    pub fn of(corners: [DVec2; 3]) -> Slopes {
        let [a, b, c] = corners;
        let per_area = 1.0 / Frame::area2(a, b, c);
        let slope = |from: DVec2, to: DVec2| DVec2::new(to.y - from.y, from.x - to.x) * per_area;
        Slopes { origin: a - 0.5, weights: [slope(b, c), slope(c, a), slope(a, b)] }
    }

    /// Those of triangle `t` of `frame`.
    pub fn of_triangle(frame: &Frame, t: u32) -> Slopes {
        Slopes::of(frame.corners(t as usize).map(|v| v.screen))
    }

    /// The planes through the corners' `values`.
    pub fn planes<const Q: usize>(&self, values: [[f64; Q]; 3]) -> Planes<Q> {
        let [a, b, c] = values;
        let [_, to_b, to_c] = self.weights;
        let mut planes = Planes { x: self.origin.x, y: self.origin.y, at: a, ..Planes::ZERO };
        for q in 0..Q {
            let slope = to_b * (b[q] - a[q]) + to_c * (c[q] - a[q]);
            planes.right[q] = slope.x;
            planes.down[q] = slope.y;
            planes.step[q] = slope.x as f32;
        }
        planes
    }
}

impl<const Q: usize> Planes<Q> {
    /// 0 everywhere.
    pub const ZERO: Self = Planes { x: 0.0, y: 0.0, at: [0.0; Q], right: [0.0; Q], down: [0.0; Q], step: [0.0; Q] };

    /// The numbers along `row` from the centre of pixel `x` on.
    #[inline(always)]
    pub fn line(&self, x: u32, row: u32) -> Line<Q> {
        let (x, y) = (f64::from(x) - self.x, f64::from(row) - self.y);
        let mut at = [0.0; Q];
        for (q, at) in at.iter_mut().enumerate() {
            *at = (self.at[q] + self.right[q] * x + self.down[q] * y) as f32;
        }
        Line { at, step: self.step }
    }
}

impl Planes<1> {
    /// The number at the centre of pixel `x` of `row`, and the step to the next pixel, with all that f64 holds.
    #[inline(always)]
    pub fn precise(&self, x: u32, row: u32) -> (f64, f64) {
        let (x, y) = (f64::from(x) - self.x, f64::from(row) - self.y);
        (self.at[0] + self.right[0] * x + self.down[0] * y, self.right[0])
    }
}

impl<const Q: usize> Line<Q> {
    /// The numbers `steps` pixels on.
    #[inline(always)]
    pub fn along<S: Simd>(&self, steps: Lanes<S>) -> [Lanes<S>; Q] {
        each(
            steps.simd(),
            #[inline(always)]
            |q| self.one(q, steps),
        )
    }

    /// The `q`-th of them.
    #[inline(always)]
    pub fn one<S: Simd>(&self, q: usize, steps: Lanes<S>) -> Lanes<S> {
        steps * self.step[q] + self.at[q]
    }
}
