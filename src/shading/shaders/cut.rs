//! Ours: Gouraud's light, with the corner that it makes at every edge cut off: the slope runs from one side's to the
//! other's without overshoot.

use crate::shading::boundary::{Blend, EdgeConstants, Intensity};

/// L − Σ_k c_k·b'_k·Ψ_n(w_k/b'_k), b' from [`EdgeConstants::cut_width`], Ψ from [`Blend::rest`]. C1 across edges. The
/// light on an edge itself moves by −c·b'/2. b may go to 1; n = 1 is best.
#[must_use]
pub fn cut<V: Intensity>(w: [f64; 3], lights: [V; 3], edges: &[EdgeConstants<V>; 3], b: f64, blend: &Blend) -> V {
    let mut light = super::gouraud::weighted(w, lights);
    for (k, edge) in edges.iter().enumerate() {
        let width = edge.cut_width(k, w, b);
        if w[k] < width {
            light = light - edge.c * (width * blend.rest(w[k] / width));
        }
    }
    light
}
