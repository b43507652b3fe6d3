//! Floor 5: from files to the report of a study.
//!
//! [`Study`] holds what was read, and [`analyze`](crate::analysis::analyze) computes its results. [`study`] turns these
//! into blocks of a [`document`](mod@document), with sentences and [`figures`], and [`skins`] display the document.
//! [`tables`] contain the results as CSV and JSON. [`write_all`] writes everything into a folder.

pub mod document;
pub mod figures;
mod output;
pub mod prediction;
pub mod skins;
pub mod study;
pub mod tables;

pub use output::{Written, write_all};
pub use study::{Provenance, Study};
