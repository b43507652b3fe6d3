//! The luminance profile of a stimulus as CSV.

use crate::{
    light::{Dither, LinearImage, Quantizer},
    stimulus::{place, recipe::Recipe},
    text::{Column, Table},
};

/// One point of a profile.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Distance from the center along the orientation, in window widths.
    pub x: f64,
    /// Requested light of the strongest channel.
    pub linear: f64,
    /// Codes of red, green and blue.
    pub codes: [u16; 3],
    /// Light that the strongest channel's code emits.
    pub emitted: f64,
}

/// Samples the profile at the pixel centers for the recipe's size, along a line through the center in the direction of
/// the orientation, dithered like a row of pixels.
pub fn samples(recipe: &Recipe, quantizer: &Quantizer) -> Vec<Sample> {
    let (stimulus, size) = (&recipe.stimulus, recipe.size);
    let strongest = stimulus.strongest_channel();
    let light = stimulus.profile(size);
    let row = LinearImage::from_fn(size, 1, |i, _| light[i as usize]);
    let codes = match &recipe.dither {
        Dither::None => quantizer.quantize(&row),
        dither => quantizer.quantize_with(&row, &dither.with_seed(recipe.seed)),
    };
    (0..size)
        .map(|i| {
            let pixel = codes.pixel(i, 0);
            Sample {
                x: place(i, size),
                linear: f64::from(row.pixel(i, 0)[strongest]),
                codes: pixel,
                emitted: quantizer.channel(strongest).linear(pixel[strongest]),
            }
        })
        .collect()
}

/// Returns a profile as a table: `x, linear, code_r, code_g, code_b, emitted`; see [`Sample`].
pub fn table(recipe: &Recipe, quantizer: &Quantizer) -> Table {
    let columns = [
        ("x", "proportion of the stimulus window", "Distance from the center along the orientation."),
        ("linear", "relative luminance, linear light", "Requested light of the strongest channel."),
        ("code_r", "", "Code of red."),
        ("code_g", "", "Code of green."),
        ("code_b", "", "Code of blue."),
        ("emitted", "relative luminance, linear light", "Light that the strongest channel's code emits."),
    ];
    let columns = columns.map(|(name, unit, description)| Column::new(name, unit, description)).to_vec();
    let row = |Sample { x, linear, codes: [r, g, b], emitted }: &Sample| {
        vec![(*x).into(), (*linear).into(), (*r).into(), (*g).into(), (*b).into(), (*emitted).into()]
    };
    Table::new(columns, samples(recipe, quantizer).iter().map(row))
}
