//! The shaders on a graphics card, in WGSL.
//!
//! [`Gpu`] draws a [`Frame`](crate::shading::Frame) into a texture, with one draw. The constants of triangles
//! and edges come from the processor, computed once a frame; the vertex stage hands them to the pixels of its triangle,
//! where everything is f32, and encodes for the display.
//!
//! Which triangle a pixel shows is as on the CPU, because vertices lie on the steps of 1/256 pixel that cards have. Its
//! codes are within one of the CPU's at 8 bits, as long as the display's exponent is not above 3: beyond, the darkest
//! codes are closer together than f32 tells apart. Where a shader jumps (printed vertex shading with b > ¼), a pixel
//! on the very jump may fall on either side.
//!
//! The WGSL of each shader is next to its Rust, in `shaders/`, and what is around the shaders is here. *exact* and *cut*, with
//! `strips`, and *patch* can be taken as they are.

mod card;
mod pack;
mod pipeline;

pub use card::{Gpu, GpuError, codes};
