//! Interpolates the normal and lights every pixel. Shoaff §3.4.

use super::gouraud::ShaderKernel;
use crate::{
    light::Transfers,
    shading::{
        frame::Frame,
        lighting::Reflection,
        number::{Channels, Constant, Number, unit, weighted},
    },
};

/// The light of a surface with the normalized normal Σ w_i·N_i at the position Σ w_i·P_i.
#[derive(Clone, Debug)]
pub struct Phong<T, const C: usize> {
    normals: Vec<[[T; 3]; 3]>,
    /// Positions in eye space; empty if only directions matter.
    places: Vec<[[T; 3]; 3]>,
    ambient: [T; C],
    lamps: Vec<Reflection<T, C>>,
    /// The position of the eye on the z axis; `None` if it is infinitely far away.
    eye: Option<T>,
    encoding: Option<Transfers>,
}

impl<T: Constant, const C: usize> Phong<T, C> {
    /// Prepares the shader for the triangles of `frame`, lit by the frame's lamps.
    pub fn new(frame: &Frame, channels: Channels) -> Self {
        let lighting = &frame.lighting;
        let lamp = |lamp| Reflection::new(lamp, &lighting.material, channels);
        let lamps: Vec<Reflection<T, C>> = lighting.lamps.iter().map(lamp).collect();
        let eye = frame.view.distance.is_finite().then(|| T::of(frame.view.distance));
        let has_places = eye.is_some() || lamps.iter().any(Reflection::is_near);
        Phong {
            normals: frame.corner_vectors(|v| v.normal),
            places: if has_places { frame.corner_vectors(|v| v.eye) } else { Vec::new() },
            ambient: channels.pick(lighting.ambient_light()),
            lamps,
            eye,
            encoding: frame.encoding.clone(),
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
        let mut sum = self.ambient.map(|ambient| zero.all(ambient));
        for lamp in &self.lamps {
            let light = lamp.light(place, normal, to_viewer);
            for c in 0..C {
                sum[c] = sum[c] + light[c];
            }
        }
        match &self.encoding {
            None => sum,
            Some(transfers) => N::each(sum, |light| encoded(transfers, light)),
        }
    }
}

/// One channel stands for several only if they have the same transfer function.
fn encoded<const C: usize>(transfers: &Transfers, light: [f64; C]) -> [f64; C] {
    let mut channels = [light[0]; 3];
    channels[..C].copy_from_slice(&light);
    let encoded = transfers.encoded_from_linear(channels);
    std::array::from_fn(|c| encoded[c])
}
