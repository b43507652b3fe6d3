//! A shader and its options.

use crate::{light::Depth, text::names::named};

named! {
    /// The shaders, from flat to smooth everywhere.
    Shader, ShaderError {
        /// One light value per triangle, from its own normal.
        Flat = "flat",
        /// Light interpolated between the vertices, Bangay eq. 2.
        Gouraud = "gouraud",
        /// Normals interpolated between the vertices, with lighting at every pixel.
        Phong = "phong",
        /// Quadratic light through the light values at the vertices and at the midpoints of the edges, after Mohamed et
        /// al.
        Quadratic = "quadratic",
        /// Bangay eq. 4, as printed.
        Fixed = "fixed",
        /// Bangay §4.2.1's second expression, as printed.
        Gradient = "gradient",
        /// Like `gradient`, but with the sign of the slope repaired, (I_A − I_F)/2.
        GradientRepaired = "gradient-repaired",
        /// New in machband: light with a continuous slope, determined by the light values and slopes at the vertices.
        Patch = "patch",
        /// New in machband: Phong's lighting at every pixel, with normals that change with a continuous slope.
        C1Phong = "c1-phong",
    }
}

named! {
    /// Whether and how one of Bangay's corrections is applied.
    Correction, CorrectionError {
        /// The correction is not applied.
        Off = "off",
        /// The correction is applied as printed in the paper.
        Printed = "printed",
        /// The correction is repaired so that a uniform surface stays uniform.
        Repaired = "repaired",
    }
}

/// A shader with its options.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shade {
    /// The shader.
    pub shader: Shader,
    /// Continuity depth n of the interpolation across the strips.
    pub depth: Depth,
    /// Width b of the strip at an edge, as a barycentric weight. Widths above ⅓ act as ⅓.
    pub boundary: f64,
    /// Vertex shading, Bangay eq. 7.
    pub vertex: Correction,
    /// Intensity reweighting, Bangay eq. 9.
    pub reweight: Correction,
}

impl Shader {
    /// True if the shader interpolates light between the vertices, which is what the corrections apply to.
    pub const fn interpolates_light(self) -> bool {
        !matches!(self, Shader::Flat) && !self.lights_pixels()
    }

    /// True if the shader lights every pixel.
    pub const fn lights_pixels(self) -> bool {
        matches!(self, Shader::Phong | Shader::C1Phong)
    }
}

impl Shade {
    /// Returns `shader` with n = 3, b = 0.2 and no corrections.
    pub const fn new(shader: Shader) -> Shade {
        Shade { shader, depth: Depth::Finite(3), boundary: 0.2, vertex: Correction::Off, reweight: Correction::Off }
    }

    /// Returns whether this draws the same picture as Gouraud's shader, the baseline for all comparisons. Options that only
    /// other shaders use may differ.
    pub fn is_gouraud(&self) -> bool {
        let Shade { depth, boundary, .. } = *self;
        *self == Shade { depth, boundary, ..Shade::new(Shader::Gouraud) }
    }

    /// Returns the width of the strip that is actually used: `boundary`, but at most ⅓.
    pub fn strip(&self) -> f64 {
        self.boundary.min(1.0 / 3.0)
    }

    /// True if n and b affect the result.
    pub fn has_strip(&self) -> bool {
        use Shader::{Fixed, Gradient, GradientRepaired};
        let corrected = self.vertex != Correction::Off || self.reweight == Correction::Printed;
        matches!(self.shader, Fixed | Gradient | GradientRepaired) || corrected && self.shader.interpolates_light()
    }
}
