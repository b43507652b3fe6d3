//! Interpolates the normal and lights every pixel. Shoaff §3.4.

use super::{gouraud::ShaderKernel, pixel::PixelLight};
use crate::shading::{
    frame::{Frame, FrameVertex},
    number::{Channels, Constant, Number, unit, weighted},
};

/// The light of a surface with the normalized normal Σ a_i·N_i at the position Σ a_i·P_i, where a_i are the weights on
/// the flat triangle: as on graphics cards, w_i/z_i divided by their sum, with the weights w_i on the screen and the
/// distances z_i from the eye's plane.
#[derive(Clone, Debug)]
pub struct Phong<T, const C: usize> {
    /// Normals, times the nearness of the corner.
    normals: Vec<[[T; 3]; 3]>,
    /// Positions in eye space, times the same; empty if only directions matter.
    places: Vec<[[T; 3]; 3]>,
    /// The nearness of each corner; empty if the eye is infinitely far away.
    nearness: Vec<[T; 3]>,
    pixel: PixelLight<T, C>,
    /// The position of the eye on the z axis; `None` if it is infinitely far away.
    eye: Option<T>,
}

impl<T: Constant, const C: usize> Phong<T, C> {
    /// Prepares the shader for the triangles of `frame`, lit by the frame's lamps.
    pub fn new(frame: &Frame, channels: Channels) -> Self {
        let pixel = PixelLight::new(frame, channels);
        let distance = frame.view.distance;
        let has_eye = distance.is_finite();
        let near = |v: &FrameVertex| frame.view.nearness(v.eye.z);
        let corners = |t: usize| frame.corners(t).map(|v| T::of(near(v)));
        let has_places = has_eye || pixel.has_near_lamps();
        Phong {
            normals: frame.corner_vectors(|v| v.normal * near(v)),
            places: if has_places { frame.corner_vectors(|v| v.eye * near(v)) } else { Vec::new() },
            nearness: if has_eye { frame.each_triangle(corners) } else { Vec::new() },
            pixel,
            eye: has_eye.then(|| T::of(distance)),
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
        if let Some(near) = self.nearness.get(triangle) {
            let far = one / (w[0].times(near[0]) + w[1].times(near[1]) + w[2].times(near[2]));
            place = place.map(|p| p * far);
        }
        if let Some(eye) = self.eye {
            to_viewer = unit([zero - place[0], zero - place[1], zero.all(eye) - place[2]]).0;
        }
        self.pixel.light(triangle, w, place, normal, to_viewer)
    }
}
