//! How much of a crease a shader leaves at the edges of triangles: the jump, on the screen, of the slope of the light.
//!
//! Measured on the light itself, by one-sided differences of what a shader gives at points close to the edge. No
//! shader's formula is used, so a fault in one shows here. A jump of the slope is what light does; whether it is seen
//! as a band is another question, and depends on its size, its length and what is around it.

mod creases;
mod picture;

pub use creases::{Creases, EdgeCrease, NOISE, at_vertices};
pub use picture::picture;
