//! Bangay's corrections of interpolated light: vertex shading (§4.3), which turns the contours around a vertex from
//! polygons into arcs, and intensity reweighting (§4.4), which compensates for interpolated normals, because these are
//! shorter than unit length between vertices.

use glam::DVec3;

use super::{
    interpolated::{OTHERS, weighted},
    shade::{Correction, Shade},
    strips::{Curve, MIN_WIDTH, least, narrowed},
};
use crate::shading::frame::Frame;

/// Bangay's corrections, prepared for a frame.
pub struct Corrections<'f> {
    frame: &'f Frame,
    vertex: Correction,
    reweight: Correction,
    /// The width of the strips.
    strip: f64,
    printed: Curve,
    curve: Curve,
}

/// The minimum |N| by which light is divided.
const MIN_NORMAL_LENGTH: f64 = 1e-3;

impl<'f> Corrections<'f> {
    /// Prepares the corrections of `shade` for the triangles of `frame`.
    pub fn new(frame: &'f Frame, shade: &Shade) -> Self {
        Corrections {
            frame,
            vertex: shade.vertex,
            reweight: shade.reweight,
            strip: shade.strip(),
            printed: Curve::printed(shade.depth),
            curve: Curve::new(shade.depth),
        }
    }

    /// Corrects `value`, the light at the weights `w` of `triangle`.
    pub fn corrected(&self, triangle: usize, w: [f64; 3], value: DVec3) -> DVec3 {
        let value = match self.vertex {
            Correction::Off => value,
            Correction::Printed => self.vertex_printed(triangle, w, value),
            Correction::Repaired => self.vertex_repaired(triangle, w, value),
        };
        let length = weighted(w, self.frame.corners(triangle).map(|v| v.normal)).length();
        match self.reweight {
            Correction::Off => value,
            Correction::Printed => value * self.brightening_printed(w, length),
            Correction::Repaired => {
                // I_amb + (value − I_amb)/max(|N|, 1e-3) over the whole triangle.
                let ambient = self.frame.lighting.ambient_light();
                ambient + (value - ambient) * (1.0 / length.max(MIN_NORMAL_LENGTH))
            }
        }
    }

    /// Returns d_A, Bangay eq. 7, and the mix w_B²/(w_B² + w_C²). d_A is 1 at corner `k` and 0 at the other two; it
    /// falls with the square of the distance from the corner on the screen and is negative beyond. The mix blends from
    /// one edge's value to the other's with zero slope at both edges; at the corner, it is ½.
    ///
    /// Distances are measured on the screen because they are consistent with the weights there: in perspective,
    /// distances on the mesh would bend the contours at edges.
    fn closeness(&self, triangle: usize, k: usize, w: [f64; 3]) -> (f64, f64) {
        let (i, j) = OTHERS[k];
        let corners = self.frame.corners(triangle);
        let [to_i, to_j] = [i, j].map(|other| corners[other].screen - corners[k].screen);
        // The weights are scaled so that the squares of tiny weights do not vanish.
        let largest = w[i].abs().max(w[j].abs());
        let (wi, wj) = (w[i] / largest, w[j] / largest);
        let mix = if largest > 0.0 { wi * wi / (wi * wi + wj * wj) } else { 0.5 };
        let reach = mix * to_i.length() + (1.0 - mix) * to_j.length();
        // If `reach` is 0, corners coincide, and no distance separates them.
        let far = if reach > 0.0 { (w[i] * to_i + w[j] * to_j).length_squared() / (reach * reach) } else { 0.0 };
        (1.0 - far, mix)
    }

    /// As printed: `g·value + (1−g)·d_A·I_A` where w_A > 1 − 2b, with g = I_n((1−w_A)/2b). Where regions overlap (b >
    /// ¼), the first one applies, with a jump. The correction darkens a uniform surface around its vertices.
    fn vertex_printed(&self, triangle: usize, w: [f64; 3], value: DVec3) -> DVec3 {
        let Some(k) = (0..3).find(|k| w[*k] > 1.0 - 2.0 * self.strip) else { return value };
        let g = self.printed.value((1.0 - w[k]) * (0.5 / self.strip));
        value * g + self.closeness(triangle, k, w).0 * (1.0 - g) * self.frame.corners(triangle)[k].light
    }

    /// Repaired: the light around a vertex approaches its neighbors' light instead of darkness: I_V = I_e + d_A(I_A −
    /// I_e), where I_e is mixed from I_B and I_C by squared weights. Over the radius 2·min(b, ¼), it blends into
    /// `value` with ρ = √(1−d_A), which both triangles at an edge share: value + Σ q·(1 − I_n(ρ/radius))·(I_V − value).
    ///
    /// At angles above 120°, the radius reaches beyond the opposite edge, where the neighbor does not continue the
    /// correction. The factor q = I_2(4·w_A), which is 1 for w_A ≥ ¼, ends it at the edge.
    ///
    /// Uniform light stays uniform, and C1 across edges stays C1.
    fn vertex_repaired(&self, triangle: usize, w: [f64; 3], value: DVec3) -> DVec3 {
        let lights = self.frame.corners(triangle).map(|v| v.light);
        let radius = 2.0 * self.strip.min(0.25);
        let mut corrected = value;
        for k in 0..3 {
            let (i, j) = OTHERS[k];
            let (closeness, mix) = self.closeness(triangle, k, w);
            let rho = (1.0 - closeness).max(0.0).sqrt();
            if rho < radius {
                let u = (w[k] * 4.0).clamp(0.0, 1.0);
                let confined = u * u * (3.0 - u * 2.0);
                let share = confined * (1.0 - self.curve.value(rho * (1.0 / radius)));
                let around = mix * lights[i] + (1.0 - mix) * lights[j];
                let arc = around + (lights[k] - around) * closeness;
                corrected += (arc - value) * share;
            }
        }
        corrected
    }

    /// Returns the factor of Bangay eq. 9 as printed: 1/(|N| + (1−|N|)·I_n(t/b')), where |N| = `normal` is the length of
    /// Σ w_i·N_i and t is the smallest weight. It brightens only the strips, but it also brightens their ambient light. The
    /// divisor is at least 1e-3.
    fn brightening_printed(&self, w: [f64; 3], normal: f64) -> f64 {
        let (t, width) = (least(w), narrowed(w, self.strip));
        let inside = if t < width { self.printed.value(t / width.max(MIN_WIDTH)) } else { 1.0 };
        1.0 / (normal + (1.0 - normal) * inside).max(MIN_NORMAL_LENGTH)
    }
}
