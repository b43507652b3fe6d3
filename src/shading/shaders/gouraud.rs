//! Light interpolated between the vertices.

use super::spread::Spread;
use crate::shading::number::{Constant, Number};

/// Bangay eq. 2: L = w_A·I_A + w_B·I_B + w_C·I_C.
#[derive(Clone, Copy, Debug)]
pub struct Gouraud;

impl<T: Constant, const C: usize> Spread<T, C> for Gouraud {
    #[inline(always)]
    fn light<N: Number<Constant = T>>(&self, _: usize, _: [N; 3], gouraud: [N; C]) -> [N; C] {
        gouraud
    }
}
