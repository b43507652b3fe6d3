//! Interpolates the normal and lights every pixel. Shoaff §3.4.

use glam::DVec3;

use super::{
    gouraud::{ShaderKernel, weighted},
    pixel::PixelLight,
};
use crate::shading::frame::Frame;

/// The light of a surface with the normalized normal Σ a_i·N_i at the position Σ a_i·P_i, where a_i are the weights on
/// the flat triangle: as on graphics cards, w_i/z_i divided by their sum, with the weights w_i on the screen and the
/// distances z_i from the eye's plane.
pub struct Phong<'f>(PixelLight<'f>);

impl<'f> Phong<'f> {
    /// Prepares the shader for the triangles of `frame`, lit by the frame's lamps.
    pub fn new(frame: &'f Frame) -> Self {
        Phong(PixelLight::new(frame))
    }
}

impl ShaderKernel for Phong<'_> {
    fn light(&self, triangle: usize, w: [f64; 3], _: DVec3) -> DVec3 {
        let frame = self.0.frame;
        let corners = frame.corners(triangle);
        let near = corners.map(|v| frame.view.nearness(v.eye.z));
        let normal = weighted(w, [0, 1, 2].map(|k| corners[k].normal * near[k])).normalize_or_zero();
        let far = 1.0 / (w[0] * near[0] + w[1] * near[1] + w[2] * near[2]);
        let place = weighted(w, [0, 1, 2].map(|k| corners[k].eye * near[k])) * far;
        self.0.light(triangle, w, place, normal, frame.view.to_viewer(place))
    }
}
