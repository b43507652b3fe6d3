//! Pictures of frames: on the processor, in threads and in lanes, and on a graphics card.

mod cpu;
#[cfg(feature = "gpu")]
pub mod gpu;
mod reference;

pub use cpu::{Encoder, Prepared, picture};
pub use reference::Reference;
