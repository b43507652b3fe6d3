//! Calibration with a photometer: patches in a good order, what the photometer reads of them, the fit.

mod findings;
mod method;
mod patches;

pub use method::Photometer;
