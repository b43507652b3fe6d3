//! Charts of a study's results, for print: SVG, and PNG of the same drawing.
//!
//! Colours are those of Okabe & Ito (2008), told apart by colour-blind readers too; markers, dashes and lightness tell
//! the same without any colour. Text is 8 pt where a chart is set 8 cm wide, `proportions` of two factors at 12 cm.

mod axes;
mod calibration;
pub mod intervals;
mod labels;
mod palette;
mod raster;
mod svg;

mod effects;
mod means;
mod orientation;

mod proportions;
mod regroup;

mod subjects;

mod times;

use rayon::prelude::*;

use crate::analysis::Results;

pub use calibration::calibration;
pub use raster::FigureError;

/// A chart.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Figure {
    /// Stem of its file's name, such as `figure4a`.
    pub name: &'static str,
    /// What it shows, a heading.
    pub title: String,
    /// What is drawn how, and from how many ratings: one or two sentences.
    pub caption: String,
    /// Whether it is made for the full width of a page, and not for a column.
    pub wide: bool,
    /// The chart, 800 units wide. Text is text; it needs no file besides.
    pub svg: String,
}

impl Figure {
    /// The chart as an image of 1600 pixels across; equal bytes on every machine.
    ///
    /// # Errors
    /// A drawing that cannot be rendered or encoded.
    pub fn png(&self) -> Result<Vec<u8>, FigureError> {
        raster::png(&self.svg)
    }
}

/// Every chart for which there is something to draw, in the order of a report.
pub fn all(results: &Results) -> Vec<Figure> {
    let kinds: [fn(&Results) -> Vec<Figure>; 6] = [
        means::figures,
        proportions::figures,
        subjects::figures,
        orientation::figures,
        effects::figures,
        times::figures,
    ];
    kinds.par_iter().flat_map_iter(|kind| kind(results)).collect()
}

/// Figure 4 as the model of vision predicts it: `figure4a_predicted`, `figure4b_predicted`. `expected` is the rating in
/// each of the counts' conditions, in the numbers of the categories; `None` where nothing is predicted.
pub fn predicted(results: &Results, expected: &[Option<f64>]) -> Vec<Figure> {
    means::predicted(results, expected)
}
