//! The trait of all shaders, and the shaders whose light is constant or a polynomial over a triangle.

use glam::DVec3;

use crate::shading::{
    cubic,
    frame::{Frame, Patches},
};

/// For each corner, the other two, in order.
pub const OTHERS: [(usize, usize); 3] = [(1, 2), (2, 0), (0, 1)];

/// A shader: spreads light over the triangles of a frame.
pub trait ShaderKernel: Send + Sync {
    /// Returns the light at the point where the corners of triangle `triangle` have the weights `w` on the screen;
    /// `gouraud` is w_A·I_A + w_B·I_B + w_C·I_C at that point.
    fn light(&self, triangle: usize, w: [f64; 3], gouraud: DVec3) -> DVec3;
}

/// Bangay eq. 2: L = w_A·I_A + w_B·I_B + w_C·I_C.
pub struct Gouraud;

impl ShaderKernel for Gouraud {
    fn light(&self, _: usize, _: [f64; 3], gouraud: DVec3) -> DVec3 {
        gouraud
    }
}

/// Returns Σ w_k·values_k.
#[inline]
pub fn weighted(w: [f64; 3], values: [DVec3; 3]) -> DVec3 {
    w[0] * values[0] + w[1] * values[1] + w[2] * values[2]
}

/// One light value per triangle: the light at its centroid, with the normal of the face. Shoaff §3.4.
pub struct Flat(Vec<DVec3>);

impl Flat {
    /// Prepares the shader for the triangles of `frame`.
    pub fn new(frame: &Frame) -> Self {
        Flat(frame.each_triangle(|t| {
            let [a, b, c] = frame.corners(t).map(|v| v.eye);
            frame.lit((a + b + c) / 3.0, frame.triangles[t].normal)
        }))
    }
}

impl ShaderKernel for Flat {
    fn light(&self, triangle: usize, _: [f64; 3], _: DVec3) -> DVec3 {
        self.0[triangle]
    }
}

/// Quadratic light after Mohamed et al., whose shader uses three additional samples of the light per triangle: through
/// the light values of the corners and M_k of the midpoints of the edges, where M_k is opposite corner k. It is Gouraud's light plus Σ_k w_i·w_j·4(M_k − (I_i + I_j)/2).
pub struct Quadratic(Vec<[DVec3; 3]>);

impl Quadratic {
    /// Prepares the shader for the triangles of `frame`.
    pub fn new(frame: &Frame) -> Self {
        Quadratic(frame.each_triangle(|t| bulges(frame, t)))
    }
}

/// Returns 4(M_k − (I_i + I_j)/2) of each edge of `triangle`, where M_k is lit as `phong` would light it. Both
/// triangles at an edge get the same values.
fn bulges(frame: &Frame, triangle: usize) -> [DVec3; 3] {
    let corners = frame.corners(triangle);
    OTHERS.map(|(i, j)| {
        let place = (corners[i].eye + corners[j].eye) / 2.0;
        let normal = (corners[i].normal + corners[j].normal).normalize_or_zero();
        4.0 * (frame.lit(place, normal) - (corners[i].light + corners[j].light) / 2.0)
    })
}

impl ShaderKernel for Quadratic {
    fn light(&self, triangle: usize, w: [f64; 3], gouraud: DVec3) -> DVec3 {
        let bulges = OTHERS.iter().zip(&self.0[triangle]);
        bulges.fold(gouraud, |light, (&(i, j), bulge)| light + w[i] * w[j] * bulge)
    }
}

/// New in machband: light with a continuous slope, determined by the light values and slopes at the vertices.
impl ShaderKernel for Patches {
    fn light(&self, triangle: usize, w: [f64; 3], _: DVec3) -> DVec3 {
        cubic::value(&self.coefficients[triangle], w).into()
    }
}
