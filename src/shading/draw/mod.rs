//! Draws frames: one mesh, or several of which some are transparent.

mod composition;
mod rays;

pub use composition::image;
pub use composition::{Body, Composition};
