//! A session on disk: its data set, its rows, the sidecar and the frames beside them; read back, and proved.

pub mod dataset;
pub mod frames;
pub mod recorded;
pub mod results;
pub mod sidecar;
mod store;
pub mod verify;

pub use store::{Interrupted, SessionStore};
