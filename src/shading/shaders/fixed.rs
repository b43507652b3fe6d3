//! Bangay's fixed boundary shader, eq. 4, as printed: it flattens the light at every edge. The light is continuous and,
//! at the edge, has no slope along the line from A. It is not C1 across the edge because these lines bend there. The
//! shader flattens the edges of linear fields, too.

use glam::DVec3;

use super::{
    gouraud::ShaderKernel,
    strips::{Curve, MIN_WIDTH, OTHERS, least, narrowed},
};
use crate::{light::Depth, shading::frame::Frame};

/// Bangay eq. 4, J(t) = t·I_n(t/b')·(I_A − I_E) + I_E, in the strip of the smallest weight t, and Gouraud's light
/// elsewhere. This follows the text of the paper; its pseudocode uses the first weight below b, which makes the light
/// jump.
pub struct Fixed<'f> {
    pub(super) frame: &'f Frame,
    strip: f64,
    /// I_n as printed.
    pub(super) step: Curve,
}

/// A point in the strip opposite a corner.
pub(super) struct InStrip {
    /// The relative position across the strip, t/b'; 0 at the corners, where the strip has no width.
    pub across: f64,
    /// I_E, the light where the line from the corner through the point meets the edge. Bangay eq. 3.
    pub on_edge: DVec3,
    /// The light J(t).
    pub light: DVec3,
}

impl<'f> Fixed<'f> {
    /// Prepares the shader for the triangles of `frame`, with strips of width `b`.
    pub fn new(frame: &'f Frame, b: f64, depth: Depth) -> Self {
        Fixed { frame, strip: b, step: Curve::printed(depth) }
    }

    /// Returns the corner opposite whose edge a point is in the strip: the one with the smallest weight, the first of
    /// equal ones. `None` outside the strips.
    pub(super) fn strip(&self, w: [f64; 3]) -> Option<usize> {
        let least = least(w);
        (0..3).find(|k| w[*k] <= least && least < self.strip)
    }

    /// Computes a point in the strip opposite corner `k`.
    pub(super) fn in_strip(&self, triangle: usize, k: usize, w: [f64; 3]) -> InStrip {
        let (i, j) = OTHERS[k];
        let lights = self.frame.corners(triangle).map(|v| v.light);
        let across = w[k] / narrowed(w, self.strip).max(MIN_WIDTH);
        let on_edge = (w[i] * lights[i] + w[j] * lights[j]) * (1.0 / (1.0 - w[k]));
        let light = on_edge + (lights[k] - on_edge) * (w[k] * self.step.value(across));
        InStrip { across, on_edge, light }
    }
}

impl ShaderKernel for Fixed<'_> {
    fn light(&self, triangle: usize, w: [f64; 3], gouraud: DVec3) -> DVec3 {
        self.strip(w).map_or(gouraud, |k| self.in_strip(triangle, k, w).light)
    }
}
