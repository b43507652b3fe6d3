//! Floor 5: creates the report of a study from its files.
//!
//! [`analyze`](crate::analysis::analyze) computes the results of ratings. [`study`] turns
//! the results into blocks of a [`document`](mod@document), with sentences and [`figures`], and [`skins`] display the
//! document. [`tables`] contain the results as CSV and JSON, and [`terminal`] prints lines. [`Analyzed`] holds the results
//! of ratings or of another task, and writes everything into a folder.

pub mod document;
pub mod figures;
pub(crate) mod names;
mod output;
mod script;
pub mod skins;
pub mod study;
pub mod tables;
pub mod tasks;
pub mod terminal;

pub use output::{Analyzed, Contents, check_folder, png, write_files};
pub use study::Provenance;
