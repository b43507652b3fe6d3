//! The shaders, one per file. Their equations give the light at a point in a triangle from the weights w_A, w_B, w_C of
//! the corners on the screen and from the light values I_A, I_B, I_C of the corners.
//!
//! Each shader is written once, for any `Number`: with f64 it is the reference, and with several pixels of f32 it
//! draws. Its WGSL for graphics cards is next to it, or in `gpu/main.wgsl` if it is only a line or two.
//!
//! `Plain`, below, lists the shaders.

mod corrections;
mod cut;
mod exact;
mod fixed;
pub mod flat;
mod gouraud;
mod gradient;
mod patch;
mod phong;
pub mod quadratic;
mod shade;
mod strips;

pub use gouraud::Spread;
pub use patch::Patch;
pub use shade::{Correction, Shade, Shader};
pub use strips::Curve;

use self::{
    corrections::Corrections,
    cut::Cut,
    exact::Exact,
    fixed::Fixed,
    flat::Flat,
    gouraud::Gouraud,
    gradient::{Gradient, Sign},
    phong::Phong,
    quadratic::Quadratic,
};
use crate::shading::{
    frame::{Frame, Patches},
    number::{Channels, Constant, Number},
};

/// A shader without corrections, with its constants computed.
#[derive(Clone, Debug)]
pub enum Plain<T, const C: usize> {
    Flat(Flat<T, C>),
    /// *gouraud*, and any strip shader whose strips have no width.
    Gouraud(Gouraud),
    Phong(Phong<T, C>),
    Quadratic(Quadratic<T, C>),
    Fixed(Fixed<T, C>),
    /// *gradient* and *gradient-repaired*.
    Gradient(Gradient<T, C>),
    Exact(Exact<T, C>),
    Cut(Cut<T, C>),
    Patch(Patch<T, C>),
}

/// Evaluates `$body` with `$shader` bound to the shader in `$plain`.
macro_rules! with_shader {
    ($plain:expr, $shader:ident => $body:expr) => {
        match $plain {
            $crate::shading::shaders::Plain::Flat($shader) => $body,
            $crate::shading::shaders::Plain::Gouraud($shader) => $body,
            $crate::shading::shaders::Plain::Phong($shader) => $body,
            $crate::shading::shaders::Plain::Quadratic($shader) => $body,
            $crate::shading::shaders::Plain::Fixed($shader) => $body,
            $crate::shading::shaders::Plain::Gradient($shader) => $body,
            $crate::shading::shaders::Plain::Exact($shader) => $body,
            $crate::shading::shaders::Plain::Cut($shader) => $body,
            $crate::shading::shaders::Plain::Patch($shader) => $body,
        }
    };
}

pub(crate) use with_shader;

impl<T: Constant, const C: usize> Plain<T, C> {
    /// Prepares the shader of `shade` for the triangles of `frame`.
    #[must_use]
    pub fn new(frame: &Frame, shade: &Shade, channels: Channels) -> Self {
        let (b, depth) = (shade.strip(), shade.depth);
        let gradient = |sign| Plain::Gradient(Gradient::new(frame, channels, sign, b, depth));
        match shade.shader {
            Shader::Flat => Plain::Flat(Flat::new(frame, channels)),
            Shader::Phong => Plain::Phong(Phong::new(frame, channels)),
            Shader::Quadratic => Plain::Quadratic(Quadratic::new(frame, channels)),
            Shader::Patch => Plain::Patch(Patch::new(frame, channels, &Patches::new(frame, shade.gradients))),
            Shader::Gouraud => Plain::Gouraud(Gouraud),
            // Without strips, the other shaders are the same as Gouraud.
            _ if b <= 0.0 => Plain::Gouraud(Gouraud),
            Shader::Fixed => Plain::Fixed(Fixed::new(frame, channels, b, depth)),
            Shader::Gradient => gradient(Sign::Printed),
            Shader::GradientRepaired => gradient(Sign::Repaired),
            Shader::Exact => Plain::Exact(Exact::new(frame, channels, b, depth)),
            Shader::Cut => Plain::Cut(Cut::new(frame, channels, b, depth)),
        }
    }
}

/// A shader with its corrections. The shader's light comes first, then vertex shading, then reweighting.
#[derive(Clone, Debug)]
pub struct Shading<T, const C: usize> {
    /// The shader.
    pub plain: Plain<T, C>,
    /// Bangay's corrections, if any are enabled.
    pub corrections: Option<Corrections<T, C>>,
}

impl<T: Constant, const C: usize> Shading<T, C> {
    /// Prepares the shader of `shade` for the triangles of `frame`, in the channels that are shaded.
    #[must_use]
    pub fn new(frame: &Frame, shade: &Shade, channels: Channels) -> Self {
        let is_plain = (shade.vertex, shade.reweight) == (Correction::Off, Correction::Off);
        Shading {
            plain: Plain::new(frame, shade, channels),
            corrections: (!is_plain).then(|| Corrections::new(frame, shade, channels)),
        }
    }
}

impl<T: Constant, const C: usize> Spread<T, C> for Shading<T, C> {
    #[inline(always)]
    fn light<N: Number<Constant = T>>(&self, triangle: usize, w: [N; 3], gouraud: [N; C]) -> [N; C] {
        let value = with_shader!(&self.plain, shader => shader.light(triangle, w, gouraud));
        match &self.corrections {
            Some(corrections) => corrections.corrected(triangle, w, value),
            None => value,
        }
    }
}
