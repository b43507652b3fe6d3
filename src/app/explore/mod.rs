//! Pages for exploring: the gallery of stimuli, shaders side by side, and what the vision model predicts of either.

pub mod gallery;
mod prediction;
pub mod shading;
