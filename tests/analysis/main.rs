//! Ratings in; models, tests, figures and the report out.

#[path = "../common/mod.rs"]
mod common;
mod counts;
mod figures;
mod golden;
mod ordinal_faults;
mod report;
