//! Draws frames: one mesh, or several of which some are transparent.

mod composition;
mod one;
mod rays;

pub use composition::{Body, Composition};
pub use one::image;
