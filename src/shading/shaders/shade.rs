//! A shader and its options.

use crate::{
    light::{Depth, names::named},
    shading::frame::Gradients,
};

named! {
    /// The shaders, from flat to smooth everywhere.
    Shader, ShaderError {
        /// One light per triangle, from its own normal.
        Flat = "flat",
        /// Light interpolated between the vertices, Bangay eq. 2.
        Gouraud = "gouraud",
        /// The normal interpolated between the vertices, with lighting at every pixel.
        Phong = "phong",
        /// Light through the vertices and the middles of the edges, quadratic; after Mohamed et al.
        Quadratic = "quadratic",
        /// Bangay eq. 4, as printed.
        Fixed = "fixed",
        /// Bangay §4.2.1's second expression, as printed.
        Gradient = "gradient",
        /// The same with the sign of its slope repaired, (I_A − I_F)/2.
        GradientRepaired = "gradient-repaired",
        /// Ours: the slope across every edge matched to its neighbor's.
        Exact = "exact",
        /// Ours: the corner at every edge cut.
        Cut = "cut",
        /// Ours: a surface with a continuous slope through the vertices' lights and slopes.
        Patch = "patch",
    }
}

named! {
    /// Whether and how one of Bangay's corrections is made.
    Correction, CorrectionError {
        /// Not made.
        Off = "off",
        /// Made as the paper prints it.
        Printed = "printed",
        /// Made so that a uniform surface stays uniform.
        Repaired = "repaired",
    }
}

/// A shader with its options.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shade {
    /// Which shader.
    pub shader: Shader,
    /// Continuity depth n of the boundary's interpolation.
    pub depth: Depth,
    /// Width b of the strip at an edge, as a barycentric weight: 0…1; up to ⅓ for all but [`Shader::Cut`], for which
    /// larger ones act as ⅓.
    pub boundary: f64,
    /// Vertex shading, Bangay eq. 7.
    pub vertex: Correction,
    /// Intensity reweighting, Bangay eq. 9.
    pub reweight: Correction,
    /// For [`Shader::Patch`].
    pub gradients: Gradients,
}

impl Shader {
    /// Their names, in an error message.
    pub const EXPECTED: &str =
        "one of flat, gouraud, phong, quadratic, fixed, gradient, gradient-repaired, exact, cut, patch";

    /// Whether it interpolates light between the vertices: what corrections correct.
    #[must_use]
    pub const fn interpolates_light(self) -> bool {
        !matches!(self, Shader::Flat | Shader::Phong)
    }
}

impl Shade {
    /// `shader` with n = 1 for *cut*, where it is best, and 3 otherwise; b = ⅓ for *cut*, 0.2 otherwise; no correction.
    #[must_use]
    pub const fn new(shader: Shader) -> Shade {
        let cut = matches!(shader, Shader::Cut);
        Shade {
            shader,
            depth: Depth::Finite(if cut { 1 } else { 3 }),
            boundary: if cut { 1.0 / 3.0 } else { 0.2 },
            vertex: Correction::Off,
            reweight: Correction::Off,
            gradients: Gradients::Curvature,
        }
    }

    /// The width of the strip that is used: `boundary`, at most ⅓ unless the shader is *cut*.
    #[must_use]
    pub fn strip(&self) -> f64 {
        if self.shader == Shader::Cut { self.boundary } else { self.boundary.min(1.0 / 3.0) }
    }

    /// Whether n and b change anything.
    #[must_use]
    pub fn has_strip(&self) -> bool {
        use Shader::{Cut, Exact, Fixed, Gradient, GradientRepaired};
        let corrected = self.vertex != Correction::Off || self.reweight == Correction::Printed;
        matches!(self.shader, Fixed | Gradient | GradientRepaired | Exact | Cut)
            || corrected && self.shader.interpolates_light()
    }
}
