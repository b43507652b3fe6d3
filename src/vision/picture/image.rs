//! An image, and the prediction for it.

use crate::vision::band::{Band, Visibility};

/// An image in linear light.
#[derive(Clone, Copy, Debug)]
pub struct Picture<'a> {
    /// Luminance, 1 for white, row by row from the upper left corner.
    pub light: &'a [f64],
    /// Columns.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Pixels in a degree.
    pub px_per_deg: f64,
    /// Where bands count, as long as the light: without it everywhere.
    pub mask: Option<&'a [bool]>,
}

/// The prediction for an image.
#[derive(Clone, Debug, Default)]
pub struct PictureView {
    /// Of every channel, at every place of its lines, the strongest first.
    pub bands: Vec<Band>,
    /// Of the strongest place, over all channels.
    pub visibility: Visibility,
    /// How much band there is: strength times length over the area judged, for every channel, added up over channels
    /// as visibility is; per degree.
    pub density: f64,
    /// Strength of bright and of dark bands at every pixel, over all channels.
    pub map: BandMap,
}

/// Lines of bands, drawn one pixel wide.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BandMap {
    /// Bright bands.
    pub bright: Vec<f64>,
    /// Dark bands.
    pub dark: Vec<f64>,
}
