//! Slopes of the light at the vertices, and the cubics that join them.

mod clough_tocher;
mod curvature;
mod patches;
mod ring;

pub use clough_tocher::{ControlPoints, Gradient, third_of};
pub use patches::{Gradients, Patches};
