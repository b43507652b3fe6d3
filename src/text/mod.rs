//! Floor −1, the basement: values as words, for people and in files; and tables of typed values. CSV files, JSON, the
//! window, reports and Python's arrays are written from the values; no text is read back. It uses no other module of this
//! crate.

pub(crate) mod names;
pub(crate) mod number;
mod table;

pub(crate) use table::as_cell;
pub use table::{Cell, Column, Table, inert, is_formula};
