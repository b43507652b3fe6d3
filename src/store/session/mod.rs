//! A session on disk: its data set, its rows and the sidecar beside them.

pub mod dataset;
pub mod description;
pub mod pictures;
pub mod sidecar;
mod store;

pub use store::{Interrupted, SessionStore};
