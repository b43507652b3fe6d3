//! Floor 2: stimuli. A validated specification is turned into light, and a quantizer turns the light into codes.
//!
//! [`catalog`] lists every kind. It is the single source for commands, the gallery and the tests.

pub mod catalog;
pub mod color;
mod drawing;
mod figures;
mod mach_band;
pub mod parameter;
pub mod picture;
mod predicted;
mod profiles;
pub mod recipe;
mod shaded_mesh;
mod viewing;

pub use catalog::{KINDS, Stimulus, is_direction};
pub use color::{ColorError, StimulusColor};
pub use figures::{Kanizsa, Vasarely};
pub use mach_band::{MachBand, Ramp, RampSpace, RampSpaceError};
pub use parameter::{Parameter, ParameterError, ParameterValue};
pub use predicted::Visible;
pub use profiles::{Chevreul, Cornsweet, Cylinder, Shading};
pub use shaded_mesh::{ShadedMesh, Triple, along, emitted};
pub use viewing::{Judged, Residual, SurfaceDifference, ViewingConditions};
