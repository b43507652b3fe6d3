//! A chart with its title and caption.

use super::{
    raster::{self, FigureError, Pixels},
    svg::Svg,
};

/// A chart.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    /// Stem of its file's name, such as `figure4a`.
    pub name: &'static str,
    /// What it shows, a heading.
    pub title: String,
    /// What is drawn how, and from how many ratings: one or two sentences.
    pub caption: String,
    /// Whether it is made for the full width of a page, and not for a column.
    pub wide: bool,
    /// Its height where it is 800 wide.
    pub height: f64,
    /// The chart, 800 units wide. Text is text; it needs no file besides.
    pub svg: String,
}

impl Figure {
    pub(super) fn draw(
        name: &'static str,
        title: String,
        caption: String,
        height: f64,
        paint: impl FnOnce(&mut Svg),
    ) -> Self {
        let svg = Svg::draw(height, &title, &caption, paint);
        Self { name, title, caption, wide: false, height, svg }
    }

    /// The chart as an image of 1600 pixels across; equal bytes on every machine.
    ///
    /// # Errors
    /// A drawing that cannot be rendered or encoded.
    pub fn png(&self) -> Result<Vec<u8>, FigureError> {
        raster::png(&self.pixels(1600)?)
    }

    /// The chart as pixels, so many across.
    ///
    /// # Errors
    /// A drawing that cannot be rendered.
    pub fn pixels(&self, width: u32) -> Result<Pixels, FigureError> {
        raster::pixels(&self.svg, width)
    }
}
