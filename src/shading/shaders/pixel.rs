//! Lights a pixel whose normal is known.

use super::{painted::Painted, shade::Shader};
use crate::{
    light::Transfers,
    shading::{
        frame::Frame,
        lighting::Reflection,
        number::{Channels, Constant, Number},
    },
};

/// The lighting of a frame, prepared for any pixel.
#[derive(Clone, Debug)]
pub struct PixelLight<T, const C: usize> {
    ambient: [T; C],
    lamps: Vec<Reflection<T, C>>,
    encoding: Option<Transfers>,
    paint: Option<Painted>,
}

impl<T: Constant, const C: usize> PixelLight<T, C> {
    pub fn new(frame: &Frame, channels: Channels) -> Self {
        let lighting = &frame.lighting;
        let lamp = |lamp| Reflection::new(lamp, &lighting.material, channels);
        PixelLight {
            ambient: channels.pick(lighting.ambient_light()),
            lamps: lighting.lamps.iter().map(lamp).collect(),
            encoding: frame.encoding.clone(),
            paint: Painted::of(frame, Shader::Phong),
        }
    }

    /// True if the light depends on the distance of the surface from a lamp.
    pub fn has_near_lamps(&self) -> bool {
        self.lamps.iter().any(Reflection::is_near)
    }

    /// Returns the light at the weights `w` of a triangle, at a position with a unit normal and a unit vector toward the
    /// viewer, all in eye space.
    #[inline(always)]
    pub fn light<N: Number<Constant = T>>(
        &self,
        triangle: usize,
        w: [N; 3],
        position: [N; 3],
        normal: [N; 3],
        to_viewer: [N; 3],
    ) -> [N; C] {
        let (mut normal, mut color) = (normal, None);
        if let Some(paint) = &self.paint {
            let (tint, bumped) = paint.surface(triangle, w, normal);
            (normal, color) = (bumped, Some(tint));
        }
        let mut sum = self.ambient.map(|ambient| normal[0].all(ambient));
        if let Some(color) = color {
            for c in 0..C {
                sum[c] = sum[c] * color[c];
            }
        }
        for lamp in &self.lamps {
            let light = lamp.light(position, normal, to_viewer, color);
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
