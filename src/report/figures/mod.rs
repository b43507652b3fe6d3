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
pub use ratings::predicted;
pub use svg::{Figure, Pixels, Plotted};

/// Draws every chart for which there are data, in report order.
pub fn all(results: &Results) -> Vec<Figure> {
    let kinds: [fn(&Results) -> Vec<Figure>; 5] = [
        ratings::figures,
        |results| ratings::proportions(results).into_iter().collect(),
        |results| ratings::participants(results).into_iter().collect(),
        |results| ratings::orientation(results).into_iter().collect(),
        |results| tasks::effects(results).into_iter().collect(),
    ];
    kinds.par_iter().flat_map_iter(|kind| kind(results)).collect()
}
