//! A session: preflight, instructions, trials, and its end. [`Runner`] leads from one to the next.

mod finish;
mod frames;
mod hasher;
mod instructions;
mod preflight;
mod request;
mod runner;
mod scale;
mod trials;
mod trouble;

pub use request::{Request, stimulus_side_px};
pub use runner::Runner;
