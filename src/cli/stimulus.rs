//! `machband stimulus`

use std::path::PathBuf;

use super::{
    UsageError,
    options::{ImageOptions, StimulusOptions},
    wrote,
};
use crate::{
    light::{Bits, Quantizer, halftone::Screen, palette::Reduction},
    stimulus::recipe::Recipe,
    store,
};

/// Write one stimulus as an image, and its luminance profile as a table.
#[derive(clap::Args)]
#[command(
    after_help = "Example: machband stimulus --width 0.2 --depth inf --orientation 45 --out ramp.png --profile ramp.csv"
)]
pub(super) struct Arguments {
    #[command(flatten)]
    stimulus: StimulusOptions,
    #[command(flatten)]
    image: ImageOptions,
    /// Reduce the image to a palette: the method (popularity, median-cut or k-means) and the largest number of colors,
    /// such as median-cut:16.
    #[arg(long, value_name = "METHOD:N", requires = "out")]
    palette: Option<String>,
    /// Draw each pixel as a cell of dots, for a device with few codes such as a printer: the matrix and the bits per
    /// channel, such as clustered3:1.
    #[arg(long, value_name = "MATRIX:BITS", requires = "out", conflicts_with = "palette")]
    halftone: Option<String>,
    /// Where to write the image.
    #[arg(long, value_name = "FILE.png")]
    out: Option<PathBuf>,
    /// Where to write the luminance profile through the center, along the orientation.
    #[arg(long, value_name = "FILE.csv")]
    profile: Option<PathBuf>,
}

pub(super) fn run(arguments: &Arguments) -> anyhow::Result<()> {
    if arguments.out.is_none() && arguments.profile.is_none() {
        return Err(UsageError("nothing to write; expected --out FILE.png or --profile FILE.csv".to_owned()).into());
    }
    let recipe = arguments.image.recipe(arguments.stimulus.stimulus()?)?;
    let quantizer = recipe.quantizer();
    let reduction = arguments.palette.as_deref().map(str::parse::<Reduction>).transpose();
    let reduction = reduction.map_err(|error| UsageError(format!("--palette: {error}")))?;
    let screen = arguments.halftone.as_deref().map(str::parse::<Screen>).transpose();
    let screen = screen.map_err(|error| UsageError(format!("--halftone: {error}")))?;
    if let (Some(out), Some(screen)) = (&arguments.out, screen) {
        store::image::write_halftone(out, &recipe, screen)?;
        return finish(arguments, &recipe, &quantizer);
    }
    match (&arguments.out, reduction) {
        (Some(_), Some(_)) if recipe.bits == Bits::Sixteen => {
            return Err(UsageError("--palette: a palette has 8 bits a channel; expected --bits 8".to_owned()).into());
        }
        (Some(out), Some(reduction)) => {
            let image = store::image::write_reduced(out, &recipe, &quantizer, reduction)?;
            println!(
                "{reduction}: {} colors, error in linear light rms {:.5}, largest {:.5}",
                image.palette.len(),
                image.error.rms,
                image.error.max
            );
        }
        (Some(out), None) => _ = store::image::write_recipe(out, &recipe, &quantizer)?,
        (None, _) => {}
    }
    finish(arguments, &recipe, &quantizer)
}

/// Writes the profile that was requested, and names the files that were written.
fn finish(arguments: &Arguments, recipe: &Recipe, quantizer: &Quantizer) -> anyhow::Result<()> {
    if let Some(profile) = &arguments.profile {
        store::curve::write_profile(profile, recipe, quantizer)?;
    }
    arguments.out.iter().chain(&arguments.profile).try_for_each(|path| wrote(path))
}
