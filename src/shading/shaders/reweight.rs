//! Intensity reweighting, Bangay §4.4: makes up for the interpolated normal, which is short between vertices.

use crate::{
    light::Interpolation,
    shading::boundary::{Intensity, narrowed, smallest},
};

/// Least |N| by which light is divided.
pub const LEAST_NORMAL: f64 = 1e-3;

/// Bangay eq. 9 as printed: value/(|N| + (1−|N|)·I_n(t/b')), |N| the length `normal` of Σ w_i·N_i, t the smallest
/// weight. It brightens the strips only, and the ambient light too. Also divides by no less than [`LEAST_NORMAL`].
#[must_use]
pub fn printed<V: Intensity>(value: V, w: [f64; 3], normal: f64, b: f64, step: &Interpolation) -> V {
    let (k, t) = smallest(w);
    let width = narrowed(k, w, b);
    let inside = if t < width { step.value(t / width) } else { 1.0 };
    value * (1.0 / (normal + (1.0 - normal) * inside).max(LEAST_NORMAL))
}

/// Repaired: I_amb + (value − I_amb)/max(|N|, [`LEAST_NORMAL`]), over the whole triangle.
#[must_use]
pub fn repaired<V: Intensity>(value: V, ambient: V, normal: f64) -> V {
    ambient + (value - ambient) * (1.0 / normal.max(LEAST_NORMAL))
}
