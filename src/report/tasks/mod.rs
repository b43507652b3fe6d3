//! The report of a task other than a rating: psychometric functions, detection, scales from comparisons, and settings.

mod document;
mod figures;
mod results;
mod sections;
mod study;
mod tables;

pub use document::document;
pub use figures::figures;
pub use results::{Comparisons, PersonFunction, TaskResults};
pub(crate) use study::answers;
pub use study::{Asked, Detected, Estimand, Given, Levels, Measure, OfPerson, TaskStudy};
pub use tables::tables;
