//! Writes, reads and verifies a session on disk: its data set, its rows, and the sidecar and frames file next to them.

pub mod dataset;
pub mod frames;
pub mod recorded;
pub mod results;
pub mod seal;
pub mod sidecar;
mod store;
pub mod verify;

pub use store::{Interrupted, SessionStore};
