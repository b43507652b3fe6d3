//! Floor 1: how the screen changes the image before it reaches the eye.

mod channel;
pub mod frames;
pub mod geometry;
pub mod matching;
pub mod photometer;
pub mod profile;

pub use channel::{Channel, UnknownChannel};
pub use geometry::{Monitor, Screen, Viewing};
pub use profile::{DisplayProfile, LuminanceRange, Measurement, Primaries};
