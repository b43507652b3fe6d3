//! `report.html`: one file that opens anywhere without a network, from a summary in plain words down to what is needed
//! to repeat the analysis.
//!
//! No sentence is fixed that could be false of some results: each is computed.
//! Of one participant nothing is said that would hold for another: no test, no interval, no probability.

mod page;
pub(crate) mod table;

use crate::analysis::Results;
use crate::report::{
    Repetition, Study,
    figures::Figure,
    prediction::{Predicted, Unpredicted},
};

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
