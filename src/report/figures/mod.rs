//! Charts of a study's results, for print and for the window: SVG, and pixels of the same drawing.
//!
//! Colors are those of Okabe & Ito (2008), which color-blind readers can distinguish too; markers, dashes and lightness
//! say the same without any color. Text is 8 pt where a chart is set 8 cm wide, `proportions` of two factors at 12 cm.

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

/// Every chart for which there is something to draw, in the order of a report.
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
