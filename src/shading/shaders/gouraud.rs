//! The trait of all shaders, and the simplest shader: light interpolated between the vertices.

use crate::shading::number::{Constant, Number};

/// A shader: spreads light over the triangles of a frame, in `C` channels. T is the precision of its constants.
pub trait ShaderKernel<T: Constant, const C: usize>: Send + Sync {
    /// Returns the light at the point where the corners of triangle `triangle` have the weights `w` on the screen;
    /// `gouraud` is w_A·I_A + w_B·I_B + w_C·I_C at that point.
    fn light<N: Number<Constant = T>>(&self, triangle: usize, w: [N; 3], gouraud: [N; C]) -> [N; C];
}

/// Bangay eq. 2: L = w_A·I_A + w_B·I_B + w_C·I_C.
#[derive(Clone, Copy, Debug)]
pub struct Gouraud;

impl<T: Constant, const C: usize> ShaderKernel<T, C> for Gouraud {
    #[inline(always)]
    fn light<N: Number<Constant = T>>(&self, _: usize, _: [N; 3], gouraud: [N; C]) -> [N; C] {
        gouraud
    }
}
