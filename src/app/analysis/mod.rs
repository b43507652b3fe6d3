//! The analysis: reads files and shows the results document.
//!
//! [`page`] reads files and asks the [`questions`] that they leave open; [`open_study`] filters and models the ratings,
//! [`task`] has the answers to another task, and [`opened`] lays out both and
//! knows whether their files have changed. [`document`] shows the document of `machband analyze` in the window, with sortable [`tables`](table).

mod document;
mod open_study;
mod opened;
mod page;
mod query;
mod questions;
mod table;
mod task;

pub use page::Analysis;
pub use table::TableView;
