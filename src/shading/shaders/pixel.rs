//! Lights a pixel whose normal is known.

use glam::DVec3;

use super::painted::Painted;
use crate::shading::frame::Frame;

/// The lighting of a frame, for any pixel.
pub struct PixelLight<'f> {
    pub(super) frame: &'f Frame,
    paint: Option<Painted>,
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
