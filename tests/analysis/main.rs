//! Ratings in; models, tests, figures and the report out.

mod counts;
mod figures;
mod golden;
mod ordinal;
mod ordinal_faults;
mod ordinal_recovery;
mod ranks;
mod report;
