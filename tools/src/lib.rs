//! Code that the tools share with their tests: the model of vision against people's thresholds, the generator of the
//! blue-noise mask, the parameters of the Python functions, and simulated studies of the ordinal models.

pub mod blue_noise;
pub mod coverage;
pub mod python;
pub mod thresholds;
