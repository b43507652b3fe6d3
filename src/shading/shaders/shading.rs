//! Any shader with its options, ready for the triangles of one frame.

use super::{
    curve::Curve,
    cut::Cut,
    exact::Exact,
    fixed::Fixed,
    flat::Flat,
    gouraud::Gouraud,
    gradient::{Gradient, Sign},
    patch::Patch,
    phong::Phong,
    quadratic::Quadratic,
    reweight,
    shade::{Correction, Shade, Shader},
    spread::Spread,
    vertex::Fans,
};
use crate::shading::{
    channels::Channels,
    frame::{Frame, Patches},
    number::{Constant, Number, dot, weighted},
};

/// A shader without corrections, its constants computed.
#[derive(Clone, Debug)]
pub enum Plain<T, const C: usize> {
    /// *flat*
    Flat(Flat<T, C>),
    /// *gouraud*, and any strip shader with no strips.
    Gouraud(Gouraud),
    /// *phong*
    Phong(Phong<T, C>),
    /// *quadratic*
    Quadratic(Quadratic<T, C>),
    /// *fixed*
    Fixed(Fixed<T, C>),
    /// *gradient* and *gradient-repaired*
    Gradient(Gradient<T, C>),
    /// *exact*
    Exact(Exact<T, C>),
    /// *cut*
    Cut(Cut<T, C>),
    /// *patch*
    Patch(Patch<T, C>),
}

/// Does `$body` with the shader that `$plain` is, as `$shader`.
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
    /// The shader of `shade` for the triangles of `frame`.
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
            _ if b <= 0.0 => Plain::Gouraud(Gouraud),
            Shader::Fixed => Plain::Fixed(Fixed::new(frame, channels, b, depth)),
            Shader::Gradient => gradient(Sign::Printed),
            Shader::GradientRepaired => gradient(Sign::Repaired),
            Shader::Exact => Plain::Exact(Exact::new(frame, channels, b, depth)),
            Shader::Cut => Plain::Cut(Cut::new(frame, channels, b, depth)),
        }
    }
}

impl<T: Constant, const C: usize> Spread<T, C> for Plain<T, C> {
    #[inline(always)]
    fn light<N: Number<Constant = T>>(&self, triangle: usize, w: [N; 3], gouraud: [N; C]) -> [N; C] {
        with_shader!(self, shader => shader.light(triangle, w, gouraud))
    }
}

/// A shader with Bangay's corrections: its light first, then vertex shading, then reweighting.
#[derive(Clone, Debug)]
pub struct Corrected<T, const C: usize> {
    plain: Plain<T, C>,
    vertex: Correction,
    reweight: Correction,
    /// Width of the paper's strips, also on *cut*, whose own may be wider.
    strip: f64,
    printed: Curve<T>,
    curve: Curve<T>,
    triangles: Vec<Corners<T, C>>,
}

#[derive(Clone, Debug)]
struct Corners<T, const C: usize> {
    fans: Fans<T, C>,
    normals: [[T; 3]; 3],
    ambients: [[T; C]; 3],
}

impl<T: Constant, const C: usize> Corrected<T, C> {
    /// `plain`, corrected as `shade` says.
    #[must_use]
    pub fn new(frame: &Frame, shade: &Shade, channels: Channels, plain: Plain<T, C>) -> Self {
        let corners = |t| Corners {
            fans: Fans::new(frame, t, channels),
            normals: frame.corners(t).map(|v| v.normal.to_array().map(T::of)),
            ambients: frame.corners(t).map(|v| channels.pick(v.ambient)),
        };
        Corrected {
            plain,
            vertex: shade.vertex,
            reweight: shade.reweight,
            strip: shade.strip().min(1.0 / 3.0),
            printed: Curve::printed(shade.depth),
            curve: Curve::new(shade.depth),
            triangles: (0..frame.triangles.len()).map(corners).collect(),
        }
    }
}

impl<T: Constant, const C: usize> Spread<T, C> for Corrected<T, C> {
    #[inline(always)]
    fn light<N: Number<Constant = T>>(&self, triangle: usize, w: [N; 3], gouraud: [N; C]) -> [N; C] {
        let Corners { fans, normals, ambients } = &self.triangles[triangle];
        let value = self.plain.light(triangle, w, gouraud);
        let value = match self.vertex {
            Correction::Off => value,
            Correction::Printed => fans.printed(value, w, self.strip, &self.printed),
            Correction::Repaired => fans.repaired(value, w, self.strip, &self.curve),
        };
        let normal = weighted(w, normals);
        let length = dot(normal, normal).sqrt();
        match self.reweight {
            Correction::Off => value,
            Correction::Printed => reweight::printed(value, w, length, T::of(self.strip), &self.printed),
            Correction::Repaired => reweight::repaired(value, weighted(w, ambients), length),
        }
    }
}

/// A shader with its options.
#[derive(Clone, Debug)]
pub enum Shading<T, const C: usize> {
    /// Without corrections.
    Plain(Plain<T, C>),
    /// With some.
    Corrected(Corrected<T, C>),
}

impl<T: Constant, const C: usize> Shading<T, C> {
    /// The shader of `shade` for the triangles of `frame`, in the channels that are shaded.
    #[must_use]
    pub fn new(frame: &Frame, shade: &Shade, channels: Channels) -> Self {
        let plain = Plain::new(frame, shade, channels);
        match (shade.vertex, shade.reweight) {
            (Correction::Off, Correction::Off) => Shading::Plain(plain),
            _ => Shading::Corrected(Corrected::new(frame, shade, channels, plain)),
        }
    }
}

impl<T: Constant, const C: usize> Spread<T, C> for Shading<T, C> {
    #[inline(always)]
    fn light<N: Number<Constant = T>>(&self, triangle: usize, w: [N; 3], gouraud: [N; C]) -> [N; C] {
        match self {
            Shading::Plain(plain) => plain.light(triangle, w, gouraud),
            Shading::Corrected(corrected) => corrected.light(triangle, w, gouraud),
        }
    }
}
