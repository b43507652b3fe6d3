//! A study as a document: its sections and sentences, from a plain-language summary to the details needed to repeat the
//! analysis.
//!
//! Any sentence that could be false for some results is computed. A single participant allows no inference: no test, no
//! interval, no probability.

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
