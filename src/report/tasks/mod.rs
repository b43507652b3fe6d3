//! The report of a task other than a rating: psychometric functions, detection, scales from comparisons, and settings.

mod asked;
mod document;
mod figures;
mod further;
mod results;
mod study;
mod tables;

pub use asked::{Asked, Levels};
pub(crate) use asked::{answers, method, task};
pub use document::{MODEL_OF_DIFFERENCES, MODEL_OVER_PEOPLE, document, model_of_a_person};
pub use figures::figures;
pub use results::{Beyond, Comparisons, Detected, OfPerson, PersonFunction, TaskResults};
pub use study::{TaskAnswered, TaskStudy, TaskTrial};
pub use tables::tables;
