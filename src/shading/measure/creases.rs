//! Measures the creases at edges that two triangles share, and whether the light has a unique slope at each vertex.

use glam::DVec3;
use rayon::prelude::*;

use crate::{
    shading::{
        frame::Frame,
        shaders::{Shade, Shading},
    },
    system::checkpoint,
};

/// The crease at one edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EdgeCrease {
    /// The edge's length on the screen in pixels.
    pub length: f64,
    /// The jump of the slope normal to the edge, in linear light per pixel: the root mean square along the edge and
    /// over red, green and blue.
    pub jump: f64,
    /// The jump of the light itself, averaged in the same way: 0 for a continuous shader.
    pub step: f64,
}

/// The creases at all edges that two triangles facing the eye share smoothly. Edges are weighted by their length, so
/// splitting an edge into pieces makes no difference.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Creases {
    /// The crease at each edge.
    pub edges: Vec<EdgeCrease>,
    /// Root mean square jump of the slope, in linear light per pixel.
    pub rms: f64,
    /// The jump that half of the total edge length does not exceed, in linear light per pixel. Narrow triangles near
    /// silhouettes dominate the rms; the median is typical of most edges.
    pub median: f64,
    /// The jump that 95 % of the total edge length does not exceed, in linear light per pixel.
    pub p95: f64,
    /// The largest jump, in linear light per pixel.
    pub max: f64,
    /// Root mean square jump of the light itself, in linear light.
    pub step_rms: f64,
}

impl Creases {
    /// Measures the creases of `frame` under a shader. `light(triangle, weights)` must return the light of triangle
    /// `triangle` of the frame at these barycentric weights, which are all at least 0. Steps from the edge change no
    /// weight by more than the share `step`, 0…1, of the smaller weight there.
    pub fn of_field(frame: &Frame, step: f64, light: impl Fn(usize, [f64; 3]) -> DVec3 + Sync) -> Creases {
        let shared: Vec<_> = frame.shared_edges().collect();
        let measured = |sides| {
            checkpoint();
            measured(frame, sides, step, &light)
        };
        let edges: Vec<EdgeCrease> = shared.into_par_iter().map(measured).collect();
        let length: f64 = edges.iter().map(|e| e.length).sum();
        if length <= 0.0 {
            return Creases { edges, ..Creases::default() };
        }
        let rms =
            |of: fn(&EdgeCrease) -> f64| (edges.iter().map(|e| e.length * of(e) * of(e)).sum::<f64>() / length).sqrt();
        let mut sorted: Vec<&EdgeCrease> = edges.iter().collect();
        sorted.sort_by(|a, b| a.jump.total_cmp(&b.jump));
        let max = sorted.last().map_or(0.0, |last| last.jump);
        let at_most = |share: f64| {
            let mut below = 0.0;
            let reached = sorted.iter().find(|edge| {
                below += edge.length;
                below >= share * length
            });
            reached.map_or(max, |edge| edge.jump)
        };
        let (median, p95) = (at_most(0.5), at_most(0.95));
        Creases { rms: rms(|e| e.jump), step_rms: rms(|e| e.step), median, p95, max, edges }
    }

    /// Measures the creases that `shade` leaves in `frame`.
    pub fn of(frame: &Frame, shade: &Shade) -> Creases {
        let shading = Shading::new(frame, shade);
        // The step must be much smaller than the strips. Below b = 1e-6, rounding would dominate.
        let step = if shade.boundary > 0.0 { STEP.min(shade.strip() * 1e-2).max(1e-8) } else { STEP };
        Creases::of_field(frame, step, |triangle, weights| shading.light(triangle, weights))
    }
}

/// The number of points along an edge at which the slopes are compared.
const POINTS: usize = 6;

/// The largest change of a barycentric weight in a step, relative to the smaller weight at the edge. Strips are many
/// such steps wide, and rounding errors are still ten digits below the slope.
const STEP: f64 = 1e-5;

/// The largest jump that rounding produces in a field without creases, in linear light per pixel.
pub const NOISE: f64 = 1e-9;

/// Measures the crease at the edge between two triangles, each given with its corner opposite the edge.
fn measured(
    frame: &Frame,
    sides: [(usize, usize); 2],
    step: f64,
    light: &impl Fn(usize, [f64; 3]) -> DVec3,
) -> EdgeCrease {
    let (mut jump2, mut step2) = (0.0, 0.0);
    for point in 0..POINTS {
        let s = (point as f64 + 0.5) / POINTS as f64;
        // The two triangles traverse the edge in opposite directions.
        let [own, theirs] =
            [(sides[0], s), (sides[1], 1.0 - s)].map(|(side, s)| one_sided(frame, side, s, step, light));
        step2 += (own.0 - theirs.0).length_squared();
        // Each slope points into its own triangle. The directions are opposite, so the sum of the slopes is the jump.
        jump2 += (own.1 + theirs.1).length_squared();
    }
    let samples = (3 * POINTS) as f64;
    let (t, k) = sides[0];
    let [a, b] = [1, 2].map(|i| frame.corners(t)[(k + i) % 3].screen);
    EdgeCrease { length: a.distance(b), jump: (jump2 / samples).sqrt(), step: (step2 / samples).sqrt() }
}

/// Returns the light, and its slope normal to the edge opposite corner `k` into triangle `t`, at the point that divides
/// the edge s : 1 − s.
fn one_sided(
    frame: &Frame,
    (t, k): (usize, usize),
    s: f64,
    step: f64,
    light: &impl Fn(usize, [f64; 3]) -> DVec3,
) -> (DVec3, DVec3) {
    let (i, j) = ((k + 1) % 3, (k + 2) % 3);
    let corners = frame.corners(t).map(|v| v.screen);
    let (along, up) = (corners[j] - corners[i], corners[k] - corners[i]);
    let foot = up.dot(along) / along.length_squared();
    let height = along.perp_dot(up).abs() / along.length();
    // Per pixel along the normal, w_k grows by 1/height; the position of its foot determines how much each of the other
    // weights falls.
    let rates = (-(1.0 - foot) / height, -foot / height);
    let fastest = rates.0.abs().max(rates.1.abs()).max(1.0 / height);
    let h = step * s.min(1.0 - s) / fastest;
    let at = |steps: f64| {
        let mut w = [0.0; 3];
        w[k] = steps * h / height;
        w[i] = (1.0 - s) + steps * h * rates.0;
        w[j] = s + steps * h * rates.1;
        light(t, w)
    };
    // The slope of the parabola through three points.
    let here = at(0.0);
    (here, (4.0 * at(1.0) - at(2.0) - 3.0 * here) / (2.0 * h))
}
