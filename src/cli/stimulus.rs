//! `machband stimulus`

use std::path::PathBuf;

use super::{
    UsageError,
    options::{ImageOptions, StimulusOptions},
};
use crate::store;

/// Write one stimulus as an image, and its luminance profile.
#[derive(clap::Args)]
#[command(
    after_help = "Example: machband stimulus --width 0.2 --depth inf --orientation 45 --out ramp.png --profile ramp.csv"
)]
pub(super) struct Arguments {
    #[command(flatten)]
    stimulus: StimulusOptions,
    #[command(flatten)]
    image: ImageOptions,
    /// Image to write.
    #[arg(long, value_name = "FILE.png")]
    out: Option<PathBuf>,
    /// Profile along the orientation, through the centre, to write.
    #[arg(long, value_name = "FILE.csv")]
    profile: Option<PathBuf>,
}

pub(super) fn run(arguments: &Arguments) -> anyhow::Result<()> {
    if arguments.out.is_none() && arguments.profile.is_none() {
        return Err(UsageError("nothing to write; expected --out FILE.png or --profile FILE.csv".to_owned()).into());
    }
    let recipe = arguments.image.recipe(arguments.stimulus.stimulus()?)?;
    let quantizer = recipe.quantizer();
    if let Some(out) = &arguments.out {
        store::image::write_recipe(out, &recipe, &quantizer)?;
    }
    if let Some(profile) = &arguments.profile {
        store::curve::write_profile(profile, &recipe, &quantizer)?;
    }
    Ok(())
}
