//! `machband stimulus`

use std::{path::PathBuf, str::FromStr as _};

use super::UsageError;
use crate::{
    light::{Bits, Quantizer, Transfer},
    stimulus::{KINDS, ParameterValue, Stimulus},
    store,
};

/// Write one stimulus as an image, and its luminance profile.
#[derive(clap::Args)]
#[command(after_help = "Example: machband stimulus --width 0.2 --depth inf --orientation 45 --out ramp.png --profile ramp.csv")]
pub(super) struct Arguments {
    /// Kind of stimulus.
    #[arg(long, default_value = "mach-band", value_parser = clap::builder::PossibleValuesParser::new(KINDS))]
    kind: String,
    /// Width of the ramp as a proportion of the image, 0 to 1.
    #[arg(long, value_name = "W", default_value = "0.4", allow_hyphen_values = true)]
    width: String,
    /// Continuity depth, 1 to 32 or inf.
    #[arg(long, value_name = "N|inf", default_value = "1", allow_hyphen_values = true)]
    depth: String,
    /// Steepness of the depth inf: (1+tanh(k(u-1/2)))/2. 5 is the paper's; 10 leaves no step at the ends.
    #[arg(long, value_name = "K", default_value = "5", allow_hyphen_values = true)]
    tanh_k: String,
    /// Direction in which the ramp brightens, in degrees counter-clockwise from the right.
    #[arg(long, value_name = "DEG", default_value = "0", allow_hyphen_values = true)]
    orientation: String,
    /// Relative luminance of the darker plateau, linear light.
    #[arg(long, value_name = "L", default_value = "0.25", allow_hyphen_values = true)]
    low: String,
    /// Relative luminance of the brighter plateau, linear light.
    #[arg(long, value_name = "L", default_value = "0.75", allow_hyphen_values = true)]
    high: String,
    /// yellow, gray, or linear weights R,G,B.
    #[arg(long, default_value = "yellow", allow_hyphen_values = true)]
    color: String,
    /// Side of the image in pixels.
    #[arg(long, value_name = "PX", default_value_t = 1024, value_parser = clap::value_parser!(u32).range(1..=16384))]
    size: u32,
    /// Transfer function of the display: srgb, linear or gamma:G.
    #[arg(long, conflicts_with = "display")]
    transfer: Option<String>,
    /// Display profile.
    #[arg(long, value_name = "FILE")]
    display: Option<PathBuf>,
    /// Bits a channel.
    #[arg(long, default_value = "8", value_parser = ["8", "16"])]
    bits: String,
    /// Dither.
    #[arg(long, default_value = "none", value_parser = ["none"])]
    dither: String,
    /// Image to write.
    #[arg(long, value_name = "FILE.png")]
    out: Option<PathBuf>,
    /// Profile across the ramp to write.
    #[arg(long, value_name = "FILE.csv")]
    profile: Option<PathBuf>,
}

pub(super) fn run(arguments: &Arguments) -> anyhow::Result<()> {
    if arguments.out.is_none() && arguments.profile.is_none() {
        return Err(UsageError("nothing to write; expected --out FILE.png or --profile FILE.csv".to_owned()).into());
    }
    let stimulus = stimulus(arguments)?;
    let quantizer = Quantizer::new(&transfer(arguments)?, Bits::from_str(&arguments.bits)?);
    if let Some(out) = &arguments.out {
        store::image::write_png(out, &stimulus.codes(arguments.size, &quantizer), quantizer.transfer())?;
    }
    if let Some(profile) = &arguments.profile {
        store::curve::write_profile(profile, &stimulus, arguments.size, &quantizer)?;
    }
    Ok(())
}

fn stimulus(arguments: &Arguments) -> anyhow::Result<Stimulus> {
    let usage = |message: String| UsageError(message);
    let mut stimulus = Stimulus::default_of(&arguments.kind)
        .ok_or_else(|| usage(format!("kind {} is not known; expected one of {}", arguments.kind, KINDS.join(", "))))?;
    let given = [
        ("width", &arguments.width),
        ("depth", &arguments.depth),
        ("tanh_k", &arguments.tanh_k),
        ("orientation_deg", &arguments.orientation),
        ("low", &arguments.low),
        ("high", &arguments.high),
        ("color", &arguments.color),
    ];
    let mut faults = Vec::new();
    for (name, text) in given {
        let value = ParameterValue::from_str(text).unwrap_or_else(|never| match never {});
        if let Err(error) = stimulus.set(name, &value) {
            faults.push(error.to_string());
        }
    }
    if faults.is_empty()
        && let Err(errors) = stimulus.validate()
    {
        faults.extend(errors.iter().map(ToString::to_string));
    }
    if faults.is_empty() { Ok(stimulus) } else { Err(usage(faults.join("\n")).into()) }
}

fn transfer(arguments: &Arguments) -> anyhow::Result<Transfer> {
    match (&arguments.display, &arguments.transfer) {
        (Some(path), _) => Ok(store::profile::open(path)?.transfer),
        (None, Some(text)) => text.parse().map_err(|error| UsageError(format!("{error}")).into()),
        (None, None) => Ok(Transfer::Srgb),
    }
}
