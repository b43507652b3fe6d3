//! Exports recorded sessions as BIDS or Psych-DS data sets that pass the standard's validator. Exports are
//! all-or-nothing, and the same sessions always give the same bytes.

mod bids;
mod sessions;
mod write;

pub use write::{Choice, Exported, Format, export};
