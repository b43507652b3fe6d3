//! Light that is constant or a polynomial over a triangle.

use glam::DVec3;

use crate::shading::frame::Frame;

/// For each corner, the other two, in order.
pub const OTHERS: [(usize, usize); 3] = [(1, 2), (2, 0), (0, 1)];

/// Returns Σ w_k·values_k.
#[inline]
pub fn weighted(w: [f64; 3], values: [DVec3; 3]) -> DVec3 {
    w[0] * values[0] + w[1] * values[1] + w[2] * values[2]
}

/// One light value per triangle: the light at its centroid, with the normal of the face. Shoaff §3.4.
pub fn flat(frame: &Frame, triangle: usize) -> DVec3 {
    let [a, b, c] = frame.corners(triangle).map(|v| v.eye);
    frame.lit((a + b + c) / 3.0, (b - a).cross(c - a).normalize_or_zero())
}

/// Quadratic light after Mohamed et al., whose shader uses three additional samples of the light per triangle: through
/// the light values of the corners and M_k of the midpoints of the edges, where M_k is opposite corner k. It is Gouraud's
/// light plus Σ_k w_i·w_j·4(M_k − (I_i + I_j)/2).
pub fn quadratic(bulges: &[DVec3; 3], w: [f64; 3], gouraud: DVec3) -> DVec3 {
    OTHERS.iter().zip(bulges).fold(gouraud, |light, (&(i, j), bulge)| light + w[i] * w[j] * bulge)
}

/// Returns 4(M_k − (I_i + I_j)/2) of each edge of `triangle`, where M_k is lit as `phong` would light it. Both
/// triangles at an edge get the same values.
pub fn bulges(frame: &Frame, triangle: usize) -> [DVec3; 3] {
    let corners = frame.corners(triangle);
    OTHERS.map(|(i, j)| {
        let place = (corners[i].eye + corners[j].eye) / 2.0;
        let normal = (corners[i].normal + corners[j].normal).normalize_or_zero();
        4.0 * (frame.lit(place, normal) - (corners[i].light + corners[j].light) / 2.0)
    })
}
