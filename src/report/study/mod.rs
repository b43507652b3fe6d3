//! A study as a document: its sections and their sentences, from a plain-language summary down to what is needed to repeat
//! the analysis.
//!
//! No fixed sentence may be false for some results; such sentences are computed. For a single participant there is no
//! inference: no test, no interval, no probability.

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
