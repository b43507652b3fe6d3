//! Floor 0: tables of typed values, and how a value is written. CSV files, JSON, the window, reports and Python's arrays
//! are written from the values; no text is read back.

mod cell;
mod table;

pub use cell::{Cell, inert, is_formula};
pub use table::{Column, Table, csv};
