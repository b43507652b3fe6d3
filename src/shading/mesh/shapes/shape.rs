//! Meshes by name.

use super::{
    blob::{self, blob},
    round::{self, sphere},
    solids::{cube, pyramid},
};
use crate::{light::names::named, shading::mesh::Mesh};

named! {
    /// A mesh by its name.
    Shape, UnknownShape {
        /// [`cube`].
        Cube = "cube",
        /// [`pyramid`].
        Pyramid = "pyramid",
        /// `sphere`.
        Sphere = "sphere",
        /// `torus`.
        Torus = "torus",
        /// [`blob`].
        Blob = "blob",
    }
}

/// The shape cannot have so many or so few vertices.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("a {shape} cannot have {vertices} vertices; expected {least}…{most}", most = MOST_VERTICES)]
pub struct ShapeError {
    /// Which shape.
    shape: Shape,
    /// How many were asked for.
    vertices: usize,
    /// The fewest it can have.
    least: usize,
}

/// Most vertices of a shape.
pub const MOST_VERTICES: usize = 500_000;

impl Shape {
    /// Whether the shape can have more vertices or fewer: not the cube and the pyramid.
    #[must_use]
    pub const fn has_vertices(self) -> bool {
        matches!(self, Shape::Sphere | Shape::Torus | Shape::Blob)
    }

    /// The fewest vertices that the shape can have.
    #[must_use]
    pub const fn least_vertices(self) -> usize {
        match self {
            Shape::Cube | Shape::Pyramid => 8,
            Shape::Sphere => round::LEAST_SPHERE,
            Shape::Torus => round::LEAST_TORUS,
            Shape::Blob => blob::LEAST,
        }
    }
}

/// The mesh of `shape` with `vertices` places: exactly so many for the blob, about so many for sphere and torus, whose
/// triangles would otherwise be distorted; cube and pyramid always have 8.
///
/// # Errors
/// [`ShapeError`] outside [`Shape::least_vertices`]…[`MOST_VERTICES`].
pub fn mesh(shape: Shape, vertices: usize) -> Result<Mesh, ShapeError> {
    if shape.has_vertices() && !(shape.least_vertices()..=MOST_VERTICES).contains(&vertices) {
        return Err(ShapeError { shape, vertices, least: shape.least_vertices() });
    }
    match shape {
        Shape::Cube => Ok(cube()),
        Shape::Pyramid => Ok(pyramid()),
        Shape::Sphere => Ok(sphere(round::subdivisions(vertices))),
        Shape::Torus => Ok(round::torus_of(vertices)),
        Shape::Blob => Ok(blob(vertices)),
    }
}
