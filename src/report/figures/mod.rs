//! Charts of a study's results, for print and for the window: SVG drawings, and pixels of the same drawings.
//!
//! The colors are the palette of Okabe & Ito (2008), which color-blind readers can also distinguish. Markers, dashes
//! and lightness carry the same information without color. Text is 8 pt if the chart is printed 8 cm wide.

mod axes;
mod display;
mod labels;
pub mod palette;
mod ratings;
mod svg;
pub(super) mod tasks;

use rayon::prelude::*;

use crate::analysis::Results;

pub use display::{calibration, calibration_tables, intervals, stimulus};
pub use svg::{Figure, Pixels, Plotted};

/// Draws every chart for which there are data, in report order.
pub fn all(results: &Results) -> Vec<Figure> {
    let kinds = [ratings::proportions, ratings::participants, ratings::orientation, tasks::effects];
    let others: Vec<Option<Figure>> = kinds.par_iter().map(|kind| kind(results)).collect();
    ratings::figures(results).into_iter().chain(others.into_iter().flatten()).collect()
}
