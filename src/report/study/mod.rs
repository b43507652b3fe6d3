//! Describes a study in a document with sections and sentences, from a plain-language summary to the details needed to
//! repeat the analysis.
//!
//! Every sentence that could be false for some results is computed from the results. A single participant allows no
//! inference about people: tests and intervals are then about that participant's trials.

mod description;
mod document;
mod findings;
mod health;
mod interactions;
mod methods;
mod model;
mod names;
mod provenance;
mod summary;

pub use document::document;
pub use provenance::Provenance;
pub(crate) use provenance::definition;
pub use summary::{Summary, summary};
