//! A study as a document: which sections it has, and what they say of its results, from a summary in plain words down to
//! what is needed to repeat the analysis.
//!
//! No sentence is fixed that could be false of some results: each is computed. Of one participant nothing is said that
//! would hold for another: no test, no interval, no probability.

mod cautions;
mod description;
mod document;
mod findings;
mod health;
mod methods;
mod model;
mod names;
mod provenance;
mod ranks;
mod sittings;
mod summary;
mod vision;

pub use document::{Parts, Study, document};
pub use provenance::{Provenance, shell_command};
pub use summary::{Summary, summary};
