//! Tests of the analysis: from ratings to models, tests, figures and the report.

#[path = "../common/mod.rs"]
mod common;
mod counts;
mod figures;
mod golden;
mod inference;
mod ordinal_faults;
mod report;
mod studies;
mod tasks;
