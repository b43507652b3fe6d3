//! One light a triangle. Shoaff §3.4.

use glam::DVec3;

use crate::shading::frame::Frame;

/// The light of `triangle`: that at its middle, with the normal of the face.
#[must_use]
pub fn light(frame: &Frame, triangle: usize) -> DVec3 {
    let [a, b, c] = frame.corners(triangle).map(|v| v.eye);
    let middle = (a + b + c) / 3.0;
    frame.lit(middle, frame.triangles[triangle].normal)
}
