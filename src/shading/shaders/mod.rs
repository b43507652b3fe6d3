//! The shaders, one per file. Their equations give the light at a point in a triangle from the weights w_A, w_B, w_C of
//! the corners on the screen and from the light values I_A, I_B, I_C of the corners.
//!
//! Each shader is written once, for any `Number`. It is the reference when it computes in f64, and it draws when it
//! computes several pixels at once in f32.
//!
//! `UncorrectedShader`, below, lists the shaders.

mod c1_phong;
mod corrections;
mod fixed;
mod flat;
mod gouraud;
mod gradient;
mod painted;
mod patch;
mod phong;
mod pixel;
mod quadratic;
mod shade;
mod strips;

pub use gouraud::ShaderKernel;
pub use painted::Painted;
pub use patch::Patch;
pub use shade::{Correction, Shade, Shader};
pub use strips::Curve;

use self::{
    c1_phong::C1Phong, corrections::Corrections, fixed::Fixed, flat::Flat, gouraud::Gouraud, gradient::Gradient,
    phong::Phong, quadratic::Quadratic,
};
use crate::shading::{
    frame::{Field, Frame, Patches},
    number::{Channels, Constant, Number},
};

/// A shader without corrections, with its constants computed.
#[derive(Clone, Debug)]
pub enum UncorrectedShader<T, const C: usize> {
    Flat(Flat<T, C>),
    /// *gouraud*, and any strip shader whose strips have no width.
    Gouraud(Gouraud),
    Phong(Phong<T, C>),
    Quadratic(Quadratic<T, C>),
    Fixed(Fixed<T, C>),
    /// *gradient* and *gradient-repaired*.
    Gradient(Gradient<T, C>),
    Patch(Patch<T, C>),
    C1Phong(C1Phong<T, C>),
}

/// Evaluates `$body` with `$shader` bound to the shader in `$uncorrected`.
macro_rules! with_shader {
    ($uncorrected:expr, $shader:ident => $body:expr) => {
        match $uncorrected {
            $crate::shading::shaders::UncorrectedShader::Flat($shader) => $body,
            $crate::shading::shaders::UncorrectedShader::Gouraud($shader) => $body,
            $crate::shading::shaders::UncorrectedShader::Phong($shader) => $body,
            $crate::shading::shaders::UncorrectedShader::Quadratic($shader) => $body,
            $crate::shading::shaders::UncorrectedShader::Fixed($shader) => $body,
            $crate::shading::shaders::UncorrectedShader::Gradient($shader) => $body,
            $crate::shading::shaders::UncorrectedShader::Patch($shader) => $body,
            $crate::shading::shaders::UncorrectedShader::C1Phong($shader) => $body,
        }
    };
}

pub(crate) use with_shader;

impl<T: Constant, const C: usize> UncorrectedShader<T, C> {
    /// Prepares the shader of `shade` for the triangles of `frame`.
    pub fn new(frame: &Frame, shade: &Shade, channels: Channels) -> Self {
        let (b, depth) = (shade.strip(), shade.depth);
        let gradient = |is_repaired| UncorrectedShader::Gradient(Gradient::new(frame, channels, is_repaired, b, depth));
        match shade.shader {
            Shader::Flat => UncorrectedShader::Flat(Flat::new(frame, channels)),
            Shader::Phong => UncorrectedShader::Phong(Phong::new(frame, channels)),
            Shader::Quadratic => UncorrectedShader::Quadratic(Quadratic::new(frame, channels)),
            Shader::Patch => {
                let patches = Patches::new(frame, Field::Light, shade.gradients);
                UncorrectedShader::Patch(Patch::new(frame, channels, &patches))
            }
            Shader::C1Phong => UncorrectedShader::C1Phong(C1Phong::new(frame, channels, shade.gradients)),
            Shader::Gouraud => UncorrectedShader::Gouraud(Gouraud),
            // Without strips, the other shaders are the same as Gouraud.
            _ if b <= 0.0 => UncorrectedShader::Gouraud(Gouraud),
            Shader::Fixed => UncorrectedShader::Fixed(Fixed::new(frame, channels, b, depth)),
            Shader::Gradient => gradient(false),
            Shader::GradientRepaired => gradient(true),
        }
    }
}

/// A shader with its corrections and paint. The shader's light comes first, then vertex shading, then reweighting, then
/// the paint.
#[derive(Clone, Debug)]
pub struct Shading<T, const C: usize> {
    /// The shader.
    pub uncorrected: UncorrectedShader<T, C>,
    /// Bangay's corrections, if any are enabled.
    pub corrections: Option<Corrections<T, C>>,
    /// The paint that multiplies the light, unless the shader lights every pixel and applies it itself.
    pub paint: Option<Painted>,
}

impl<T: Constant, const C: usize> Shading<T, C> {
    /// Prepares the shader of `shade` for the triangles of `frame`, in the channels that are shaded.
    pub fn new(frame: &Frame, shade: &Shade, channels: Channels) -> Self {
        let is_uncorrected = (shade.vertex, shade.reweight) == (Correction::Off, Correction::Off);
        Shading {
            uncorrected: UncorrectedShader::new(frame, shade, channels),
            corrections: (!is_uncorrected).then(|| Corrections::new(frame, shade, channels)),
            paint: if shade.shader.lights_pixels() { None } else { Painted::of(frame, shade.shader) },
        }
    }
}

impl<T: Constant, const C: usize> ShaderKernel<T, C> for Shading<T, C> {
    #[inline(always)]
    fn light<N: Number<Constant = T>>(&self, triangle: usize, w: [N; 3], gouraud: [N; C]) -> [N; C] {
        let value = with_shader!(&self.uncorrected, shader => shader.light(triangle, w, gouraud));
        let value = match &self.corrections {
            Some(corrections) => corrections.corrected(triangle, w, value),
            None => value,
        };
        match &self.paint {
            Some(paint) => paint.tinted(triangle, w, value),
            None => value,
        }
    }
}
