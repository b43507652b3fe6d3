//! Ratings in; models, tests, figures and the report out.

mod counts;
mod figures;
mod golden;
mod ordinal_faults;
mod report;
