//! Slopes at the vertices: from the values at the surrounding vertices, or from the curvature of the mesh. For the light,
//! dI/dp = (∂I/∂N)·(dN/dp) + the light's own change with position, projected onto the screen.

use glam::DVec3;
use rayon::prelude::*;

use super::projected::{Frame, FrameVertex};
use crate::{
    shading::{
        cubic::{self, Gradient, Slope},
        mesh::Rings,
    },
    system::checkpoint,
    text::names::named,
};

named! {
    /// How to compute the slopes at the vertices, which *patch* and *c1-phong* need.
    Gradients, GradientsError {
        /// The chain rule through the curvature of the mesh.
        Curvature = "curvature",
        /// A plane fitted to the values at the surrounding vertices.
        Ring = "ring",
    }
}

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
    pub(super) fn at(self, vertex: &FrameVertex) -> DVec3 {
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

/// Returns the gradient of `field` at each of [`Frame::fans`].
pub(super) fn of(frame: &Frame, field: Field, gradients: Gradients) -> Vec<Gradient> {
    let ring = Ring::of(frame, field);
    let gradient = |fan: usize| {
        checkpoint();
        match gradients {
            Gradients::Ring => ring.plane(fan).solve(),
            Gradients::Curvature => of_curvature(fan, &ring),
        }
    };
    (0..frame.fans.len()).into_par_iter().map(gradient).collect()
}

/// The step of the central differences, in radii of the mesh's bounding sphere.
const STEP: f64 = 1e-5;

/// The largest difference at which a vertex's light still counts as computed by the frame's lighting.
const SAME: f64 = 1e-9;

/// Returns the gradient at a fan from the curvature of the mesh.
fn of_curvature(fan: usize, ring: &Ring<'_>) -> Gradient {
    let (mut slope, vertex) = (ring.plane(fan), ring.vertex(fan));
    if is_on_surface(ring, vertex) {
        slope.weigh(cubic::RING);
        let curvature = ring.frame.fans[fan].curvature;
        let (weight, steps) = cubic::steps(&ring.frame.view, vertex.eye.to_array(), vertex.normal.to_array());
        for (step, offset, pixels) in steps {
            let step = DVec3::from_array(step) * STEP;
            let moved = |step: DVec3| {
                let normal = (vertex.normal + curvature * step).normalize_or(vertex.normal);
                ring.field.on_surface(ring.frame, vertex.eye + step, normal)
            };
            let change = (moved(step) - moved(-step)) / (2.0 * STEP * pixels);
            slope.add(offset, change.to_array(), weight);
        }
    }
    slope.solve()
}

/// True if the value at `vertex` is the one that the frame's lighting and the surface give it.
fn is_on_surface(ring: &Ring<'_>, vertex: &FrameVertex) -> bool {
    let given = ring.field.on_surface(ring.frame, vertex.eye, vertex.normal);
    // The comparison is false for NaN.
    (given - ring.field.at(vertex)).abs().max_element() <= SAME
}

/// The surroundings of the fans of a frame.
struct Ring<'f> {
    frame: &'f Frame,
    field: Field,
    /// The neighbors of each fan in its drawn triangles.
    neighbors: Rings,
}

impl<'f> Ring<'f> {
    fn of(frame: &'f Frame, field: Field) -> Self {
        let triangles = frame.triangles.iter().map(|triangle| (triangle.fans, triangle.vertices));
        Ring { frame, field, neighbors: Rings::new(frame.fans.len(), triangles) }
    }

    /// Returns the vertex of a fan.
    fn vertex(&self, fan: usize) -> &'f FrameVertex {
        &self.frame.vertices[self.frame.fans[fan].vertex as usize]
    }

    /// Returns the equations of the plane through the vertex of `fan` that best fits its neighbors, weighted by 1/d².
    fn plane(&self, fan: usize) -> Slope {
        let (mut sum, own) = (Slope::default(), self.vertex(fan));
        for other in self.neighbors.of(fan).iter().map(|other| &self.frame.vertices[*other as usize]) {
            let (offset, change) = (other.screen - own.screen, self.field.at(other) - self.field.at(own));
            if offset.length_squared() > 0.0 {
                sum.add(offset.to_array(), change.to_array(), 1.0 / offset.length_squared());
            }
        }
        sum
    }
}
