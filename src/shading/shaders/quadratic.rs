//! Light through the vertices and the middles of the edges; after Mohamed et al., whose shader takes three more samples
//! of the light a triangle.

use glam::DVec3;

use crate::shading::{
    boundary::{Intensity, others},
    frame::Frame,
};

/// The quadratic through the lights of the corners and those of the middles, `middles[k]` opposite corner k:
/// Σ_k w_k(2w_k − 1)·I_k + 4·w_i·w_j·M_k.
#[must_use]
pub fn quadratic<V: Intensity>(w: [f64; 3], lights: [V; 3], middles: [V; 3]) -> V {
    let at = |k: usize| {
        let (i, j) = others(k);
        lights[k] * (w[k] * (2.0 * w[k] - 1.0)) + middles[k] * (4.0 * w[i] * w[j])
    };
    at(0) + at(1) + at(2)
}

/// The lights at the middles of `triangle`'s edges: lit as [`phong`](super::phong) would light them. Both triangles at
/// an edge get the same.
#[must_use]
pub fn middles(frame: &Frame, triangle: usize) -> [DVec3; 3] {
    let corners = frame.corners(triangle);
    [0, 1, 2].map(|k| {
        let (i, j) = others(k);
        let place = (corners[i].eye + corners[j].eye) / 2.0;
        let normal = (corners[i].normal + corners[j].normal).normalize_or_zero();
        frame.lit(place, normal)
    })
}
