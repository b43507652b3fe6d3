//! Preflight: what the screen really is, in plain sentences, before anything is measured on it.

mod findings;
mod page;
mod questions;

pub use page::Preflight;
