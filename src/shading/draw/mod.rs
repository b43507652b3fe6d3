//! Draws frames on the CPU and on a graphics card.
//!
//! The CPU traverses triangles once, row by row, in bands distributed over threads:
//!
//! ```text
//! Frame → Prepared (constants of every triangle: once a frame) → bands of rows: spans → light (f32) → picture
//! ```
//!
//! Coverage is exactly that of [`coverage`](super::coverage), hidden surfaces are found by depth in f64, and the light
//! of the lanes is within 1e-5 of the [`Reference`]'s. The image is the same to the last bit for any number of threads
//! and on any machine: the vector width is detected at run time, and no operation is fused or approximate.

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
