//! The analysis: files in, the results document out.
//!
//! [`page`] reads files; [`open_study`] filters and models what was read. The document is that of `machband analyze`:
//! [`document`] is its skin in the window, with [`tables`](table) that can be sorted and the [`figures`](figure) of the
//! report.

mod columns;
mod document;
mod export;
mod figure;
mod filters;
mod open_study;
mod page;
mod settings;
mod source;
mod start;
mod table;

pub use page::Analysis;
