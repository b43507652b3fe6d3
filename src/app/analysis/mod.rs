//! The analysis: files in, the results document out.
//!
//! [`page`] reads files; [`open_study`] filters and models what was read. The document is that of `machband analyze`:
//! [`document`] is its skin in the window, with [`tables`](table) that can be sorted.

mod columns;
mod document;
mod export;
mod open_study;
mod page;
mod query;
mod table;

pub use page::Analysis;
