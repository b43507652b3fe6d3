//! Meshes by name.
//!
//! All are closed and counter-clockwise seen from outside, but for [`jittered_grid`]. The round ones have the normals of
//! the surface that they stand for; those of the others are averaged over the faces around each vertex, as the papers
//! have them.

mod blob;
mod grid;
mod hull;
mod round;
mod shape;
mod solids;

pub use blob::{blob, fibonacci_points};
pub use grid::jittered_grid;
pub use hull::hull;
pub use round::{sphere, torus};
pub use shape::{MOST_VERTICES, Shape, ShapeError, UnknownShape, mesh};
pub use solids::{cube, pyramid};
