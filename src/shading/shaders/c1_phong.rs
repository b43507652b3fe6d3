//! New in machband: Phong's lighting at every pixel, with normals that change with a continuous slope. The normals are
//! the reduced Clough–Tocher cubics of [`Patches`], normalized.

use glam::DVec3;

use super::{
    gouraud::{ShaderKernel, weighted},
    phong::PixelLight,
};
use crate::shading::frame::{Field, Frame, Patches};

/// The light of a surface with smooth normals.
///
/// The line of sight through a pixel is known exactly, so the direction to the eye is smooth. The position on it
/// matters only if a lamp is near. It then comes from a cubic of z, because the depths of flat triangles bend at their
/// edges.
pub struct C1Phong<'f> {
    normals: Patches,
    /// Positions, of which z counts, if a lamp is near.
    places: Option<Patches>,
    /// Where the line of sight to each vertex meets the plane z = 0.
    sights: Vec<DVec3>,
    pixel: PixelLight<'f>,
}

impl<'f> C1Phong<'f> {
    /// Prepares the shader for the triangles of `frame`, lit by the frame's lamps.
    pub fn new(frame: &'f Frame) -> Self {
        let places = frame.lighting.has_near_lamps().then(|| Patches::new(frame, Field::Position));
        let sights = frame.vertices.iter().map(|v| frame.view.sight(v.screen).extend(0.0)).collect();
        C1Phong { normals: Patches::new(frame, Field::Normal), places, sights, pixel: PixelLight::new(frame) }
    }
}

impl ShaderKernel for C1Phong<'_> {
    fn light(&self, triangle: usize, w: [f64; 3], gouraud: DVec3) -> DVec3 {
        let frame = self.pixel.frame;
        let normal = self.normals.light(triangle, w, gouraud).normalize_or_zero();
        let ([a, b, c], sight) = (frame.triangles[triangle].vertices, |v: u32| self.sights[v as usize]);
        let mut place = weighted(w, [sight(a), sight(b), sight(c)]);
        let to_viewer = frame.view.to_viewer(place);
        if let Some(places) = &self.places {
            place.z = places.light(triangle, w, gouraud).z;
            // A parallel projection moves only z; a perspective one moves along the line of sight.
            let nearer = 1.0 - place.z / frame.view.distance;
            (place.x, place.y) = (place.x * nearer, place.y * nearer);
        }
        self.pixel.light(triangle, w, place, normal, to_viewer)
    }
}
