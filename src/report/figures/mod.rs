//! Charts of a study's results, for print and for the window: SVG drawings, and pixels of the same drawings.
//!
//! The colors are the palette of Okabe & Ito (2008), which color-blind readers can also distinguish. Markers, dashes
//! and lightness carry the same information without color. Text is 8 pt if the chart is printed 8 cm wide.

mod answers;
mod axes;
mod display;
mod figure;
mod labels;
mod means;
pub mod palette;
mod stimulus;
mod svg;
pub(super) mod tasks;

use rayon::prelude::*;

use crate::analysis::Results;

pub use display::{calibration, intervals};
pub use figure::{Figure, Pixels};
pub use means::predicted;
pub use stimulus::stimulus;
pub use svg::Plotted;

/// Draws every chart for which there are data, in report order.
pub fn all(results: &Results) -> Vec<Figure> {
    let kinds: [fn(&Results) -> Vec<Figure>; 5] = [
        means::figures,
        |results| answers::proportions(results).into_iter().collect(),
        |results| means::participants(results).into_iter().collect(),
        |results| means::orientation(results).into_iter().collect(),
        |results| tasks::effects(results).into_iter().collect(),
    ];
    kinds.par_iter().flat_map_iter(|kind| kind(results)).collect()
}
