//! Pages for exploring: the gallery of stimuli, shaders side by side, and the predictions of the vision model for both.

pub mod gallery;
mod prediction;
pub mod shading;
