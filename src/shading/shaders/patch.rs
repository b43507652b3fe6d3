//! New in machband: light with a continuous slope, determined by the light values and slopes at the vertices. It uses
//! the cubics of [`Patches`]. *c1-phong* uses the same cubics for normals.

use super::gouraud::ShaderKernel;
use crate::shading::{
    frame::{Frame, Patches},
    number::{Channels, Constant, Number},
};

/// The cubic of each triangle: twelve coefficients for each channel, as in [`cubic::value`].
///
/// [`cubic::value`]: crate::shading::cubic::value
#[derive(Clone, Debug)]
pub struct Patch<T, const C: usize>(Vec<[[T; 12]; C]>);

impl<T: Constant, const C: usize> Patch<T, C> {
    /// Prepares the shader for the triangles of `frame`.
    pub fn new(frame: &Frame, channels: Channels, patches: &Patches) -> Self {
        Patch(frame.each_triangle(|t| {
            let picked = patches.coefficients[t].map(|k| channels.pick::<T, C>(k.into()));
            std::array::from_fn(|c| picked.map(|k| k[c]))
        }))
    }
}

impl<T: Constant, const C: usize> ShaderKernel<T, C> for Patch<T, C> {
    #[inline(always)]
    fn light<N: Number<Constant = T>>(&self, triangle: usize, w: [N; 3], gouraud: [N; C]) -> [N; C] {
        let zero = w[0].of(0.0);
        let (x, y) = (w[0] - w[2], w[1] - w[2]);
        // x² where corner 0 has the smallest weight, and y² where corner 1 has it.
        let xx = N::select(x.below(zero) & x.at_most(y), x * x, zero);
        let yy = N::select(y.below(zero) & y.below(x), y * y, zero);
        let (p, q) = (yy * (y - x - x) - xx * y, xx * (x - y - y) - yy * x);
        let mut light = gouraud;
        for (light, k) in light.iter_mut().zip(&self.0[triangle]) {
            let k = k.map(|k| x.all(k));
            let mixed = k[2] + x * (k[4] + x * k[7]) + y * (k[5] + x * k[8] + y * k[9]);
            *light = k[0] + x * (k[1] + x * (k[3] + x * k[6])) + y * mixed + p * k[10] + q * k[11];
        }
        light
    }
}
