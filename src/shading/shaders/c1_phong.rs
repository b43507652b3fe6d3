//! New in machband: Phong's lighting at every pixel, with normals that change with a continuous slope. The normals are
//! the reduced Clough–Tocher cubics of [`Patches`], normalized.

use super::{gouraud::ShaderKernel, patch::Patch, pixel::PixelLight};
use crate::shading::{
    frame::{Field, Frame, Gradients, Patches},
    number::{Channels, Constant, Number, unit, weighted},
};

/// The light of a surface with smooth normals.
///
/// The line of sight through a pixel is known exactly, so the direction to the eye is smooth. The position on it
/// matters only if a lamp is near. It then comes from a cubic of z, because the depths of flat triangles bend at their
/// edges.
#[derive(Clone, Debug)]
pub struct C1Phong<T, const C: usize> {
    normals: Patch<T, 3>,
    /// Where the lines of sight through the corners meet the plane z = 0; empty if only directions matter.
    sights: Vec<[[T; 3]; 3]>,
    /// z, if a lamp is near.
    depths: Option<Patch<T, 1>>,
    pixel: PixelLight<T, C>,
    /// The position of the eye on the z axis; `None` if it is infinitely far away.
    eye: Option<T>,
}

/// Only blue, which stands for z.
const ONLY_Z: Channels = Channels::Gray([false, false, true]);

impl<T: Constant, const C: usize> C1Phong<T, C> {
    /// Prepares the shader for the triangles of `frame`, lit by the frame's lamps, with slopes of the normal computed
    /// as `gradients` specifies.
    pub fn new(frame: &Frame, channels: Channels, gradients: Gradients) -> Self {
        let pixel = PixelLight::new(frame, channels);
        let eye = frame.view.distance.is_finite().then(|| T::of(frame.view.distance));
        let normals = Patches::new(frame, Field::Normal, gradients);
        let depths =
            pixel.has_near_lamps().then(|| Patch::new(frame, ONLY_Z, &Patches::new(frame, Field::Position, gradients)));
        let sights = if eye.is_some() || depths.is_some() {
            frame.corner_vectors(|v| frame.view.sight(v.screen).extend(0.0))
        } else {
            Vec::new()
        };
        C1Phong { normals: Patch::new(frame, Channels::Color, &normals), sights, depths, pixel, eye }
    }
}

impl<T: Constant, const C: usize> ShaderKernel<T, C> for C1Phong<T, C> {
    #[inline(always)]
    fn light<N: Number<Constant = T>>(&self, triangle: usize, w: [N; 3], _: [N; C]) -> [N; C] {
        let (zero, one) = (w[0].of(0.0), w[0].of(1.0));
        let normal = unit(self.normals.light(triangle, w, [zero; 3])).0;
        let (mut place, mut to_viewer) = ([zero; 3], [zero, zero, one]);
        if let Some(sights) = self.sights.get(triangle) {
            place = weighted(w, sights);
        }
        if let Some(eye) = self.eye {
            to_viewer = unit([zero - place[0], zero - place[1], zero.all(eye)]).0;
        }
        if let Some(depths) = &self.depths {
            let [z] = depths.light(triangle, w, [zero]);
            // A parallel projection moves only z; a perspective one moves along the line of sight.
            if let Some(eye) = self.eye {
                let nearer = one - z / zero.all(eye);
                (place[0], place[1]) = (place[0] * nearer, place[1] * nearer);
            }
            place[2] = z;
        }
        self.pixel.light(triangle, w, place, normal, to_viewer)
    }
}
