//! Exports recorded sessions as BIDS or Psych-DS data sets that pass the standard's validator. Exports are
//! all-or-nothing, and the same sessions always give the same bytes.

mod bids;
mod psych_ds;
mod sessions;
mod stimuli;
mod write;

pub use write::{Choice, Exported, Format, export};
