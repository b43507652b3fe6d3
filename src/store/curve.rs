//! The luminance profile of a stimulus as CSV.

use crate::{
    light::{LinearImage, Quantizer},
    stimulus::{place, recipe::Recipe},
    text::{Cell, Column, Table},
};

/// Returns the profile at the pixel centers for the recipe's size, along a line through the center in the direction of the
/// orientation, dithered like a row of pixels.
pub fn table(recipe: &Recipe, quantizer: &Quantizer) -> Table {
    const LIGHT: &str = "relative luminance, linear light";
    let (stimulus, size) = (&recipe.stimulus, recipe.size);
    let strongest = stimulus.strongest_channel();
    let light = stimulus.profile(size);
    let row = LinearImage::from_fn(size, 1, |i, _| light[i as usize]);
    let codes = quantizer.quantize_with(&row, &recipe.dither.with_seed(recipe.seed));
    let column = |name: &str, unit: &str, description: &str, cell: &dyn Fn(u32) -> Cell| Column {
        cells: (0..size).map(cell).collect(),
        ..Column::new(name, unit, description)
    };
    let code = |channel: usize, i: u32| codes.pixel(i, 0)[channel];
    let emitted = |i| quantizer.channel(strongest).linear(code(strongest, i));
    Table {
        columns: vec![
            column("x", "proportion of the stimulus window", "Distance from the center along the orientation.", &|i| {
                place(i, size).into()
            }),
            column("linear", LIGHT, "Requested light of the strongest channel.", &|i| {
                f64::from(light[i as usize][strongest]).into()
            }),
            column("code_r", "", "Code of red.", &|i| code(0, i).into()),
            column("code_g", "", "Code of green.", &|i| code(1, i).into()),
            column("code_b", "", "Code of blue.", &|i| code(2, i).into()),
            column("emitted", LIGHT, "Light that the strongest channel's code emits.", &|i| emitted(i).into()),
        ],
    }
}
