//! Vertex shading, Bangay §4.3: contours around a vertex become arcs instead of polygons.

use glam::DVec2;

use crate::{
    light::Interpolation,
    shading::boundary::{Blend, Intensity, others},
};

/// d_A, Bangay eq. 7: 1 at corner `k`, 0 at the other two, falling with the square of the distance from the corner on
/// the screen; negative beyond. 1 at the corner itself.
///
/// On the screen, because there distances and weights agree about places: a mesh's own distances would bend the
/// contours at edges in perspective.
#[must_use]
pub fn closeness(k: usize, w: [f64; 3], corners: [DVec2; 3]) -> f64 {
    let (i, j) = others(k);
    let (to_i, to_j) = (corners[i] - corners[k], corners[j] - corners[k]);
    let Some(mix) = mix(w[i], w[j]) else { return 1.0 };
    let reach = to_i.length() * mix + to_j.length() * (1.0 - mix);
    // Two corners in one place: no distance to tell them apart.
    if reach > 0.0 { 1.0 - (to_i * w[i] + to_j * w[j]).length_squared() / (reach * reach) } else { 1.0 }
}

/// w_B²/(w_B² + w_C²), by which an edge's value gives way to the other's without slope at either; `None` at the corner.
fn mix(wi: f64, wj: f64) -> Option<f64> {
    let largest = wi.abs().max(wj.abs());
    // Scaled, so that squares of tiny weights do not vanish.
    let (wi, wj) = (wi / largest, wj / largest);
    (largest > 0.0).then(|| wi * wi / (wi * wi + wj * wj))
}

/// As printed: `g·value + (1−g)·d_A·I_A` where w_A > 1 − 2b, g = I_n((1−w_A)/2b); of overlapping regions (b > ¼) the
/// first, with a jump. It darkens a uniform surface around its vertices.
#[must_use]
pub fn printed<V: Intensity>(
    value: V,
    w: [f64; 3],
    lights: [V; 3],
    corners: [DVec2; 3],
    b: f64,
    step: &Interpolation,
) -> V {
    let Some(k) = (0..3).find(|&k| w[k] > 1.0 - 2.0 * b) else { return value };
    let g = step.value((1.0 - w[k]) / (2.0 * b));
    value * g + lights[k] * (closeness(k, w, corners) * (1.0 - g))
}

/// Repaired: the light around a vertex goes to that of its neighbours instead of to darkness, I_V = I_e + d_A(I_A −
/// I_e), I_e mixed from I_B and I_C by squared weights; and it gives way to `value` with ρ = √(1−d_A), which both
/// triangles at an edge share, over the radius 2·min(b, ¼): value + Σ q·(1 − I_n(ρ/radius))·(I_V − value).
///
/// At angles above 120° the radius reaches beyond the opposite edge, where the neighbour knows nothing of it. There
/// q = I_2(4·w_A), which is 1 for w_A ≥ ¼, ends it with the edge.
///
/// Uniform light stays uniform, and C1 across edges stays C1.
#[must_use]
pub fn repaired<V: Intensity>(value: V, w: [f64; 3], lights: [V; 3], corners: [DVec2; 3], b: f64, blend: &Blend) -> V {
    let radius = 2.0 * b.min(0.25);
    let mut corrected = value;
    for k in 0..3 {
        let (i, j) = others(k);
        // At the corner itself the neighbours have no say, however they are mixed.
        let mix = mix(w[i], w[j]).unwrap_or(0.5);
        let d = closeness(k, w, corners);
        let rho = (1.0 - d).max(0.0).sqrt();
        if rho < radius {
            let around = lights[i] * mix + lights[j] * (1.0 - mix);
            let arc = around + (lights[k] - around) * d;
            corrected = corrected + (arc - value) * (confined(w[k]) * (1.0 - blend.value(rho / radius)));
        }
    }
    corrected
}

/// q: 1 from w_A = ¼, 0 with no slope at w_A = 0.
fn confined(w: f64) -> f64 {
    let u = (4.0 * w).clamp(0.0, 1.0);
    u * u * (3.0 - 2.0 * u)
}
