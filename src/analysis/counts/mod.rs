//! The sufficient statistic for every model here: how often each participant gave each rating in each condition.
//! Fitting these counts costs the same for a thousand rows as for a billion.

mod builder;
mod exclusions;
mod table;

pub use builder::MeasuredBuilder;
pub use exclusions::{ExclusionError, Exclusions, MISSING};
pub(super) use table::{Combinations, MAX_LEVELS, crossing};
pub use table::{CountError, CountRow, Counts, Excluded, Factor, Measured, Part, Quartiles, Role, Trial};
