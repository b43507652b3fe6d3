//! Bangay's shaders with strips at the edges of triangles (§4), and the corrections of interpolated light: vertex shading
//! (§4.3), which turns the contours around a vertex from polygons into arcs, and intensity reweighting (§4.4), which
//! compensates for interpolated normals, because these are shorter than unit length between vertices.
//!
//! The corners are A, B, C; the edge opposite A runs from B to C. All positions are positions on the **screen**: the
//! weights are affine there, and slopes matched elsewhere would not match in the picture.

use glam::DVec3;

use super::{
    interpolated::{OTHERS, weighted},
    shade::{Correction, Shade},
};
use crate::{
    light::{Depth, TANH_K},
    shading::frame::Frame,
};

/// The width used for strips of zero width, to avoid dividing by zero.
const MIN_WIDTH: f64 = 1e-30;

/// Returns the smallest of the weights.
fn least(w: [f64; 3]) -> f64 {
    w[0].min(w[1]).min(w[2])
}

/// Returns the width of the strip of the smallest weight, narrowed toward the corners as in Bangay's pseudocode:
/// `min(b, (1−w_i)/2, (1−w_j)/2)`. It has a kink at w = 1 − 2b.
fn narrowed(w: [f64; 3], b: f64) -> f64 {
    b.min((1.0 - w[0].max(w[1]).max(w[2])) * 0.5)
}

/// I_n across a strip.
///
/// The printed tanh for n = ∞ misses 0 and 1 by 0.0067. The repaired vertex shading must reach both, so that it begins
/// and ends without a step; for it, the tanh is stretched: `(T(u) − T(0))/(1 − 2T(0))`, with T(u) = (1 + tanh(5(u −
/// ½)))/2.
#[derive(Clone, Copy, Debug)]
pub struct Curve {
    depth: Depth,
    /// T(0), what the curve misses of 0 and 1; as printed, 0.
    missing: f64,
}

impl Curve {
    /// Makes the curve of depth `depth` that reaches 0 and 1.
    pub fn new(depth: Depth) -> Self {
        Curve { depth, missing: depth.interpolation(0.0, TANH_K) }
    }

    /// Makes the curve of depth `depth` as Bangay prints it.
    pub fn printed(depth: Depth) -> Self {
        Curve { missing: 0.0, ..Curve::new(depth) }
    }

    /// Returns I_n(u): 0 for u ≤ 0, 1 for u ≥ 1, except that the printed curve of n = ∞ is not 0 at u = 0.
    pub fn value(&self, u: f64) -> f64 {
        ((self.depth.interpolation(u, TANH_K) - self.missing) / (1.0 - 2.0 * self.missing)).clamp(0.0, 1.0)
    }
}

/// Bangay's boundary shaders: in the strip of the smallest weight t,
/// J(t) = I_E + t·I_n(t/b')·(I_A − I_E) + t·I_n((b'−t)/b')·slope, and elsewhere Gouraud's light. This follows the text of the paper; its pseudocode uses the first weight below b,
/// which makes the light jump.
///
/// The fixed shader, eq. 4, has no slope: it flattens the light at every edge, also that of linear fields. The light is
/// continuous and, at the edge, has no slope along the line from A. It is not C1 across the edge because these lines bend
/// there. The second shader, §4.2.1, is intended to give the light at an edge a slope between the slopes of the two
/// triangles; at an edge without a neighbor, it is the fixed one.
pub struct Strips<'f> {
    pub frame: &'f Frame,
    /// b, the width of the strips.
    pub strip: f64,
    /// I_n as printed.
    pub step: Curve,
    pub slope: Slope,
}

/// The slope of the light at an edge.
pub enum Slope {
    /// 0.
    Fixed,
    /// (I_F − I_E)/2 leaves half of Gouraud's bend at the middle of an edge, and increases the bend elsewhere.
    Printed,
    /// (I_A − I_F)/2 is the mean of the two slopes, which makes the light C1 at the middle of the edges of parallelograms.
    Repaired,
}

impl Strips<'_> {
    /// Returns I_F, the light on the far edge of the neighbor across the edge opposite corner `k`, Bangay eqs. 5 and 6: with
    /// f = 2a/(1+a) from B, or −2a/(1−a) from C if a = 2w_B/(w_B+w_C) − 1 is negative. This is exact only if D is the
    /// reflection of A through the midpoint of the edge.
    fn beyond(&self, triangle: usize, k: usize, w: [f64; 3]) -> Option<DVec3> {
        let neighbor = self.frame.triangles[triangle].across[k]?;
        let apex = self.frame.corners(neighbor.triangle as usize)[neighbor.corner as usize].light;
        let (i, j) = OTHERS[k];
        let a = w[i] * 2.0 / (w[i] + w[j]) - 1.0;
        let size = a.abs();
        let f = size * 2.0 / (size + 1.0);
        Some(self.frame.corners(triangle)[if a < 0.0 { j } else { i }].light * f + (1.0 - f) * apex)
    }

    /// Returns the light at these weights, where Gouraud's is `gouraud`.
    pub fn light(&self, triangle: usize, w: [f64; 3], gouraud: DVec3) -> DVec3 {
        let least = least(w);
        // The first of equal weights.
        let Some(k) = (0..3).find(|k| w[*k] <= least && least.max(0.0) < self.strip) else { return gouraud };
        let (i, j) = OTHERS[k];
        let [a, b, c] = self.frame.corners(triangle);
        let lights = [a.light, b.light, c.light];
        // t/b'; 0 at the corners, where the strip has no width.
        let across = w[k] / narrowed(w, self.strip).max(MIN_WIDTH);
        // I_E, the light where the line from the corner through the point meets the edge. Bangay eq. 3.
        let on_edge = (w[i] * lights[i] + w[j] * lights[j]) * (1.0 / (1.0 - w[k]));
        let fixed = on_edge + (lights[k] - on_edge) * (w[k] * self.step.value(across));
        let slope = match (&self.slope, self.beyond(triangle, k, w)) {
            (Slope::Printed, Some(beyond)) => beyond - on_edge,
            (Slope::Repaired, Some(beyond)) => lights[k] - beyond,
            _ => return fixed,
        };
        fixed + slope * (w[k] * self.step.value(1.0 - across) * 0.5)
    }
}

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
