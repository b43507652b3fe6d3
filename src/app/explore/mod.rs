//! Pages for exploring: the gallery of stimuli, and shaders side by side.

pub mod gallery;
pub mod shading;
