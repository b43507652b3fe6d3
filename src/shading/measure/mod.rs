//! Two measures of a shader: the creases that it leaves at the edges of triangles, and the smooth surface with which
//! its picture can be compared.
//!
//! A crease is the jump of the slope of the light on the screen.
//!
//! Creases are measured on the light itself, by one-sided differences between the light values that a shader gives at
//! points close to the edge. No shader's formula is used, so errors in the shaders show up here. A jump of the slope is
//! a property of the light. Whether it is visible as a band is another question, which depends on its size, its length,
//! and its surroundings.

mod creases;
mod truth;

pub use creases::{Creases, EdgeCrease, NOISE};
pub use truth::Truth;
pub use truth::color;
