//! The shaders, one file each, with its equation: what light a point of a triangle shows, given the weights w_A, w_B, w_C
//! of the corners on the screen and their lights I_A, I_B, I_C.
//!
//! Each is written once, for any `Number`: as f64 it is the reference, and as several pixels of
//! f32 it draws. Its WGSL, for graphics cards, is next to it.

mod corrections;
mod cut;
mod exact;
mod fixed;
pub mod flat;
mod gouraud;
mod gradient;
mod patch;
mod phong;
pub mod quadratic;
mod shade;
mod shading;
mod strips;

pub use gouraud::Spread;
pub use patch::Patch;
pub use shade::{Correction, Shade, Shader};
pub(crate) use shading::with_shader;
pub use shading::{Plain, Shading};
pub use strips::Curve;
