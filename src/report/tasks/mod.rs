//! The report of a task other than a rating: psychometric functions, detection, scales from comparisons, and settings.

mod asked;
mod document;
mod figures;
mod further;
mod results;
mod study;
mod tables;

pub use asked::{Asked, Levels};
pub(crate) use asked::{answers, task};
pub use document::document;
pub use figures::figures;
pub use results::{Beyond, Comparisons, Detected, OfPerson, PersonFunction, TaskResults};
pub use study::{TaskAnswered, TaskStudy, TaskTrial};
pub use tables::tables;
