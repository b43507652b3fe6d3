//! Ours: a surface with a continuous slope over the triangles of the screen.
//!
//! Every vertex has its light and a slope of the light on the screen, the gradient. A reduced Clough–Tocher cubic
//! joins them: each triangle is split at its centroid into three, each with a cubic, and along an edge the slope
//! toward the neighbor's centroid runs linearly. Both triangles at an edge then agree about light and slope along all
//! of it, and all triangles at a vertex about both there.
//!
//! Like every smooth curve through given points it can run a little beyond the lights of the vertices, as a highlight
//! between them does. It is not held back: limits on the gradients flattened highlights (twice the error) and did not
//! help elsewhere.
//!
//! Given true gradients, fields up to quadratic ones come out exactly; with those of [`Gradients::Ring`], linear ones.

use glam::DVec2;
use rayon::prelude::*;

use super::{
    clough_tocher::{self, ControlPoints, Gradient},
    curvature,
    ring::{Ring, quadric},
};
use crate::{
    light::names::named,
    shading::frame::{Across, Frame},
};

named! {
    /// Where the slopes at the vertices come from that *patch* needs.
    Gradients, GradientsError {
        /// The chain rule through the curvature of the mesh.
        Curvature = "curvature",
        /// The lights of the vertices around, fitted by a plane.
        Ring = "ring",
        /// The lights of the vertices around, fitted by a quadric.
        Quadric = "quadric",
    }
}

/// The cubics of a frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Patches {
    gradients: Vec<Gradient>,
    control: Vec<ControlPoints>,
}

impl Patches {
    /// The cubics of `frame`, with gradients made as `gradients` says.
    ///
    /// [`Gradients::Curvature`] needs the vertices' lights to be those of the frame's lighting. A vertex whose light
    /// was replaced takes [`Gradients::Ring`] instead.
    #[must_use]
    pub fn new(frame: &Frame, gradients: Gradients) -> Patches {
        let ring = Ring::of(frame);
        let gradient = |v: usize| match gradients {
            Gradients::Ring => ring.plane(frame, v).solve(),
            Gradients::Quadric => quadric(frame, v, &ring).unwrap_or_else(|| ring.plane(frame, v).solve()),
            Gradients::Curvature => curvature::gradient(frame, v, &ring),
        };
        let gradients = (0..frame.vertices.len()).into_par_iter().map(gradient).collect();
        Patches::with_gradients(frame, gradients)
    }

    /// The cubics of `frame` with the gradients given, one for each of [`Frame::vertices`]; those left out are zero.
    #[must_use]
    pub fn with_gradients(frame: &Frame, mut gradients: Vec<Gradient>) -> Patches {
        gradients.resize(frame.vertices.len(), [DVec2::ZERO; 3]);
        let centroids: Vec<DVec2> =
            (0..frame.triangles.len()).map(|t| clough_tocher::centroid(frame.corners(t).map(|v| v.screen))).collect();
        let control = frame
            .triangles
            .par_iter()
            .enumerate()
            .map(|(t, triangle)| {
                let corners = frame.corners(t);
                let across = triangle.across.map(|across| match across {
                    Across::Triangle { triangle, .. } => Some(centroids[triangle as usize]),
                    Across::Nothing | Across::Several => None,
                });
                clough_tocher::control_points(
                    corners.map(|v| v.screen),
                    corners.map(|v| v.light),
                    triangle.vertices.map(|v| gradients[v as usize]),
                    across,
                )
            })
            .collect();
        Patches { gradients, control }
    }

    /// The Bézier ordinates of triangle `triangle` of the frame; see [`ControlPoints`].
    #[must_use]
    pub fn control_points(&self, triangle: usize) -> &ControlPoints {
        &self.control[triangle]
    }

    /// The gradient at each of [`Frame::vertices`]; zero at those of no triangle that is drawn.
    #[must_use]
    pub fn gradients(&self) -> &[Gradient] {
        &self.gradients
    }
}
