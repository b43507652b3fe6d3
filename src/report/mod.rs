//! Floor 5: from files to what a reader of a study sees.
//!
//! [`Study`] is what was read, [`analyze`](crate::analysis::analyze) makes results of it. [`study`] says which blocks of
//! a [`document`](mod@document) they become, with their sentences and [`figures`]; [`skins`] show these. [`tables`] are
//! the results as CSV and JSON, and [`write_all`] writes everything into a folder.

pub mod document;
pub mod figures;
mod output;
pub mod prediction;
pub mod skins;
pub mod study;
pub mod tables;

pub use output::{Written, write_all};
pub use study::{Provenance, Study};
