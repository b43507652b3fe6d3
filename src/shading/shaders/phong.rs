//! Interpolates the normal and lights every pixel. Shoaff §3.4.

use glam::DVec3;

use super::{
    gouraud::{ShaderKernel, weighted},
    painted::Painted,
};
use crate::shading::frame::{Frame, FrameVertex};

/// The lighting of a frame, for any pixel whose normal is known.
pub struct PixelLight<'f> {
    pub(super) frame: &'f Frame,
    paint: Option<Painted<'f>>,
}

impl<'f> PixelLight<'f> {
    pub fn new(frame: &'f Frame) -> Self {
        PixelLight { frame, paint: Painted::of(frame) }
    }

    /// Returns the light at the weights `w` of a triangle, at a position with a unit normal and a unit vector toward the
    /// viewer, all in eye space.
    pub fn light(&self, triangle: usize, w: [f64; 3], position: DVec3, normal: DVec3, to_viewer: DVec3) -> DVec3 {
        let (color, normal) = match &self.paint {
            Some(paint) => paint.surface(triangle, w, normal),
            None => (DVec3::ONE, normal),
        };
        self.frame.lighting.painted(position, normal, to_viewer, color)
    }
}

/// The light of a surface with the normalized normal Σ a_i·N_i at the position Σ a_i·P_i, where a_i are the weights on
/// the flat triangle: as on graphics cards, w_i/z_i divided by their sum, with the weights w_i on the screen and the
/// distances z_i from the eye's plane.
pub struct Phong<'f>(pub PixelLight<'f>);

impl ShaderKernel for Phong<'_> {
    fn light(&self, triangle: usize, w: [f64; 3], _: DVec3) -> DVec3 {
        let frame = self.0.frame;
        let [a, b, c] = frame.corners(triangle);
        let near = |v: &FrameVertex| frame.view.nearness(v.eye.z);
        let on_surface = [w[0] * near(a), w[1] * near(b), w[2] * near(c)];
        let normal = weighted(on_surface, [a.normal, b.normal, c.normal]).normalize_or_zero();
        let far = 1.0 / on_surface.iter().sum::<f64>();
        let place = weighted(on_surface, [a.eye, b.eye, c.eye]) * far;
        self.0.light(triangle, w, place, normal, frame.view.to_viewer(place))
    }
}
