//! The shaders on a graphics card, in WGSL.
//!
//! [`Gpu`] draws a [`Frame`](crate::shading::Frame) into a texture with one draw call. The CPU computes the constants
//! of triangles and edges once per frame, and the vertex stage passes them to the pixels of each triangle. There, all
//! computation is in f32, and light is encoded for the display.
//!
//! Which triangle a pixel shows is as on the CPU, because vertices lie on the steps of 1/256 pixel that cards have. Its
//! codes are within one of the CPU's at 8 bits, if the display's exponent is at most 3; above that, the darkest codes
//! are too close together for f32. If a shader has a discontinuity (printed vertex shading with b > ¼), a pixel exactly
//! on it may fall on either side.
//!
//! The WGSL of each shader is next to its Rust, in `shaders/`, and the code around the shaders is here. *exact* and
//! *cut*, with `strips`, and *patch* can be reused unchanged.

mod card;
mod pack;
mod pipeline;

pub use card::{Gpu, GpuError, codes};
