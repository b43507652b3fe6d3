//! New in machband: light with a continuous slope over the triangles on the screen.
//!
//! Every vertex has a light and a gradient, the slope of the light on the screen. A reduced Clough–Tocher cubic joins
//! them: each triangle is split at its centroid into three parts, each with a cubic, and along an edge the slope toward
//! the neighbor's centroid changes linearly. Both triangles at an edge then have the same light and slope along the
//! entire edge, and all triangles at a vertex have the same light and slope there.
//!
//! Like every smooth curve through given points, the result can slightly exceed the light values of the vertices, as a
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
    gradients::{self, Gradient, Gradients},
    projected::{Across, Frame},
};

/// The gradients and cubics of a frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Patches {
    /// The gradient at each of [`Frame::vertices`]; zero at vertices that belong to no drawn triangle.
    pub gradients: Vec<Gradient>,
    /// The Bézier ordinates of each of [`Frame::triangles`].
    pub control_points: Vec<ControlPoints>,
}

impl Patches {
    /// Computes the cubics of `frame`, with gradients computed as `gradients` specifies.
    ///
    /// [`Gradients::Curvature`] requires that the vertices' light values come from the frame's lighting. A vertex whose
    /// light was replaced uses [`Gradients::Ring`] instead.
    #[must_use]
    pub fn new(frame: &Frame, gradients: Gradients) -> Patches {
        Patches::with_gradients(frame, gradients::of(frame, gradients))
    }

    /// Computes the cubics of `frame` with the given gradients, one for each of [`Frame::vertices`]; missing gradients
    /// are zero.
    #[must_use]
    pub fn with_gradients(frame: &Frame, mut gradients: Vec<Gradient>) -> Patches {
        gradients.resize(frame.vertices.len(), [DVec2::ZERO; 3]);
        let centroids: Vec<DVec2> =
            (0..frame.triangles.len()).map(|t| centroid(frame.corners(t).map(|v| v.screen))).collect();
        let control_points = frame
            .triangles
            .par_iter()
            .enumerate()
            .map(|(t, triangle)| {
                let corners = frame.corners(t);
                let across = triangle.across.map(|across| match across {
                    Across::Triangle { triangle, .. } => Some(centroids[triangle as usize]),
                    Across::Nothing | Across::NonManifold => None,
                });
                control_points(
                    corners.map(|v| v.screen),
                    corners.map(|v| v.light),
                    triangle.vertices.map(|v| gradients[v as usize]),
                    across,
                )
            })
            .collect();
        Patches { gradients, control_points }
    }
}

/// The Bézier ordinates of a triangle that is split at its centroid S, for corner i and for edge k opposite corner k:
///
/// | index | ordinate |
/// |---|---|
/// | i | the corner's light |
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

/// Returns the ordinates of the triangle at `screen` from the light values and gradients at its corners and from the
/// centroids of the triangles across its edges.
fn control_points(
    screen: [DVec2; 3],
    light: [DVec3; 3],
    gradients: [Gradient; 3],
    across: [Option<DVec2>; 3],
) -> ControlPoints {
    let mut b = [DVec3::ZERO; 19];
    for i in 0..3 {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        b[i] = light[i];
        b[EDGE + 2 * i] = light[i] + along(&gradients[i], screen[j] - screen[i]) / 3.0;
        b[EDGE + 2 * i + 1] = light[i] + along(&gradients[i], screen[k] - screen[i]) / 3.0;
        b[NEAR + i] = (b[i] + b[EDGE + 2 * i] + b[EDGE + 2 * i + 1]) / 3.0;
    }
    for k in 0..3 {
        let (i, j) = ((k + 1) % 3, (k + 2) % 3);
        b[MIDDLE + k] = middle(&b, i, j, crossing(screen[i], screen[j], centroid(screen), across[k]));
    }
    for i in 0..3 {
        b[FAR + i] = (b[NEAR + i] + b[MIDDLE + (i + 1) % 3] + b[MIDDLE + (i + 2) % 3]) / 3.0;
    }
    b[CENTROID] = (b[FAR] + b[FAR + 1] + b[FAR + 2]) / 3.0;
    b
}

/// Returns the ordinate that makes the slope across the edge from corner i to corner j = i+1 linear along the edge. The
/// slope is taken along the line to S that meets the edge at `crossing`. In general it is a quadratic along the edge,
/// so its own middle ordinate must be the mean of its end ordinates.
fn middle(b: &ControlPoints, i: usize, j: usize, crossing: f64) -> DVec3 {
    let (bi, bij, bji, bj) = (b[i], b[EDGE + 2 * i], b[EDGE + 2 * j + 1], b[j]);
    let bends = (1.0 - crossing) * (bij - (bi + bji) / 2.0) + crossing * (bji - (bij + bj) / 2.0);
    (b[NEAR + i] + b[NEAR + j]) / 2.0 + bends
}

/// Returns the point where the line between the centroids `own` and `other` crosses the line from `a` to `b`: 0 at `a`,
/// 1 at `b`. Any line on which both sides agree would do. With this line, the light follows any affine change of the
/// screen, and the line crosses even thin triangles well inside the edge. The perpendicular does neither, and its light
/// bent by a tenth to a third more near silhouettes. Without another side, this returns the middle of the edge.
fn crossing(a: DVec2, b: DVec2, own: DVec2, other: Option<DVec2>) -> f64 {
    let at = other.map(|other| (own - a).perp_dot(other - own) / (b - a).perp_dot(other - own));
    at.filter(|at| at.is_finite()).unwrap_or(0.5)
}

fn along(gradient: &Gradient, step: DVec2) -> DVec3 {
    DVec3::from_array(gradient.map(|g| g.dot(step)))
}

/// Returns the ten Bézier ordinates of the cubic for the part of the triangle where weight `k` is the smallest, row by
/// row from edge k.
///
/// With i = k+1, j = k+2 (mod 3) and u = w_i − w_k, v = w_j − w_k, s = 3·w_k, so that u + v + s = 1, the light is
/// u³b₀ + 3u²v·b₁ + 3uv²·b₂ + v³b₃ + 3s(u²b₄ + 2uv·b₅ + v²b₆) + 3s²(u·b₇ + v·b₈) + s³b₉.
#[must_use]
pub fn sub_triangle_ordinates(b: &ControlPoints, k: usize) -> [DVec3; 10] {
    let (i, j) = ((k + 1) % 3, (k + 2) % 3);
    let row = [i, EDGE + 2 * i, EDGE + 2 * j + 1, j, NEAR + i, MIDDLE + k, NEAR + j, FAR + i, FAR + j, CENTROID];
    row.map(|at| b[at])
}
