//! Numbers that change by a constant from pixel to pixel and from row to row of a triangle.

use super::projected::Frame;
use glam::DVec2;

/// `Q` such numbers of one triangle. Found anew for every row in f64, so that long thin triangles lose nothing; along
/// the row f32 is enough.
#[derive(Clone, Copy, Debug)]
pub struct Planes<const Q: usize> {
    /// A corner, from the center of the first pixel.
    origin: DVec2,
    /// The numbers there.
    at: [f64; Q],
    right: [f64; Q],
    down: [f64; Q],
}

impl<const Q: usize> Planes<Q> {
    /// 0 everywhere.
    pub const ZERO: Self = Planes { origin: DVec2::ZERO, at: [0.0; Q], right: [0.0; Q], down: [0.0; Q] };

    /// The planes through the `values` of a triangle's corners.
    pub fn new([a, b, c]: [DVec2; 3], values: [[f64; Q]; 3]) -> Self {
        let per_area = 1.0 / Frame::area2(a, b, c);
        let slope = |from: DVec2, to: DVec2| DVec2::new(to.y - from.y, from.x - to.x) * per_area;
        let (to_b, to_c) = (slope(c, a), slope(a, b));
        let mut planes = Planes { origin: a - 0.5, at: values[0], ..Planes::ZERO };
        for (q, start) in values[0].iter().enumerate() {
            let slope = to_b * (values[1][q] - start) + to_c * (values[2][q] - start);
            (planes.right[q], planes.down[q]) = (slope.x, slope.y);
        }
        planes
    }

    /// The numbers at the center of pixel `x` of `row`, and the steps to the next pixel.
    #[inline(always)]
    pub fn at(&self, x: u32, row: u32) -> ([f64; Q], [f64; Q]) {
        let (x, y) = (f64::from(x) - self.origin.x, f64::from(row) - self.origin.y);
        (std::array::from_fn(|q| self.at[q] + self.right[q] * x + self.down[q] * y), self.right)
    }
}
