//! New in machband: light with a continuous slope, determined by the light values and slopes at the vertices. It uses
//! the cubics of [`Patches`]. *c1-phong* uses the same cubics for normals.

use glam::DVec3;

use super::gouraud::ShaderKernel;
use crate::shading::{cubic, frame::Patches};

impl ShaderKernel for Patches {
    fn light(&self, triangle: usize, w: [f64; 3], _: DVec3) -> DVec3 {
        cubic::value(&self.coefficients[triangle], w).into()
    }
}
