//! New in machband: quantities with a continuous slope over the triangles on the screen.
//!
//! Every vertex has a value and a gradient, the slope of the value on the screen. A reduced Clough–Tocher cubic joins
//! them: each triangle is split at its centroid into three parts, each with a cubic, and along an edge the slope across
//! it changes linearly. "Across" is the direction on the surface that is perpendicular to the edge and to the mean
//! normal of its ends, as seen on the screen. Both triangles at an edge find the same direction without knowing each
//! other, and have the same value and slope along the entire edge; all triangles at a vertex have the same value and
//! slope there. Where the curvature of the mesh itself jumps, as between a plane and a rounding, only the values are the
//! same on both sides.
//!
//! Like every smooth curve through given points, the result can slightly exceed the values of the vertices, as a
//! highlight between them does. This overshoot is not limited: limits on the gradients flattened highlights (doubling
//! the error) and did not help elsewhere.
//!
//! With true gradients, fields up to quadratic ones are reproduced exactly; with the gradients of [`Gradients::Ring`],
//! only linear fields are.
//!
//! R. W. Clough & J. L. Tocher 1965; in Bézier form as in G. Farin, *Triangular Bernstein–Bézier patches*, Comput.
//! Aided Geom. Des. 3 (1986) 83.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::{
    gradients::{self, Field, Gradient, Gradients},
    projected::{Frame, FrameVertex},
};
use crate::system::checkpoint;

/// The gradients and cubics of a frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Patches {
    /// The gradient at each of [`Frame::fans`]; zero at fans that belong to no drawn triangle.
    pub gradients: Vec<Gradient>,
    /// The Bézier ordinates of each of [`Frame::triangles`].
    pub control_points: Vec<ControlPoints>,
}

impl Patches {
    /// Computes the cubics of `field` over `frame`, with gradients computed as `gradients` specifies.
    ///
    /// For the light, [`Gradients::Curvature`] requires that the vertices' light values come from the frame's lighting.
    /// A vertex whose light was replaced uses [`Gradients::Ring`] instead.
    #[must_use]
    pub fn new(frame: &Frame, field: Field, gradients: Gradients) -> Patches {
        Patches::with_gradients(frame, field, gradients::of(frame, field, gradients))
    }

    /// Computes the cubics of `field` over `frame` with the given gradients, one for each of [`Frame::fans`]; missing
    /// gradients are zero.
    #[must_use]
    pub fn with_gradients(frame: &Frame, field: Field, mut gradients: Vec<Gradient>) -> Patches {
        gradients.resize(frame.fans.len(), [DVec2::ZERO; 3]);
        let mut control_points: Vec<ControlPoints> = (0..frame.triangles.len())
            .into_par_iter()
            .map(|t| {
                checkpoint();
                let slopes = frame.triangles[t].fans.map(|fan| gradients[fan as usize]);
                let mut points = along_edges(frame.corners(t), field, slopes);
                complete(frame, t, &mut points);
                points
            })
            .collect();
        join_fans(frame, &mut control_points);
        Patches { control_points, gradients }
    }
}

/// Gives the two sides of each edge at which the curvature jumps the same values along the edge: those of the flatter
/// side, to which the edge belongs exactly. The gradients of the two fans need not agree along it: on the rim of a cap,
/// edges are chords that run beside the rounding.
fn join_fans(frame: &Frame, control_points: &mut [ControlPoints]) {
    if frame.fans.len() == frame.vertices.len() {
        return;
    }
    let mut joined = Vec::new();
    for [(t, k), (u, l)] in frame.shared_edges() {
        // The two triangles go along the edge in opposite directions.
        let ends = [[(k + 1) % 3, (l + 2) % 3], [(k + 2) % 3, (l + 1) % 3]];
        if ends.iter().all(|[own, their]| frame.triangles[t].fans[*own] == frame.triangles[u].fans[*their]) {
            continue;
        }
        // From each end, the ordinate toward the next corner comes first, then the one toward the corner before.
        for (order, [own, their]) in ends.into_iter().enumerate() {
            let bend = |fan: u32| frame.fans[fan as usize].curvature.to_cols_array().map(|x| x * x).iter().sum::<f64>();
            let is_flatter = bend(frame.triangles[t].fans[own]) <= bend(frame.triangles[u].fans[their]);
            let [own, their] = [(t, EDGE + 2 * own + order), (u, EDGE + 2 * their + 1 - order)];
            joined.push(if is_flatter { (their, own) } else { (own, their) });
        }
    }
    for ((t, at), (from, theirs)) in &joined {
        control_points[*t][*at] = control_points[*from][*theirs];
    }
    for ((t, _), _) in &joined {
        complete(frame, *t, &mut control_points[*t]);
    }
}

/// The Bézier ordinates of a triangle that is split at its centroid S, for corner i and for edge k opposite corner k:
///
/// | index | ordinate |
/// |---|---|
/// | i | the corner's value |
/// | 3+2i, 4+2i | a third of the way from corner i to corner i+1, to corner i+2 |
/// | 9+i | a third of the way from corner i to S |
/// | 12+k | the middle of the part at edge k |
/// | 15+i | two thirds of the way from corner i to S |
/// | 18 | S |
pub type ControlPoints = [DVec3; 19];

const EDGE: usize = 3;
const NEAR: usize = 9;
const MIDDLE: usize = 12;
const FAR: usize = 15;
const CENTROID: usize = 18;

fn centroid(screen: [DVec2; 3]) -> DVec2 {
    (screen[0] + screen[1] + screen[2]) / 3.0
}

/// Returns the ordinates of a triangle with these corners that lie on its edges, from the values and slopes at the
/// corners.
fn along_edges(corners: [&FrameVertex; 3], field: Field, slopes: [Gradient; 3]) -> ControlPoints {
    let mut b = [DVec3::ZERO; 19];
    for i in 0..3 {
        b[i] = field.at(corners[i]);
        for (place, other) in [(i + 1) % 3, (i + 2) % 3].into_iter().enumerate() {
            b[EDGE + 2 * i + place] = b[i] + along(&slopes[i], corners[other].screen - corners[i].screen) / 3.0;
        }
    }
    b
}

/// Computes the inner ordinates of triangle `t` from those on its edges.
fn complete(frame: &Frame, t: usize, b: &mut ControlPoints) {
    let corners = frame.corners(t);
    let screen = corners.map(|v| v.screen);
    for i in 0..3 {
        b[NEAR + i] = (b[i] + b[EDGE + 2 * i] + b[EDGE + 2 * i + 1]) / 3.0;
    }
    for k in 0..3 {
        let (i, j) = ((k + 1) % 3, (k + 2) % 3);
        let across = across(frame, corners[i], corners[j]);
        b[MIDDLE + k] = middle(b, i, j, crossing(screen[i], screen[j], centroid(screen), across));
    }
    for i in 0..3 {
        b[FAR + i] = (b[NEAR + i] + b[MIDDLE + (i + 1) % 3] + b[MIDDLE + (i + 2) % 3]) / 3.0;
    }
    b[CENTROID] = (b[FAR] + b[FAR + 1] + b[FAR + 2]) / 3.0;
}

/// Returns the ordinate that makes the slope across the edge from corner i to corner j = i+1 linear along the edge. The
/// slope is taken along the line to S that meets the edge at `crossing`. In general it is a quadratic along the edge,
/// so its own middle ordinate must be the mean of its end ordinates.
fn middle(b: &ControlPoints, i: usize, j: usize, crossing: f64) -> DVec3 {
    let (bi, bij, bji, bj) = (b[i], b[EDGE + 2 * i], b[EDGE + 2 * j + 1], b[j]);
    let bends = (1.0 - crossing) * (bij - (bi + bji) / 2.0) + crossing * (bji - (bij + bj) / 2.0);
    (b[NEAR + i] + b[NEAR + j]) / 2.0 + bends
}

/// Returns the direction on the screen in which slopes across the edge from `a` to `b` are taken, of any length: the
/// direction on the surface that is perpendicular to the edge. From `b` to `a`, it is exactly the opposite.
///
/// Any direction on which both sides agree would make the slope continuous. This one meets the edges of thin triangles
/// well inside, whatever the neighbors' shapes; the line between the centroids of the two triangles, used before, runs
/// almost along the edges of slivers, which put ridges on them. The perpendicular on the screen would not follow the
/// foreshortening of the surface, and its light bends by a tenth to a third more near silhouettes.
fn across(frame: &Frame, a: &FrameVertex, b: &FrameVertex) -> DVec2 {
    let on_screen = b.screen - a.screen;
    let across = frame.view.moved((a.eye + b.eye) / 2.0, (a.normal + b.normal).cross(b.eye - a.eye));
    let sine = across.perp_dot(on_screen).abs() / (across.length() * on_screen.length());
    // Near silhouettes, the mean normal can differ so much from the faces' that the direction runs along the edge.
    if sine > MIN_SINE { across } else { on_screen.perp() }
}

/// Returns the point where the line through `centroid` along `across` meets the line from `a` to `b`: 0 at `a`, 1 at
/// `b`.
fn crossing(a: DVec2, b: DVec2, centroid: DVec2, across: DVec2) -> f64 {
    let at = (centroid - a).perp_dot(across) / (b - a).perp_dot(across);
    if at.is_finite() { at } else { 0.5 }
}

/// The smallest sine of the angle between an edge and the direction across it.
const MIN_SINE: f64 = 0.1;

fn along(gradient: &Gradient, step: DVec2) -> DVec3 {
    DVec3::from_array(gradient.map(|g| g.dot(step)))
}

/// Returns the ten Bézier ordinates of the cubic for the part of the triangle where weight `k` is the smallest, row by
/// row from edge k.
///
/// With i = k+1, j = k+2 (mod 3) and u = w_i − w_k, v = w_j − w_k, s = 3·w_k, so that u + v + s = 1, the value is
/// u³b₀ + 3u²v·b₁ + 3uv²·b₂ + v³b₃ + 3s(u²b₄ + 2uv·b₅ + v²b₆) + 3s²(u·b₇ + v·b₈) + s³b₉.
#[must_use]
pub fn sub_triangle_ordinates(b: &ControlPoints, k: usize) -> [DVec3; 10] {
    let (i, j) = ((k + 1) % 3, (k + 2) % 3);
    let row = [i, EDGE + 2 * i, EDGE + 2 * j + 1, j, NEAR + i, MIDDLE + k, NEAR + j, FAR + i, FAR + j, CENTROID];
    row.map(|at| b[at])
}
