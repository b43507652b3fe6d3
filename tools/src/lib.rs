//! Code that the tools share with their tests: published models of Mach bands, and the generator of the blue-noise mask.

pub mod baselines;
pub mod blue_noise;
