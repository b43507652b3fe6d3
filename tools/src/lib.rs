//! Code that the tools share with their tests: published models of Mach bands, the generator of the blue-noise mask, the
//! parameters of the Python functions, and simulated studies of the ordinal models.

pub mod baselines;
pub mod blue_noise;
pub mod coverage;
pub mod python;
pub mod thresholds;
