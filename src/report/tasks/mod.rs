//! The report of a task other than a rating: psychometric functions, detection, scales from comparisons, and settings.

mod document;
mod figures;
mod further;
mod results;
mod study;
mod tables;

pub use document::document;
pub use figures::figures;
pub use results::{Comparisons, Detected, OfPerson, PersonFunction, TaskResults};
pub use study::{Asked, Given, Levels, TaskStudy};
pub(crate) use study::{answers, task};
pub use tables::tables;
