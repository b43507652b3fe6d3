//! Ours: Gouraud's light, with the slope across every edge matched to the neighbour's.

use crate::shading::boundary::{Blend, Intensity};

/// L + Σ_k c_k·w_k·(1 − I_n(w_k/b'_k)), `widths` b' from [`tapered`](crate::shading::boundary::tapered).
///
/// Cⁿ across the whole of an edge for any two triangles; a linear field stays linear (all c are 0). The strip has no
/// net change: its slope runs from +c through −0.69c (n = 2) or −0.78c (n = 3) to 0, a bump of at most 0.27·b·c.
#[must_use]
pub fn exact<V: Intensity>(w: [f64; 3], lights: [V; 3], c: [V; 3], widths: [f64; 3], blend: &Blend) -> V {
    let mut light = super::gouraud::weighted(w, lights);
    for k in 0..3 {
        // At a corner two strips have neither width nor weight.
        if w[k] < widths[k] {
            light = light + c[k] * (w[k] * (1.0 - blend.value(w[k] / widths[k])));
        }
    }
    light
}
