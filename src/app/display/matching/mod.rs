//! Gamma by eye: a patch is matched to rows, and what follows from that.

mod findings;
mod method;
mod pictures;

pub use method::ByEye;
