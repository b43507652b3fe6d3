//! The trait of all shaders, and the simplest shader: light interpolated between the vertices.

use glam::DVec3;

/// A shader: spreads light over the triangles of a frame.
pub trait ShaderKernel: Send + Sync {
    /// Returns the light at the point where the corners of triangle `triangle` have the weights `w` on the screen;
    /// `gouraud` is w_A·I_A + w_B·I_B + w_C·I_C at that point.
    fn light(&self, triangle: usize, w: [f64; 3], gouraud: DVec3) -> DVec3;
}

/// Bangay eq. 2: L = w_A·I_A + w_B·I_B + w_C·I_C.
pub struct Gouraud;

impl ShaderKernel for Gouraud {
    fn light(&self, _: usize, _: [f64; 3], gouraud: DVec3) -> DVec3 {
        gouraud
    }
}

/// Returns Σ w_k·values_k.
#[inline]
pub fn weighted(w: [f64; 3], values: [DVec3; 3]) -> DVec3 {
    w[0] * values[0] + w[1] * values[1] + w[2] * values[2]
}
