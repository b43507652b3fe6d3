//! Interpolates the normal and lights every pixel. Shoaff §3.4.

use super::{gouraud::ShaderKernel, pixel::PixelLight};
use crate::shading::{
    frame::Frame,
    number::{Channels, Constant, Number, unit, weighted},
};

/// The light of a surface with the normalized normal Σ w_i·N_i at the position Σ w_i·P_i.
#[derive(Clone, Debug)]
pub struct Phong<T, const C: usize> {
    normals: Vec<[[T; 3]; 3]>,
    /// Positions in eye space; empty if only directions matter.
    places: Vec<[[T; 3]; 3]>,
    pixel: PixelLight<T, C>,
    /// The position of the eye on the z axis; `None` if it is infinitely far away.
    eye: Option<T>,
}

impl<T: Constant, const C: usize> Phong<T, C> {
    /// Prepares the shader for the triangles of `frame`, lit by the frame's lamps.
    pub fn new(frame: &Frame, channels: Channels) -> Self {
        let pixel = PixelLight::new(frame, channels);
        let eye = frame.view.distance.is_finite().then(|| T::of(frame.view.distance));
        let has_places = eye.is_some() || pixel.has_near_lamps();
        Phong {
            normals: frame.corner_vectors(|v| v.normal),
            places: if has_places { frame.corner_vectors(|v| v.eye) } else { Vec::new() },
            pixel,
            eye,
        }
    }
}

impl<T: Constant, const C: usize> ShaderKernel<T, C> for Phong<T, C> {
    #[inline(always)]
    fn light<N: Number<Constant = T>>(&self, triangle: usize, w: [N; 3], _: [N; C]) -> [N; C] {
        let (zero, one) = (w[0].of(0.0), w[0].of(1.0));
        let normal = unit(weighted(w, &self.normals[triangle])).0;
        let (mut place, mut to_viewer) = ([zero; 3], [zero, zero, one]);
        if let Some(places) = self.places.get(triangle) {
            place = weighted(w, places);
        }
        if let Some(eye) = self.eye {
            to_viewer = unit([zero - place[0], zero - place[1], zero.all(eye) - place[2]]).0;
        }
        self.pixel.light(triangle, w, place, normal, to_viewer)
    }
}
