//! Every shader in f64, one pixel at a time: the truth that the fast ways of drawing are held against, and the bytes of
//! every stimulus.

use glam::{DVec2, DVec3};

use crate::shading::{
    channels::Channels,
    frame::Frame,
    number::weighted,
    shaders::{Shade, Shading, Spread as _},
};

/// A frame ready to be shaded in f64.
#[derive(Clone, Debug)]
pub struct Reference<'f> {
    frame: &'f Frame,
    shading: Shading<f64, 3>,
}

impl<'f> Reference<'f> {
    /// Computes what `shade` needs of `frame` once.
    #[must_use]
    pub fn new(frame: &'f Frame, shade: &Shade) -> Self {
        Reference { frame, shading: Shading::new(frame, shade, Channels::Color) }
    }

    /// What is shaded.
    #[must_use]
    pub fn frame(&self) -> &'f Frame {
        self.frame
    }

    /// The light at the weights `w` of `triangle`, linear.
    ///
    /// # Panics
    /// If the frame has no such triangle.
    #[must_use]
    pub fn light(&self, triangle: usize, w: [f64; 3]) -> DVec3 {
        let lights = self.frame.corners(triangle).map(|v| v.light.to_array());
        DVec3::from_array(self.shading.light(triangle, w, weighted(w, &lights)))
    }

    /// The light of `triangle` at the center of pixel `x` of row `y`.
    #[must_use]
    pub fn pixel(&self, triangle: usize, x: u32, y: u32) -> DVec3 {
        let center = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
        self.light(triangle, self.frame.weights(triangle, center))
    }
}
