//! New in machband: quantities with a continuous slope over the triangles on the screen. The cubics are those of
//! [`cubic`], with the slopes of [`Gradients`].
//!
//! Like every smooth curve through given points, the result can slightly exceed the values of the vertices, as a
//! highlight between them does. This overshoot is not limited: limits on the gradients flattened highlights (doubling
//! the error) and did not help elsewhere.
//!
//! With true gradients, fields up to quadratic ones are reproduced exactly; with the gradients of [`Gradients::Ring`],
//! only linear fields are.

use rayon::prelude::*;

use super::{
    gradients::{self, Field, Gradients},
    projected::Frame,
};
use crate::{
    shading::cubic::{self, Coefficients, Gradient},
    system::checkpoint,
};

/// The gradients and cubics of a frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Patches {
    /// The gradient at each of [`Frame::fans`], per pixel to the right and per pixel down.
    pub gradients: Vec<Gradient>,
    /// The cubic of each of [`Frame::triangles`].
    pub coefficients: Vec<Coefficients>,
}

impl Patches {
    /// Computes the cubics of `field` over `frame`, with gradients computed as `gradients` specifies.
    ///
    /// For the light, [`Gradients::Curvature`] requires that the vertices' light values come from the frame's lighting.
    /// A vertex whose light was replaced uses [`Gradients::Ring`] instead.
    pub fn new(frame: &Frame, field: Field, gradients: Gradients) -> Patches {
        Patches::with_gradients(frame, field, gradients::of(frame, field, gradients))
    }

    /// Computes the cubics of `field` over `frame` with the given gradients, one for each of [`Frame::fans`]; missing
    /// gradients are zero.
    pub fn with_gradients(frame: &Frame, field: Field, mut gradients: Vec<Gradient>) -> Patches {
        gradients.resize(frame.fans.len(), [[0.0; 2]; 3]);
        let of_triangle = |t: usize| {
            checkpoint();
            let corners = frame.corners(t);
            let across = [0, 1, 2].map(|k| {
                let ends = [corners[(k + 1) % 3], corners[(k + 2) % 3]];
                cubic::across(
                    &frame.view,
                    ends.map(|v| v.screen.to_array()),
                    ends.map(|v| v.eye.to_array()),
                    ends.map(|v| v.normal.to_array()),
                )
            });
            let slopes = frame.triangles[t].sides.map(|sides| sides.map(|fan| &gradients[fan as usize]));
            cubic::cubic(corners.map(|v| v.screen.to_array()), corners.map(|v| field.at(v).to_array()), slopes, across)
        };
        let coefficients = (0..frame.triangles.len()).into_par_iter().map(of_triangle).collect();
        Patches { gradients, coefficients }
    }
}
