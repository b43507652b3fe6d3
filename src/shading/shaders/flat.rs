//! One light value per triangle. Shoaff §3.4.

use super::gouraud::ShaderKernel;
use crate::shading::{
    frame::Frame,
    number::{Channels, Constant, Number},
};

/// The light of each triangle: the light at its centroid, with the normal of the face.
#[derive(Clone, Debug)]
pub struct Flat<T, const C: usize>(Vec<[T; C]>);

impl<T: Constant, const C: usize> Flat<T, C> {
    /// Prepares the shader for the triangles of `frame`.
    pub fn new(frame: &Frame, channels: Channels) -> Self {
        Flat(frame.each_triangle(|t| {
            let [a, b, c] = frame.corners(t).map(|v| v.eye);
            channels.pick(frame.lit((a + b + c) / 3.0, frame.triangles[t].normal))
        }))
    }
}

impl<T: Constant, const C: usize> ShaderKernel<T, C> for Flat<T, C> {
    #[inline(always)]
    fn light<N: Number<Constant = T>>(&self, triangle: usize, w: [N; 3], _: [N; C]) -> [N; C] {
        self.0[triangle].map(|light| w[0].all(light))
    }
}
