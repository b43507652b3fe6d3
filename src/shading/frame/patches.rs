//! New in machband: quantities with a continuous slope over the triangles on the screen. The cubics are those of
//! [`cubic`]. Their slopes at the vertices follow from the curvature of the mesh: for the light, dI/dp =
//! (∂I/∂N)·(dN/dp) + the light's own change with position, projected onto the screen; the values at the surrounding
//! vertices count a little.
//!
//! Like every smooth curve through given points, the result can slightly exceed the values of the vertices, as a
//! highlight between them does. This overshoot is not limited: limits on the gradients flattened highlights (doubling
//! the error) and did not help elsewhere.
//!
//! With true gradients, fields up to quadratic ones are reproduced exactly.

use glam::DVec3;
use rayon::prelude::*;

use super::projected::{Frame, FrameVertex};
use crate::{
    shading::cubic::{self, Coefficients, Gradient, Slope},
    system::checkpoint,
};

/// A quantity with three components that changes smoothly over the surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Field {
    /// Red, green and blue light.
    Light,
    /// The unit normal in eye space.
    Normal,
    /// The position in eye space.
    Position,
}

impl Field {
    /// Returns the value at a vertex.
    fn at(self, vertex: &FrameVertex) -> DVec3 {
        match self {
            Field::Light => vertex.light,
            Field::Normal => vertex.normal,
            Field::Position => vertex.eye,
        }
    }

    /// Returns the value at the point `eye` of the surface, where its unit normal is `normal`.
    fn on_surface(self, frame: &Frame, eye: DVec3, normal: DVec3) -> DVec3 {
        match self {
            Field::Light => frame.lit(eye, normal),
            Field::Normal => normal,
            Field::Position => eye,
        }
    }
}

/// The gradients and cubics of a frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Patches {
    /// The gradient at each of [`Frame::fans`], per pixel to the right and per pixel down.
    pub gradients: Vec<Gradient>,
    /// The cubic of each of [`Frame::triangles`].
    pub coefficients: Vec<Coefficients>,
}

impl Patches {
    /// Computes the cubics of `field` over `frame`.
    ///
    /// The curvature gives a slope only to values that come from the frame's lighting. Where a vertex's light was replaced,
    /// the surrounding vertices alone determine it.
    pub fn new(frame: &Frame, field: Field) -> Patches {
        let triangles = frame.triangles.iter().map(|triangle| (triangle.fans, triangle.vertices));
        let neighbors = cubic::around(frame.fans.len(), triangles);
        let gradients = neighbors.par_iter().enumerate().map(|(fan, ring)| gradient(frame, field, fan, ring)).collect();
        Patches::with_gradients(frame, field, gradients)
    }

    /// Computes the cubics of `field` over `frame` with the given gradients, one for each of [`Frame::fans`]; missing
    /// gradients are zero.
    pub fn with_gradients(frame: &Frame, field: Field, mut gradients: Vec<Gradient>) -> Patches {
        gradients.resize(frame.fans.len(), [[0.0; 2]; 3]);
        let of_triangle = |t: usize| {
            checkpoint();
            let corners = frame.corners(t);
            let of = |vector: fn(&FrameVertex) -> DVec3| corners.map(|v| vector(v).to_array());
            let places = (corners.map(|v| v.screen.to_array()), of(|v| v.eye), of(|v| v.normal));
            let slopes = frame.triangles[t].sides.map(|sides| sides.map(|fan| &gradients[fan as usize]));
            cubic::cubic(&frame.view, places, corners.map(|v| field.at(v).to_array()), slopes)
        };
        let coefficients = (0..frame.triangles.len()).into_par_iter().map(of_triangle).collect();
        Patches { gradients, coefficients }
    }

    /// Returns the value at the point where the corners of a triangle have the weights `w` on the screen.
    pub fn value(&self, triangle: usize, w: [f64; 3]) -> DVec3 {
        cubic::value(&self.coefficients[triangle], w).into()
    }
}

/// The step of the central differences, in radii of the mesh's bounding sphere.
const STEP: f64 = 1e-5;

/// The largest difference at which a vertex's value still counts as computed by the frame's lighting.
const SAME: f64 = 1e-9;

/// Returns the gradient at a fan, which has these vertices around it.
fn gradient(frame: &Frame, field: Field, fan: usize, ring: &[u32]) -> Gradient {
    checkpoint();
    let vertex = &frame.vertices[frame.fans[fan].vertex as usize];
    // The plane through the vertex that best fits its neighbors, weighted by 1/d².
    let mut slope = Slope::default();
    for other in ring.iter().map(|other| &frame.vertices[*other as usize]) {
        let (offset, change) = (other.screen - vertex.screen, field.at(other) - field.at(vertex));
        if offset.length_squared() > 0.0 {
            slope.add(offset.to_array(), change.to_array(), 1.0 / offset.length_squared());
        }
    }
    let given = field.on_surface(frame, vertex.eye, vertex.normal);
    // The comparison is false for NaN.
    if (given - field.at(vertex)).abs().max_element() <= SAME {
        slope.weigh(cubic::RING);
        let curvature = frame.fans[fan].curvature;
        let (weight, steps) = cubic::steps(&frame.view, vertex.eye.to_array(), vertex.normal.to_array());
        for (step, offset, pixels) in steps {
            let step = DVec3::from_array(step) * STEP;
            let moved = |step: DVec3| {
                let normal = (vertex.normal + curvature * step).normalize_or(vertex.normal);
                field.on_surface(frame, vertex.eye + step, normal)
            };
            let change = (moved(step) - moved(-step)) / (2.0 * STEP * pixels);
            slope.add(offset, change.to_array(), weight);
        }
    }
    slope.solve()
}
