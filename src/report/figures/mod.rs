//! Charts of a study's results, for print and for the window: SVG, and pixels of the same drawing.
//!
//! Colors are from Okabe & Ito (2008), whose palette color-blind readers can also distinguish; markers, dashes and
//! lightness carry the same information without color. Text is 8 pt in a chart that is 8 cm wide, or 12 cm for
//! `proportions` of two factors.

mod axes;
mod display;
mod effects;
mod figure;
mod labels;
mod means;
pub mod palette;
mod proportions;
mod regroup;
mod svg;
mod times;

use rayon::prelude::*;

use crate::analysis::Results;

pub use display::{calibration, intervals};
pub use figure::{Figure, FigureError, Pixels};
pub use means::predicted;

/// Every chart that has data, in report order.
pub fn all(results: &Results) -> Vec<Figure> {
    let kinds: [fn(&Results) -> Vec<Figure>; 6] = [
        means::figures,
        |results| proportions::figure(results).into_iter().collect(),
        |results| means::participants(results).into_iter().collect(),
        |results| means::orientation(results).into_iter().collect(),
        |results| effects::figure(results).into_iter().collect(),
        |results| times::figure(results).into_iter().collect(),
    ];
    kinds.par_iter().flat_map_iter(|kind| kind(results)).collect()
}
