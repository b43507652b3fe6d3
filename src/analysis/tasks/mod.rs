//! Analyses of tasks with right and wrong answers: psychometric functions of one person and of many. All are functions
//! of numbers, and randomness is an argument.

mod model;
mod numeric;
pub mod population;
pub mod psychometric;
