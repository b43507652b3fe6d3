//! The normal interpolated, and lit at every pixel. Shoaff §3.4.

use glam::DVec3;

use crate::shading::frame::Frame;

/// The light at weights `w` of `triangle`: that of the normalised Σ w_i·N_i at the place Σ w_i·P_i.
#[must_use]
pub fn light(frame: &Frame, triangle: usize, w: [f64; 3]) -> DVec3 {
    let corners = frame.corners(triangle);
    let mix = |of: [DVec3; 3]| of[0] * w[0] + of[1] * w[1] + of[2] * w[2];
    let (place, normal) = (mix(corners.map(|v| v.eye)), mix(corners.map(|v| v.normal)));
    frame.lit(place, normal.normalize_or_zero())
}
