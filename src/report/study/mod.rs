//! A study as a document: which sections it has, and what they say of its results, from a summary in plain words down to
//! what is needed to repeat the analysis.
//!
//! No sentence is fixed that could be false of some results: each is computed. Of one participant nothing is said that
//! would hold for another: no test, no interval, no probability.

mod agreement;
mod cautions;
mod description;
mod design;
mod effects;
mod findings;
mod health;
mod limits;
mod methods;
mod model;
mod names;
mod oddities;
mod provenance;
mod ranks;
mod read;
mod references;
mod sections;
mod sittings;
mod summary;
mod times;
mod vision;

pub use provenance::{Provenance, shell_command};
pub use read::Study;
pub use sections::{Parts, document};
pub use summary::{Summary, summary};
