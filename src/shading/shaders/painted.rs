//! Colors and normals of a painted mesh at a pixel.

use glam::DVec3;

use crate::shading::{
    frame::Frame,
    mesh::{Coat, Paint, PaintedCorner},
};

/// The paint of a frame.
pub struct Painted<'f> {
    frame: &'f Frame,
    paint: &'f Paint,
}

impl<'f> Painted<'f> {
    /// Returns the paint of `frame`, if it has any.
    pub fn of(frame: &'f Frame) -> Option<Self> {
        Some(Painted { frame, paint: frame.paint.as_deref()? })
    }

    /// Returns the color at the weights `w` of a triangle.
    pub fn color(&self, triangle: usize, w: [f64; 3]) -> DVec3 {
        let (coat, corner) = self.at(triangle, w);
        coat.color(&corner)
    }

    /// Returns the color and the normal at the weights `w` of a triangle whose shader gives the unit normal `normal`.
    pub fn surface(&self, triangle: usize, w: [f64; 3], normal: DVec3) -> (DVec3, DVec3) {
        let (coat, mut corner) = self.at(triangle, w);
        // The back's normal is reversed; its textures stay where they are.
        let side = if self.frame.triangles[triangle].is_back { -1.0 } else { 1.0 };
        let tangent = self.frame.view.rotation * corner.tangent.truncate();
        corner.tangent = tangent.extend(side * corner.tangent.w);
        (coat.color(&corner), coat.normal(&corner, normal))
    }

    /// Interpolates the corners of a triangle with correction for perspective.
    fn at(&self, triangle: usize, w: [f64; 3]) -> (&Coat, PaintedCorner) {
        let drawn = &self.frame.triangles[triangle];
        let [a, b, c] = self.paint.corners[drawn.of_mesh as usize];
        let corners = if drawn.is_back { [a, c, b] } else { [a, b, c] };
        let near = self.frame.corners(triangle).map(|v| self.frame.view.nearness(v.eye.z));
        let weights = [0, 1, 2].map(|k| w[k] * near[k]);
        let sum: f64 = weights.iter().sum();
        let mean = PaintedCorner::mean(&corners, weights.map(|weight| weight / sum));
        (&self.paint.coats[self.paint.of_triangles[drawn.of_mesh as usize] as usize], mean)
    }
}
