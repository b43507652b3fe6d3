//! The shaders, one file a family, each with its equation. What light a point of a triangle shows, given its weights
//! w_A, w_B, w_C on the screen and the lights I_A, I_B, I_C of the corners.

pub mod cut;
pub mod exact;
pub mod fixed;
pub mod flat;
pub mod gouraud;
pub mod gradient;
pub mod phong;
pub mod quadratic;
pub mod reweight;
mod shade;
pub mod vertex;

pub use shade::{Correction, Shade, Shader};
