//! Quadratic light through the light values at the vertices and at the midpoints of the edges, after Mohamed et al.,
//! whose shader uses three additional samples of the light per triangle.

use glam::DVec3;

use super::{gouraud::ShaderKernel, strips::OTHERS};
use crate::shading::frame::Frame;

/// The quadratic through the light values of the corners and the light values M_k of the midpoints, where M_k is
/// opposite corner k: Gouraud's light plus Σ_k w_i·w_j·4(M_k − (I_i + I_j)/2).
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
