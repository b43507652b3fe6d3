//! Analyses of tasks with right and wrong answers: psychometric functions of one person and of many. All are functions
//! of numbers, and randomness is an argument.

pub mod means;
mod model;
mod numeric;
pub mod population;
mod posterior;
pub mod psychometric;
