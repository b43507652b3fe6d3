//! Analyses of tasks: psychometric functions of one person and of many, detection, and settings. All are functions of
//! numbers, and randomness is an argument.

mod model;
mod numeric;
pub mod person;
pub mod population;
pub mod psychometric;
