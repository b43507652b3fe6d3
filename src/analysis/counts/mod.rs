//! The sufficient statistic of every model here: how often each subject gave each rating in each condition. Fitting on
//! these counts costs the same for a thousand rows as for a billion.

mod builder;
mod measured;
mod table;

pub use builder::{CountsBuilder, MeasuredBuilder};
pub use measured::{Measured, RetestPair, TimeCount};
pub use table::{CountError, CountRow, Counts, Factor};
