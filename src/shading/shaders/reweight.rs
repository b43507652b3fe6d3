//! Intensity reweighting, Bangay §4.4: makes up for the interpolated normal, which is short between vertices.

use super::{
    curve::Curve,
    strips::{NARROWEST, least, narrowed},
};
use crate::shading::number::Number;

/// Least |N| by which light is divided.
const LEAST_NORMAL: f64 = 1e-3;

/// Bangay eq. 9 as printed: value/(|N| + (1−|N|)·I_n(t/b')), |N| the length `normal` of Σ w_i·N_i, t the smallest
/// weight. It brightens the strips only, and the ambient light too. Also divides by no less than 1e-3.
#[inline(always)]
pub fn printed<N: Number, const C: usize>(
    value: [N; C],
    w: [N; 3],
    normal: N,
    b: N::Constant,
    step: &Curve<N::Constant>,
) -> [N; C] {
    let one = normal.of(1.0);
    let (t, width) = (least(w), narrowed(w, b));
    let inside = N::select(t.below(width), step.value(t / width.max(one.of(NARROWEST))), one);
    let factor = one / (normal + (one - normal) * inside).max(one.of(LEAST_NORMAL));
    let mut light = value;
    for c in 0..C {
        light[c] = value[c] * factor;
    }
    light
}

/// Repaired: I_amb + (value − I_amb)/max(|N|, 1e-3), over the whole triangle.
#[inline(always)]
pub fn repaired<N: Number, const C: usize>(value: [N; C], ambient: [N; C], normal: N) -> [N; C] {
    let factor = normal.of(1.0) / normal.max(normal.of(LEAST_NORMAL));
    let mut light = value;
    for c in 0..C {
        light[c] = ambient[c] + (value[c] - ambient[c]) * factor;
    }
    light
}
