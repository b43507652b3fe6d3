//! Floor 1: what the screen does to the picture before it reaches the eye.

pub mod geometry;
pub mod profile;

pub use geometry::{Geometry, GeometryError, Screen, Viewing};
pub use profile::{DisplayProfile, LuminanceRange, Measurement, Primaries};
