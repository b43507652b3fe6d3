//! Draws frames in one pass over all triangles, row by row, in bands that are distributed over threads:
//!
//! ```text
//! Frame → Prepared (constants of every triangle: once per frame) → bands of rows: spans → light (f32) → picture
//! ```
//!
//! Coverage is exactly as in [`coverage`](super::coverage). Hidden surfaces are found by comparing depths in f64, and
//! the light is within 1e-5 of the light that [`Reference`] computes. The image is the same to the last bit for any
//! number of threads and on any machine: the vector width is detected at run time, but no operation on light is fused or
//! approximate. Codes are exactly the quantizer's.

mod band;
mod composition;
mod encoder;
mod lanes;
mod prepared;
mod rays;
mod reference;

pub use composition::{Body, Composition};
pub use encoder::Encoder;
pub use prepared::{Prepared, picture};
pub use reference::Reference;
