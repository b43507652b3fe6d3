//! The shaders' twin on a graphics card, in WGSL.
//!
//! [`Gpu`] draws a [`Frame`](super::Frame) into a texture of somebody's device, with one draw; [`Offscreen`] has a
//! device of its own, and gives an image. Lights are made of the same constants of triangles and edges as on the CPU,
//! in f32, and encoded for the display; a picture is within one 8-bit code of the CPU's, as long as the display's
//! exponent is not above 3: beyond, the darkest codes are closer together than f32 knows them.
//!
//! The WGSL is in `wgsl/`, a file an idea: `interpolation`, `boundary` (with *exact* and *cut*), `patch`, `vertex`,
//! `lighting`, `transfer`.

mod device;
mod offscreen;
mod pack;
mod pipeline;
mod twin;

pub use device::{GpuError, limits};
pub use offscreen::{Offscreen, Timing};
pub use pipeline::WGSL;
pub use twin::{Gpu, GpuFrame, Region};
