//! Analyses of tasks with right and wrong answers, comparisons and settings: psychometric functions of one person and of
//! many, detection, scales from paired comparisons, and adjustments. All are functions of numbers, and randomness is an
//! argument.

pub mod adjustment;
pub mod detection;
mod likelihood;
pub mod means;
mod model;
mod numeric;
pub mod population;
mod posterior;
pub mod psychometric;
pub mod scaling;
