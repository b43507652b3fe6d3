//! What measuring with a photometer and matching by eye have in common: the settings, a run that can be left and resumed,
//! what was found, and the profile to save.

mod channels;
mod profile_form;
mod stages;

pub use channels::series;
pub use profile_form::SavedProfile;
pub use stages::{Calibrate, Findings, Method, Run};
