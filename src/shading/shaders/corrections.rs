//! Bangay's corrections of interpolated light: vertex shading (§4.3), which turns the contours around a vertex from
//! polygons into arcs, and intensity reweighting (§4.4), which compensates for interpolated normals, because these are
//! shorter than unit length between vertices.

use super::{
    shade::{Correction, Shade},
    strips::{Curve, MIN_WIDTH, OTHERS, least, narrowed},
};
use crate::shading::{
    frame::Frame,
    number::{Channels, Constant, Number, dot, select, weighted},
};

/// Bangay's corrections, prepared for a frame.
#[derive(Clone, Debug)]
pub struct Corrections<T, const C: usize> {
    vertex: Correction,
    reweight: Correction,
    /// The width of the strips.
    strip: f64,
    printed: Curve<T>,
    curve: Curve<T>,
    fans: Vec<Fans<T, C>>,
    normals: Vec<[[T; 3]; 3]>,
    ambients: Vec<[[T; C]; 3]>,
}

impl<T: Constant, const C: usize> Corrections<T, C> {
    /// Prepares the corrections of `shade` for the triangles of `frame`.
    pub fn new(frame: &Frame, shade: &Shade, channels: Channels) -> Self {
        Corrections {
            vertex: shade.vertex,
            reweight: shade.reweight,
            strip: shade.strip(),
            printed: Curve::printed(shade.depth),
            curve: Curve::new(shade.depth),
            fans: frame.each_triangle(|t| Fans::new(frame, t, channels)),
            normals: frame.corner_vectors(|v| v.normal),
            ambients: frame.each_triangle(|t| frame.corners(t).map(|v| channels.pick(v.ambient))),
        }
    }

    /// Corrects `value`, the light at the weights `w` of `triangle`.
    #[inline(always)]
    pub fn corrected<N: Number<Constant = T>>(&self, triangle: usize, w: [N; 3], value: [N; C]) -> [N; C] {
        let value = match self.vertex {
            Correction::Off => value,
            Correction::Printed => self.fans[triangle].printed(value, w, self.strip, &self.printed),
            Correction::Repaired => self.fans[triangle].repaired(value, w, self.strip, &self.curve),
        };
        let normal = weighted(w, &self.normals[triangle]);
        let length = dot(normal, normal).sqrt();
        match self.reweight {
            Correction::Off => value,
            Correction::Printed => reweight_printed(value, w, length, T::of(self.strip), &self.printed),
            Correction::Repaired => reweight_repaired(value, weighted(w, &self.ambients[triangle]), length),
        }
    }
}

/// The data of a triangle for vertex shading: at each corner, the steps to the other two corners on the screen, and the
/// light values.
#[derive(Clone, Debug)]
struct Fans<T, const C: usize> {
    steps: [[Step<T>; 2]; 3],
    lights: [[T; C]; 3],
}

/// From one corner to another: pixels to the right, pixels down, and the distance.
type Step<T> = [T; 3];

impl<T: Constant, const C: usize> Fans<T, C> {
    /// Computes the data of triangle `triangle`.
    fn new(frame: &Frame, triangle: usize, channels: Channels) -> Self {
        let corners = frame.corners(triangle);
        let step = |from: usize, to: usize| {
            let step = corners[to].screen - corners[from].screen;
            [step.x, step.y, step.length()].map(T::of)
        };
        Fans {
            steps: [0, 1, 2].map(|k| [step(k, OTHERS[k].0), step(k, OTHERS[k].1)]),
            lights: corners.map(|v| channels.pick(v.light)),
        }
    }

    /// Returns d_A, Bangay eq. 7, and the mix w_B²/(w_B² + w_C²). d_A is 1 at corner `k` and 0 at the other two; it
    /// falls with the square of the distance from the corner on the screen and is negative beyond. The mix blends from
    /// one edge's value to the other's with zero slope at both edges; at the corner, it is ½.
    ///
    /// Distances are measured on the screen because they are consistent with the weights there: in perspective,
    /// distances on the mesh would bend the contours at edges.
    #[inline(always)]
    fn closeness<N: Number<Constant = T>>(&self, k: usize, w: [N; 3]) -> (N, N) {
        let (i, j) = OTHERS[k];
        let [to_i, to_j] = &self.steps[k];
        let (zero, one) = (w[k].of(0.0), w[k].of(1.0));
        // The weights are scaled so that the squares of tiny weights do not vanish.
        let largest = w[i].max(zero - w[i]).max(w[j].max(zero - w[j]));
        let (wi, wj) = (w[i] / largest, w[j] / largest);
        let mix = N::select(zero.below(largest), wi * wi / (wi * wi + wj * wj), w[k].of(0.5));
        let reach = mix.times(to_i[2]) + (one - mix).times(to_j[2]);
        let place = [w[i].times(to_i[0]) + w[j].times(to_j[0]), w[i].times(to_i[1]) + w[j].times(to_j[1]), zero];
        // If `reach` is 0, corners coincide, and no distance separates them.
        let far = N::select(zero.below(reach), dot(place, place) / (reach * reach), zero);
        (one - far, mix)
    }

    /// As printed: `g·value + (1−g)·d_A·I_A` where w_A > 1 − 2b, with g = I_n((1−w_A)/2b). Where regions overlap (b >
    /// ¼), the first one applies, with a jump. The correction darkens a uniform surface around its vertices.
    #[inline(always)]
    fn printed<N: Number<Constant = T>>(&self, value: [N; C], w: [N; 3], b: f64, step: &Curve<T>) -> [N; C] {
        let one = w[0].of(1.0);
        let mut corrected = value;
        // The first corner comes last, so it takes precedence.
        for k in [2, 1, 0] {
            let here = one.of(1.0 - 2.0 * b).below(w[k]);
            if N::any(here) {
                let g = step.value((one - w[k]) * one.of(0.5 / b));
                let fall = self.closeness(k, w).0 * (one - g);
                let mut arc = value;
                for c in 0..C {
                    arc[c] = value[c] * g + fall.times(self.lights[k][c]);
                }
                corrected = select(here, arc, corrected);
            }
        }
        corrected
    }

    /// Repaired: the light around a vertex approaches its neighbors' light instead of darkness: I_V = I_e + d_A(I_A −
    /// I_e), where I_e is mixed from I_B and I_C by squared weights. Over the radius 2·min(b, ¼), it blends into
    /// `value` with ρ = √(1−d_A), which both triangles at an edge share: value + Σ q·(1 − I_n(ρ/radius))·(I_V − value).
    ///
    /// At angles above 120°, the radius reaches beyond the opposite edge, where the neighbor does not continue the
    /// correction. The factor q = I_2(4·w_A), which is 1 for w_A ≥ ¼, ends it at the edge.
    ///
    /// Uniform light stays uniform, and C1 across edges stays C1.
    #[inline(always)]
    fn repaired<N: Number<Constant = T>>(&self, value: [N; C], w: [N; 3], b: f64, curve: &Curve<T>) -> [N; C] {
        let (zero, one) = (w[0].of(0.0), w[0].of(1.0));
        let radius = 2.0 * b.min(0.25);
        let mut corrected = value;
        for k in 0..3 {
            let (i, j) = OTHERS[k];
            let (closeness, mix) = self.closeness(k, w);
            let rho = (one - closeness).max(zero).sqrt();
            let here = rho.below(one.of(radius));
            if N::any(here) {
                let u = (w[k] * one.of(4.0)).within(0.0, 1.0);
                let confined = u * u * (one.of(3.0) - u * one.of(2.0));
                let share = confined * (one - curve.value(rho * one.of(1.0 / radius)));
                let share = N::select(here, share, zero);
                for c in 0..C {
                    let around = mix.times(self.lights[i][c]) + (one - mix).times(self.lights[j][c]);
                    let arc = around + (one.all(self.lights[k][c]) - around) * closeness;
                    corrected[c] = corrected[c] + (arc - value[c]) * share;
                }
            }
        }
        corrected
    }
}

/// The minimum |N| by which light is divided.
const MIN_NORMAL_LENGTH: f64 = 1e-3;

/// Bangay eq. 9 as printed: value/(|N| + (1−|N|)·I_n(t/b')), where |N| = `normal` is the length of Σ w_i·N_i and t is
/// the smallest weight. It brightens only the strips, but it also brightens their ambient light. The divisor is at
/// least 1e-3.
#[inline(always)]
fn reweight_printed<N: Number, const C: usize>(
    value: [N; C],
    w: [N; 3],
    normal: N,
    b: N::Constant,
    step: &Curve<N::Constant>,
) -> [N; C] {
    let one = normal.of(1.0);
    let (t, width) = (least(w), narrowed(w, b));
    let inside = N::select(t.below(width), step.value(t / width.max(one.of(MIN_WIDTH))), one);
    let factor = one / (normal + (one - normal) * inside).max(one.of(MIN_NORMAL_LENGTH));
    value.map(|value| value * factor)
}

/// Repaired: I_amb + (value − I_amb)/max(|N|, 1e-3) over the whole triangle.
#[inline(always)]
fn reweight_repaired<N: Number, const C: usize>(value: [N; C], ambient: [N; C], normal: N) -> [N; C] {
    let factor = normal.of(1.0) / normal.max(normal.of(MIN_NORMAL_LENGTH));
    let mut light = value;
    for c in 0..C {
        light[c] = ambient[c] + (value[c] - ambient[c]) * factor;
    }
    light
}
