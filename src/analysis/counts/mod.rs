//! The sufficient statistic for every model here: how often each participant gave each rating in each condition.
//! Fitting these counts costs the same for a thousand rows as for a billion.

mod builder;
mod table;

pub use builder::MeasuredBuilder;
pub(super) use table::{Combinations, MAX_LEVELS, crossing};
pub use table::{CountRow, Counts, Excluded, Exclusions, Factor, MISSING, Measured, Part, Trial};
