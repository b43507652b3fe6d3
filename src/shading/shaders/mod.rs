//! The shaders. Their equations give the light at a point in a triangle from the weights w_A, w_B, w_C of
//! the corners on the screen and from the light values I_A, I_B, I_C of the corners.
//!
//! `kernel`, below, lists the shaders.

mod corrections;
mod interpolated;
mod phong;
mod shade;
mod strips;

pub use interpolated::ShaderKernel;
pub use shade::{Correction, Shade, Shader};

use glam::DVec3;

use self::{
    corrections::Corrections,
    interpolated::{Flat, Gouraud, Quadratic, weighted},
    phong::{C1Phong, Phong},
    strips::{Slope, Strips},
};
use crate::shading::frame::{Field, Frame, Patches};

/// Prepares the shader of `shade`, without corrections, for the triangles of `frame`.
fn kernel<'f>(frame: &'f Frame, shade: &Shade) -> Box<dyn ShaderKernel + 'f> {
    let (b, depth) = (shade.strip(), shade.depth);
    match shade.shader {
        Shader::Flat => Box::new(Flat::new(frame)),
        Shader::Phong => Box::new(Phong(frame)),
        Shader::Quadratic => Box::new(Quadratic::new(frame)),
        Shader::Patch => Box::new(Patches::new(frame, Field::Light)),
        Shader::C1Phong => Box::new(C1Phong::new(frame)),
        Shader::Gouraud => Box::new(Gouraud),
        // Without strips, the other shaders are the same as Gouraud.
        _ if b <= 0.0 => Box::new(Gouraud),
        Shader::Fixed => Box::new(Strips::new(frame, b, depth, Slope::Fixed)),
        Shader::Gradient => Box::new(Strips::new(frame, b, depth, Slope::Printed)),
        Shader::GradientRepaired => Box::new(Strips::new(frame, b, depth, Slope::Repaired)),
    }
}

/// A frame ready to be shaded. The shader's light comes first, then vertex shading, then reweighting, then the paint.
pub struct Shading<'f> {
    frame: &'f Frame,
    kernel: Box<dyn ShaderKernel + 'f>,
    /// Bangay's corrections, if any are enabled.
    corrections: Option<Corrections<'f>>,
    /// True if paint multiplies the light: a shader that lights every pixel applies it itself.
    is_multiplied: bool,
}

impl<'f> Shading<'f> {
    /// Prepares `frame` by computing the constants of `shade` once.
    pub fn new(frame: &'f Frame, shade: &Shade) -> Self {
        let is_uncorrected = (shade.vertex, shade.reweight) == (Correction::Off, Correction::Off);
        Shading {
            frame,
            kernel: kernel(frame, shade),
            corrections: (!is_uncorrected).then(|| Corrections::new(frame, shade)),
            is_multiplied: frame.paint.is_some() && !shade.shader.lights_pixels(),
        }
    }

    /// Returns the linear light at the weights `w` of `triangle`.
    ///
    /// # Panics
    /// Panics if the frame has no such triangle.
    pub fn light(&self, triangle: usize, w: [f64; 3]) -> DVec3 {
        let [a, b, c] = self.frame.corners(triangle);
        let gouraud = weighted(w, [a.light, b.light, c.light]);
        let light = self.kernel.light(triangle, w, gouraud);
        let light = self.corrections.as_ref().map_or(light, |corrections| corrections.corrected(triangle, w, light));
        let color = self.is_multiplied.then(|| self.frame.paint_color(triangle, w)).flatten();
        color.map_or(light, |color| light * color)
    }
}
