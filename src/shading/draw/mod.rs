//! Pictures of frames: on the processor, in threads and in lanes, and on a graphics card.

pub mod cpu;
#[cfg(feature = "gpu")]
pub mod gpu;
mod reference;

pub use cpu as raster;
pub use reference::Reference;
