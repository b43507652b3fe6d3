//! Writes, reads and verifies a session on disk: its data set, its rows, and the sidecar and frames file next to them.

pub mod dataset;
pub mod overview;
pub mod recorded;
mod repair;
pub mod results;
pub mod seal;
pub mod sidecar;
mod store;

pub use repair::{Repaired, repair};
pub use store::{Changes, Interrupted, SessionStore};
