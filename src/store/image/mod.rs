//! Images (PNG): stimuli written with the recipe that made them and proved from it, and any other image as light.

pub mod light;
mod write;

pub use write::*;
