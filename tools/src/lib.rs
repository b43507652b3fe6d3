//! Code that the tools share with their tests: published models of Mach bands, the generator of the blue-noise mask,
//! and simulated studies of the ordinal models.

pub mod baselines;
pub mod blue_noise;
pub mod coverage;
pub mod thresholds;
