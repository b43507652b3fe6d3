//! What the tools share with their tests: models of Mach bands to compare with, and the generator of the blue-noise mask.

pub mod baselines;
pub mod blue_noise;
