//! The shaders. Their equations give the light at a point in a triangle from the weights w_A, w_B, w_C of
//! the corners on the screen and from the light values I_A, I_B, I_C of the corners.
//!
//! `kernel`, below, lists the shaders.

mod bangay;
mod interpolated;
mod shade;

pub use shade::{Correction, Shade, Shader};

use glam::DVec3;

use self::{
    bangay::{Corrections, Curve, Slope, Strips},
    interpolated::{bulges, c1_phong, flat, phong, quadratic, weighted},
};
use crate::shading::frame::{Field, Frame, Patches};

/// Spreads light over the triangles of a frame: returns the light at the point where the corners of a triangle have the
/// given weights on the screen, and where Gouraud's light, Bangay eq. 2, is the last argument.
type Kernel<'f> = Box<dyn Fn(usize, [f64; 3], DVec3) -> DVec3 + Send + Sync + 'f>;

/// Prepares the shader of `shade`, without corrections, for the triangles of `frame`.
fn kernel<'f>(frame: &'f Frame, shade: &Shade) -> Kernel<'f> {
    let slope = match shade.shader {
        Shader::Flat => {
            let lights = frame.each_triangle(|t| flat(frame, t));
            return Box::new(move |triangle, _, _| lights[triangle]);
        }
        Shader::Phong => return Box::new(|triangle, w, _| phong(frame, triangle, w)),
        Shader::Quadratic => {
            let bulges = frame.each_triangle(|t| bulges(frame, t));
            return Box::new(move |triangle, w, gouraud| quadratic(&bulges[triangle], w, gouraud));
        }
        Shader::Patch => {
            let patches = Patches::new(frame, Field::Light);
            return Box::new(move |triangle, w, _| patches.value(triangle, w));
        }
        Shader::C1Phong => {
            let light = c1_phong(frame);
            return Box::new(move |triangle, w, _| light(triangle, w));
        }
        Shader::Gouraud => return Box::new(|_, _, gouraud| gouraud),
        Shader::Fixed => Slope::Fixed,
        Shader::Gradient => Slope::Printed,
        Shader::GradientRepaired => Slope::Repaired,
    };
    // Without a width, no weight lies in a strip, and the light is Gouraud's.
    let strips = Strips { frame, strip: shade.strip(), step: Curve::printed(shade.depth), slope };
    Box::new(move |triangle, w, gouraud| strips.light(triangle, w, gouraud))
}

/// A frame ready to be shaded. The shader's light comes first, then vertex shading, then reweighting, then the paint.
pub struct Shading<'f> {
    frame: &'f Frame,
    kernel: Kernel<'f>,
    /// Bangay's corrections, if any are enabled.
    corrections: Option<Corrections<'f>>,
    /// True if paint multiplies the light: a shader that lights every pixel applies it itself.
    is_multiplied: bool,
}

impl<'f> Shading<'f> {
    /// Prepares `frame` by computing the constants of `shade` once.
    pub fn new(frame: &'f Frame, shade: &Shade) -> Self {
        let is_corrected = (shade.vertex, shade.reweight) != (Correction::Off, Correction::Off);
        let is_corrected = is_corrected && shade.shader.interpolates_light();
        Shading {
            frame,
            kernel: kernel(frame, shade),
            corrections: is_corrected.then(|| Corrections::new(frame, shade)),
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
        let light = (self.kernel)(triangle, w, gouraud);
        let light = self.corrections.as_ref().map_or(light, |corrections| corrections.corrected(triangle, w, light));
        let color = self.is_multiplied.then(|| self.frame.paint_color(triangle, w)).flatten();
        color.map_or(light, |color| light * color)
    }
}
