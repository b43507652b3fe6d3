//! Bangay's second boundary shader, §4.2.1: meant to give the light at an edge the slope between the two triangles'.

use super::fixed;
use crate::{
    light::Interpolation,
    shading::boundary::{Intensity, others, smallest},
};

/// Which slope at the edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sign {
    /// (I_F − I_E)/2: leaves half of Gouraud's bend at the middle of an edge, and bends others more.
    Printed,
    /// (I_A − I_F)/2: the mean of the two slopes, C1 at the middle of the edges of parallelograms.
    Repaired,
}

/// J(t) = t·I_n(t/b')·(I_A − I_E) + t·I_n((b'−t)/b')·slope + I_E in the strip of the smallest weight. `apexes[k]` is
/// the light of the neighbour's vertex D across edge k; at an edge without a neighbour, [`fixed::in_strip`].
#[must_use]
pub fn gradient<V: Intensity>(
    w: [f64; 3],
    lights: [V; 3],
    apexes: [Option<V>; 3],
    sign: Sign,
    b: f64,
    step: &Interpolation,
) -> V {
    let (k, t) = smallest(w);
    if t >= b {
        return super::gouraud::weighted(w, lights);
    }
    let flattened = fixed::in_strip(k, w, lights, b, step);
    let Some(apex) = apexes[k] else { return flattened };
    let beyond = beyond(k, w, lights, apex);
    let slope = match sign {
        Sign::Printed => beyond - fixed::on_edge(k, w, lights),
        Sign::Repaired => lights[k] - beyond,
    };
    flattened + slope * (t * step.value(1.0 - fixed::across(k, w, b)) / 2.0)
}

/// I_F: the light on the neighbour's far edge, Bangay eqs. 5 and 6, with f = 2a/(1+a) from B, or −2a/(1−a) from C if
/// a = 2w_B/(w_B+w_C) − 1 is negative. Exact only where D mirrors A in the middle of the edge.
fn beyond<V: Intensity>(k: usize, w: [f64; 3], lights: [V; 3], apex: V) -> V {
    let (i, j) = others(k);
    let a = 2.0 * w[i] / (w[i] + w[j]) - 1.0;
    let (near, f) = if a < 0.0 { (lights[j], -2.0 * a / (1.0 - a)) } else { (lights[i], 2.0 * a / (1.0 + a)) };
    near * f + apex * (1.0 - f)
}
