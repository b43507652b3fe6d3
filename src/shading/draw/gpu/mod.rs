//! The shaders on a graphics card, in WGSL.
//!
//! [`Gpu`] draws a [`Frame`](crate::shading::Frame) into a texture with one draw call. The CPU computes the constants
//! of triangles and edges once per frame, and the vertex stage passes them to the pixels of each triangle. On the card,
//! all computation is in f32, and light is encoded for the display.
//!
//! Each pixel shows the same triangle as on the CPU, because vertices lie on the 1/256-pixel grid that graphics cards
//! use. The 8-bit codes differ from the CPU's by at most one if the display's exponent is at most 3; above that, the
//! darkest codes are too close together for f32. If a shader has a discontinuity (printed vertex shading with b > ¼), a
//! pixel exactly on it may fall on either side.
//!
//! The WGSL of each shader is next to its Rust code, in `shaders/`, and the code around the shaders is here.

mod card;
mod pack;
mod pipeline;

pub use card::{Gpu, GpuError, codes};
