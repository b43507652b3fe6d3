//! Floor 2: what is shown. A specification, validated, becomes light, and with a quantizer codes.
//!
//! [`catalog`] lists every kind: the one place that commands, the gallery and the tests take them from.

pub mod catalog;
mod chevreul;
pub mod color;
mod cornsweet;
mod coverage;
mod cylinder;
mod drawing;
mod kanizsa;
mod kind;
mod kinds;
mod mach_band;
mod orientation;
pub mod parameter;
mod ramp_space;
pub mod recipe;
mod shaded_mesh;
mod shot;
mod sight;
mod vasarely;

pub use chevreul::Chevreul;
pub use color::{ColorError, StimulusColor};
pub use cornsweet::Cornsweet;
pub use cylinder::{Cylinder, Shading};
pub use kanizsa::Kanizsa;
pub use kinds::{KINDS, Stimulus};
pub use mach_band::{MachBand, Ramp};
pub use orientation::place;
pub use parameter::{Parameter, ParameterError, ParameterValue};
pub use ramp_space::{RampSpace, RampSpaceError};
pub use shaded_mesh::{ShadedMesh, Triple};
pub use shot::{Renderer, Shot, describe_scene};
pub use sight::{Sight, View};
pub use vasarely::Vasarely;
