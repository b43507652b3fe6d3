//! Bangay's fixed boundary shader, eq. 4, as printed: flattens the light at every edge. It is continuous, and without
//! slope along the line from A at the edge, but not C1 across: those lines bend there. It flattens the edges of linear
//! fields too.

use crate::{
    light::Interpolation,
    shading::boundary::{Intensity, narrowed, others, smallest},
};

/// Bangay eq. 4, J(t) = t·I_n(t/b')·(I_A − I_E) + I_E, in the strip of the smallest weight t (as the text has it; the
/// pseudo-code takes the first below b, which jumps), and [`weighted`](super::gouraud::weighted) elsewhere.
#[must_use]
pub fn fixed<V: Intensity>(w: [f64; 3], lights: [V; 3], b: f64, step: &Interpolation) -> V {
    let (k, t) = smallest(w);
    if t < b { in_strip(k, w, lights, b, step) } else { super::gouraud::weighted(w, lights) }
}

/// Bangay eq. 4 at a point of the strip opposite corner `k`.
#[must_use]
pub fn in_strip<V: Intensity>(k: usize, w: [f64; 3], lights: [V; 3], b: f64, step: &Interpolation) -> V {
    let on_edge = on_edge(k, w, lights);
    on_edge + (lights[k] - on_edge) * (w[k] * step.value(across(k, w, b)))
}

/// I_E: the light where the line from corner `k` through the point meets the edge. Bangay eq. 3.
pub(super) fn on_edge<V: Intensity>(k: usize, w: [f64; 3], lights: [V; 3]) -> V {
    let (i, j) = others(k);
    (lights[i] * w[i] + lights[j] * w[j]) * (1.0 / (1.0 - w[k]))
}

/// t/b': how far across the strip; 0 at the corners, where the strip has no width.
pub(super) fn across(k: usize, w: [f64; 3], b: f64) -> f64 {
    let width = narrowed(k, w, b);
    if width > 0.0 { w[k] / width } else { 0.0 }
}
