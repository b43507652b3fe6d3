//! Bangay's second boundary shader, §4.2.1: it is intended to give the light at an edge a slope between the slopes of
//! the two triangles.

use glam::DVec3;

use super::{fixed::Fixed, gouraud::ShaderKernel, strips::OTHERS};
use crate::{light::Depth, shading::frame::Frame};

/// J(t) = t·I_n(t/b')·(I_A − I_E) + t·I_n((b'−t)/b')·slope + I_E in the strip of the smallest weight. At an edge
/// without a neighbor, it is the light of [`Fixed`].
pub struct Gradient<'f> {
    fixed: Fixed<'f>,
    /// The slope at the edge. As printed, (I_F − I_E)/2 leaves half of Gouraud's bend at the middle of an edge, and
    /// increases the bend elsewhere. Repaired, (I_A − I_F)/2 is the mean of the two slopes, which makes the light C1 at the
    /// middle of the edges of parallelograms.
    is_repaired: bool,
}

impl<'f> Gradient<'f> {
    /// Prepares the shader for the triangles of `frame`, with strips of width `b`.
    pub fn new(frame: &'f Frame, is_repaired: bool, b: f64, depth: Depth) -> Self {
        Gradient { fixed: Fixed::new(frame, b, depth), is_repaired }
    }
}

impl ShaderKernel for Gradient<'_> {
    fn light(&self, triangle: usize, w: [f64; 3], gouraud: DVec3) -> DVec3 {
        let Some(k) = self.fixed.strip(w) else { return gouraud };
        let (strip, frame) = (self.fixed.in_strip(triangle, k, w), self.fixed.frame);
        let Some(neighbor) = frame.triangles[triangle].across[k] else { return strip.light };
        let apex = frame.vertices[neighbor.apex as usize].light;
        let (i, j) = OTHERS[k];
        let lights = frame.corners(triangle).map(|v| v.light);
        // I_F, the light on the neighbor's far edge, Bangay eqs. 5 and 6: with f = 2a/(1+a) from B, or −2a/(1−a) from C
        // if a = 2w_B/(w_B+w_C) − 1 is negative. This is exact only if D is the reflection of A through the midpoint of
        // the edge.
        let a = w[i] * 2.0 / (w[i] + w[j]) - 1.0;
        let size = a.abs();
        let f = size * 2.0 / (size + 1.0);
        let beyond = (if a < 0.0 { lights[j] } else { lights[i] }) * f + (1.0 - f) * apex;
        let slope = if self.is_repaired { lights[k] - beyond } else { beyond - strip.on_edge };
        strip.light + slope * (w[k] * self.fixed.step.value(1.0 - strip.across) * 0.5)
    }
}
