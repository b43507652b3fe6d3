//! Pages for exploring: the gallery of stimuli, and what the vision model predicts of what is shown.

pub mod gallery;
pub mod predicted;
