//! `report.html`: one file that opens anywhere without a network, from a summary in plain words down to what is needed
//! to repeat the analysis.
//!
//! No sentence is fixed that could be false of some results: each is computed, in [`summary()`] and beside every table.
//! Of one participant nothing is said that would hold for another: no test, no interval, no probability.

mod agreement;
mod cautions;
mod description;
mod design;
mod effects;
mod findings;
mod health;
mod methods;
mod model;
mod names;
mod numbers;
mod oddities;
mod page;
mod ranks;
mod references;
mod repeat;
mod sittings;
mod summary;
mod table;
mod times;
mod vision;

pub use repeat::Repetition;
pub use summary::{Summary, summary};

use super::{
    Study,
    figures::Figure,
    prediction::{Predicted, Unpredicted},
};
use crate::analysis::Results;

/// The page, as HTML. `predicted` is what the model of vision says of the ratings that the results are of; `figures`
/// have it too.
pub fn report(
    study: &Study,
    results: &Results,
    figures: &[Figure],
    predicted: &Result<Predicted, Unpredicted>,
    how: &Repetition,
) -> String {
    page::page(&study.source, results, figures, predicted, how).into_string()
}
