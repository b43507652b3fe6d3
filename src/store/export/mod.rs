//! Recorded sessions as data sets that the community's validators accept: BIDS and Psych-DS. Exports are all or nothing, and
//! equal sessions give equal bytes.

mod bids;
mod psych_ds;
mod sessions;
mod stimuli;
mod write;

pub use write::{Exported, Format, export};
