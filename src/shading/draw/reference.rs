//! Evaluates every shader in f64, one pixel at a time. This is the reference for the fast renderers and the source of
//! every stimulus.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use crate::{
    light::LinearImage,
    shading::{
        frame::{Frame, coverage},
        number::{Channels, weighted},
        shaders::{Shade, ShaderKernel as _, Shading},
    },
    system::checkpoint,
};

/// A frame ready to be shaded in f64.
#[derive(Clone, Debug)]
pub struct Reference<'f> {
    frame: &'f Frame,
    shading: Shading<f64, 3>,
}

impl<'f> Reference<'f> {
    /// Prepares `frame` by computing the constants of `shade` once.
    pub fn new(frame: &'f Frame, shade: &Shade) -> Self {
        Reference { frame, shading: Shading::new(frame, shade, Channels::Color) }
    }

    /// Returns the linear light at the weights `w` of `triangle`.
    ///
    /// # Panics
    /// Panics if the frame has no such triangle.
    pub fn light(&self, triangle: usize, w: [f64; 3]) -> DVec3 {
        let lights = self.frame.corners(triangle).map(|v| v.light.to_array());
        DVec3::from_array(self.shading.light(triangle, w, weighted(w, &lights)))
    }

    /// Draws the entire image, with every pixel sampled at its center.
    pub fn image(&self) -> LinearImage {
        let frame = self.frame;
        let light = |(i, triangle): (usize, u32)| {
            checkpoint();
            if triangle == coverage::NONE {
                return frame.background.as_vec3().to_array();
            }
            let center = DVec2::new((i % frame.width as usize) as f64, (i / frame.width as usize) as f64) + 0.5;
            self.light(triangle as usize, frame.weights(triangle as usize, center)).as_vec3().to_array()
        };
        let pixels: Vec<[f32; 3]> = coverage::visible(frame).into_par_iter().enumerate().map(light).collect();
        LinearImage { width: frame.width, height: frame.height, data: pixels.into_flattened() }
    }
}
