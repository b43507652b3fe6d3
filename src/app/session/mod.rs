//! A session: preflight, questions about the participant, instructions, trials, and the last page. [`Runner`] shows them in this order.

mod answers;
mod findings;
mod finish;
mod instructions;
mod participant;
mod preflight;
mod recording;
mod request;
mod runner;
mod trials;

pub use recording::fresh_seed;
pub use request::{Request, room, stimulus_side_px};
pub use runner::Runner;
pub use trials::Trials;
