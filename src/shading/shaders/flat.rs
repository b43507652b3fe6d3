//! One light value per triangle. Shoaff §3.4.

use glam::DVec3;

use super::gouraud::ShaderKernel;
use crate::shading::frame::Frame;

/// The light of each triangle: the light at its centroid, with the normal of the face.
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
