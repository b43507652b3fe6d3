//! Draws one mesh.

use glam::DVec2;
use rayon::prelude::*;

use crate::{
    light::LinearImage,
    shading::{
        frame::{Frame, coverage},
        shaders::{Shade, Shading},
    },
    system::checkpoint,
};

/// The number of rows that one thread draws at a time.
pub(super) const ROWS: usize = 16;

/// Draws `frame` with `shade` in linear light, with every pixel sampled at its center. The picture is the same for any
/// number of threads.
pub fn image(frame: &Frame, shade: &Shade) -> LinearImage {
    let (shading, outlines) = (Shading::new(frame, shade), coverage::outlines(frame));
    let background = frame.background.as_vec3().to_array();
    let mut image = LinearImage::new(frame.width, frame.height);
    let width = frame.width as usize;
    image.data.par_chunks_mut((3 * width * ROWS).max(1)).enumerate().for_each(|(band, pixels)| {
        checkpoint();
        let first = band * ROWS;
        let seen = coverage::visible_in(frame, &outlines, first as u32..(first + pixels.len() / (3 * width)) as u32);
        for (i, (pixel, triangle)) in pixels.as_chunks_mut::<3>().0.iter_mut().zip(seen).enumerate() {
            if triangle == coverage::NONE {
                *pixel = background;
                continue;
            }
            let center = DVec2::new((i % width) as f64, (first + i / width) as f64) + 0.5;
            let light = shading.light(triangle as usize, frame.weights(triangle as usize, center));
            *pixel = light.as_vec3().to_array();
        }
    });
    image
}
