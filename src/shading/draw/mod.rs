//! Pictures of frames: on the processor, and on a graphics card.
//!
//! On the processor triangles are traversed once, row by row in bands over threads:
//!
//! ```text
//! Frame → Prepared (constants of every triangle: once a frame) → bands of rows: spans → light (f32) → picture
//! ```
//!
//! Coverage is exactly that of [`coverage`](super::coverage), hidden surfaces are found by depth in f64, and the light of
//! the lanes is within 1e-5 of the [`Reference`]'s. The picture is the same to the last bit for any number of threads and
//! any machine: vectors are those that the machine has, found when the program runs, and no operation is fused or
//! approximate.

mod band;
mod encoder;
#[cfg(feature = "gpu")]
pub mod gpu;
mod lanes;
mod prepared;
mod reference;

pub use encoder::Encoder;
pub use prepared::{Prepared, picture};
pub use reference::Reference;
