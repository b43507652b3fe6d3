//! The sufficient statistic for every model here: how often each participant gave each rating in each condition.
//! Fitting these counts costs the same for a thousand rows as for a billion.

mod builder;
mod exclusions;
mod size;
mod table;

pub use builder::MeasuredBuilder;
pub use exclusions::{ExclusionError, Exclusions, MISSING};
pub(super) use size::MAX_LEVELS;
pub(super) use table::{Combinations, crossing};
pub use table::{CountError, CountRow, Counts, Excluded, Factor, Measured, Part, Quartiles, Role, Trial};
