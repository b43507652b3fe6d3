//! A study as a reader sees it: what it says, in sentences and tables.
//!
//! No sentence is fixed that could be false of some results: each is computed.

pub(crate) mod agreement;
pub(crate) mod cautions;
pub(crate) mod description;
pub(crate) mod design;
pub(crate) mod effects;
pub(crate) mod findings;
pub(crate) mod health;
pub(crate) mod methods;
pub(crate) mod model;
pub(crate) mod names;
pub(crate) mod oddities;
pub(crate) mod ranks;
mod read;
pub(crate) mod references;
pub(crate) mod repeat;
pub(crate) mod sittings;
pub(crate) mod summary;
pub(crate) mod times;
pub(crate) mod vision;

pub use read::Study;
pub use repeat::Repetition;
pub use summary::{Summary, summary};
