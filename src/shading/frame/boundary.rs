//! The strips at the edges of triangles: how wide they are, how they join the rest, and what each edge must know of
//! both its triangles. Bangay §4.
//!
//! Corners are A, B, C; the edge opposite A runs from B to C and D is the neighbour's apex across it. All places are
//! those on the **screen**: the weights are affine there, and slopes matched elsewhere do not match in the picture.

use std::ops::{Add, Mul, Sub};

use glam::{DVec2, DVec3};

use super::frame::{Across, Frame};
use crate::light::{Depth, Interpolation, interpolation::TANH_K};

/// What can be spread over a triangle: one intensity, or those of red, green and blue.
pub trait Intensity: Copy + Add<Output = Self> + Sub<Output = Self> + Mul<f64, Output = Self> {}

impl<T: Copy + Add<Output = T> + Sub<Output = T> + Mul<f64, Output = T>> Intensity for T {}

/// `(k+1) mod 3` and `(k+2) mod 3`: the other two corners, in order.
#[must_use]
pub const fn others(k: usize) -> (usize, usize) {
    ((k + 1) % 3, (k + 2) % 3)
}

/// The corner with the smallest weight, the first of equal ones, and that weight: the strip in which a point lies,
/// if it lies in one.
#[must_use]
pub fn smallest(w: [f64; 3]) -> (usize, f64) {
    let k = if w[1] < w[0] { 1 } else { 0 };
    let k = if w[2] < w[k] { 2 } else { k };
    (k, w[k])
}

/// The width of strip `k` as Bangay's pseudo-code narrows it towards the corners: `min(b, (1−w_i)/2, (1−w_j)/2)`. It
/// has a kink at w = 1 − 2b.
#[must_use]
pub fn narrowed(k: usize, w: [f64; 3], b: f64) -> f64 {
    let (i, j) = others(k);
    b.min((1.0 - w[i]) / 2.0).min((1.0 - w[j]) / 2.0)
}

/// The width of strip `k` narrowed without a kink: `b·φ((1−w_i)/2b)·φ((1−w_j)/2b)`, φ = [`ease`]. 0 for b = 0.
#[must_use]
pub fn tapered(k: usize, w: [f64; 3], b: f64) -> f64 {
    if b <= 0.0 {
        return 0.0;
    }
    let (i, j) = others(k);
    b * ease((1.0 - w[i]) / (2.0 * b)) * ease((1.0 - w[j]) / (2.0 * b))
}

/// φ(x) = x − x²/4 below 2, where it reaches 1 with slope 0; 1 beyond; 0 for negative x. φ(x) ≤ x.
#[must_use]
pub fn ease(x: f64) -> f64 {
    if x <= 0.0 {
        0.0
    } else if x < 2.0 {
        x - x * x / 4.0
    } else {
        1.0
    }
}

/// I_n for the shaders that promise a continuous slope, and its integral.
///
/// Finite depths are [`Interpolation`] itself. The printed tanh misses 0 and 1 by 0.0067: as it stands, a strip would
/// join neither its edge's slope nor the interior. Here it is stretched to reach both,
/// `(T(u) − T(0))/(1 − 2T(0))`, T(u) = (1 + tanh(5(u − ½)))/2. Then *exact* and *cut* are C1 across an edge for n = ∞
/// as well. The tanh's own slope at the ends, 0.067, stays: *exact* keeps a kink of 0.067·c where its strip ends, *cut*
/// none. (The steeper tanh(10(u − ½)) would leave 0.0009, but double the ripple of the strip.)
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Blend {
    interpolation: Interpolation,
    /// n, or `None` for the stretched tanh.
    order: Option<f64>,
}

impl Blend {
    /// That of depth `depth`.
    #[must_use]
    pub fn new(depth: Depth) -> Blend {
        let order = match depth {
            Depth::Finite(n) => Some(f64::from(n.clamp(1, Depth::MAX_FINITE))),
            Depth::Infinite => None,
        };
        Blend { interpolation: Interpolation::new(depth), order }
    }

    /// I_n(u): 0 for u ≤ 0, 1 for u ≥ 1, continuous.
    #[must_use]
    pub fn value(&self, u: f64) -> f64 {
        if self.order.is_some() {
            return self.interpolation.value(u);
        }
        let residual = self.interpolation.value(0.0);
        if u <= 0.0 {
            0.0
        } else if u >= 1.0 {
            1.0
        } else {
            (self.interpolation.value(u) - residual) / (1.0 - 2.0 * residual)
        }
    }

    /// Ψ_n(u) = ∫ from u to 1 of 1 − I_n: ½ at 0, 0 for u ≥ 1, ½ − u for u < 0.
    ///
    /// With v = 1 − u it is ∫₀ᵛ I_n = (v − ½)·I_n(v) + v(1−v)·I_n'(v)/2n, from the recurrence of the incomplete beta
    /// function; n = 1: v²/2. For ∞ the integral of tanh, a logarithm of cosh.
    #[must_use]
    pub fn rest(&self, u: f64) -> f64 {
        if u >= 1.0 {
            return 0.0;
        }
        if u <= 0.0 {
            return 0.5 - u;
        }
        let v = 1.0 - u;
        match self.order {
            Some(n) => (v - 0.5) * self.interpolation.value(v) + v * u * self.interpolation.slope(v) / (2.0 * n),
            None => {
                // ∫ T = ln(1 + e^(2k(v−½)))/2k
                let primitive = |v: f64| (2.0 * TANH_K * (v - 0.5)).exp().ln_1p() / (2.0 * TANH_K);
                let residual = self.interpolation.value(0.0);
                (primitive(v) - primitive(0.0) - v * residual) / (1.0 - 2.0 * residual)
            }
        }
    }
}

/// Least m of [`EdgeConstants`]: how near to a corner the foot of an apex is taken to be at least, in edge lengths.
const LEAST_REACH: f64 = 1.0 / 16.0;

/// What a triangle must know of one of its edges. Computed once a frame by [`edge_constants`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EdgeConstants<V = DVec3> {
    /// c = I_BC(X) − I_AD(X), X where the lines AD and BC cross on the screen: how far the light at the edge lies above
    /// a straight way from A to D. Raising the slope of the light along w_A by c on both sides makes it one slope. For a
    /// parallelogram (I_B + I_C − I_A − I_D)/2. Equal bit for bit on both sides of an edge; zero where there is nothing
    /// to be smooth with; see [`level`] for [`Across::Several`].
    pub c: V,
    /// s_A: where the perpendicular from the triangle's own apex meets the edge; 0 at corner k+1, 1 at corner k+2.
    pub foot: f64,
    /// m at corner k+1: max(s_A, s_D, 1/16).
    pub start: f64,
    /// m at corner k+2: max(1−s_A, 1−s_D, 1/16).
    pub end: f64,
}

impl<V: Intensity> EdgeConstants<V> {
    /// The width of *cut*'s strip at this edge, of which the triangle's weights are `w[k]` = 0 on it:
    /// `b·φ(σ/(b·m_B))·φ((1−σ)/(b·m_C))`. σ = w_C + w_A·s_A is the point's perpendicular projection on the edge, so the
    /// width does not change perpendicular to the edge, and falls below w_A before the other two edges.
    #[must_use]
    pub fn cut_width(&self, k: usize, w: [f64; 3], b: f64) -> f64 {
        if b <= 0.0 {
            return 0.0;
        }
        let (i, j) = others(k);
        let (from_start, from_end) = (w[j] + w[k] * self.foot, w[i] + w[k] * (1.0 - self.foot));
        b * ease(from_start / (b * self.start)) * ease(from_end / (b * self.end))
    }
}

/// A corner: where it is on the screen, and its light.
pub type Corner<V> = (DVec2, V);

/// Where the perpendicular from `p` meets the line from `b` (0) to `c` (1); 0 if they are one place.
fn foot(p: DVec2, b: DVec2, c: DVec2) -> f64 {
    let along = c - b;
    let length2 = along.length_squared();
    if length2 > 0.0 { (p - b).dot(along) / length2 } else { 0.0 }
}

/// How much lighter the apex is than the edge's line at its foot: a = I_A − I_BC(s_A).
fn excess<V: Intensity>(apex: V, s: f64, b: V, c: V) -> V {
    apex - (b * (1.0 - s) + c * s)
}

/// The constants of the edge from `b` to `c` of the triangle with apex `a`, and of its mirror image, the same edge of
/// the triangle with apex `d`:
/// `c = −(h_D·a_A + h_A·a_D)/(h_A + h_D)`, h the heights over the edge. `None` if either has no height, or they lie on
/// one side.
#[must_use]
pub fn between<V: Intensity>(
    a: Corner<V>,
    b: Corner<V>,
    c: Corner<V>,
    d: Corner<V>,
) -> Option<(EdgeConstants<V>, EdgeConstants<V>)> {
    // Twice the areas: heights in units of the edge.
    let (ha, hd) = (Frame::area2(a.0, b.0, c.0), Frame::area2(d.0, c.0, b.0));
    if !(ha > 0.0 && hd > 0.0) {
        return None;
    }
    let (sa, sd) = (foot(a.0, b.0, c.0), foot(d.0, b.0, c.0));
    let (aa, ad) = (excess(a.1, sa, b.1, c.1), excess(d.1, sd, b.1, c.1));
    let bend = (aa * hd + ad * ha) * (-1.0 / (ha + hd));
    let start = sa.max(sd).max(LEAST_REACH);
    let end = (1.0 - sa).max(1.0 - sd).max(LEAST_REACH);
    Some((
        EdgeConstants { c: bend, foot: sa, start, end },
        EdgeConstants { c: bend, foot: 1.0 - sd, start: end, end: start },
    ))
}

/// The constants of an edge at which every triangle is to arrive with no slope across: `c = I_BC(s_A) − I_A`. What
/// edges of three triangles and more get.
#[must_use]
pub fn level<V: Intensity>(a: Corner<V>, b: Corner<V>, c: Corner<V>) -> EdgeConstants<V> {
    let s = foot(a.0, b.0, c.0);
    let (start, end) = reach(s);
    EdgeConstants { c: excess(a.1, s, b.1, c.1) * -1.0, foot: s, start, end }
}

fn reach(s: f64) -> (f64, f64) {
    (s.max(LEAST_REACH), (1.0 - s).max(LEAST_REACH))
}

/// The constants of every edge of every triangle of `frame`; edge k is opposite corner k. Computed from the side of the
/// triangle that comes first, so that both sides have the same.
#[must_use]
pub fn edge_constants(frame: &Frame) -> Vec<[EdgeConstants; 3]> {
    let corner = |v: u32| (frame.vertices[v as usize].screen, frame.vertices[v as usize].light);
    let mut constants: Vec<[EdgeConstants; 3]> = Vec::with_capacity(frame.triangles.len());
    for triangle in &frame.triangles {
        let corners = triangle.vertices.map(corner);
        constants.push([0, 1, 2].map(|k| {
            let (i, j) = others(k);
            let level = level(corners[k], corners[i], corners[j]);
            match triangle.across[k] {
                Across::Several => level,
                // That across a triangle follows, when both sides are there.
                Across::Nothing | Across::Triangle { .. } => EdgeConstants { c: DVec3::ZERO, ..level },
            }
        }));
    }
    for (t, triangle) in frame.triangles.iter().enumerate() {
        for k in 0..3 {
            let Across::Triangle { triangle: u, apex } = triangle.across[k] else { continue };
            let Some(their_edge) = edge_back(frame, t, u as usize, apex) else { continue };
            let (i, j) = others(k);
            let [a, b, c] = [k, i, j].map(|k| corner(triangle.vertices[k]));
            if t < u as usize
                && let Some((ours, theirs)) = between(a, b, c, corner(apex))
            {
                constants[t][k] = ours;
                constants[u as usize][their_edge] = theirs;
            }
        }
    }
    constants
}

/// Which edge of triangle `u`, opposite its vertex `apex`, has triangle `t` across it.
fn edge_back(frame: &Frame, t: usize, u: usize, apex: u32) -> Option<usize> {
    let theirs = frame.triangles.get(u)?;
    (0..3).find(|&k| {
        theirs.vertices[k] == apex
            && matches!(theirs.across[k], Across::Triangle { triangle, .. } if triangle as usize == t)
    })
}
