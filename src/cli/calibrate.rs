//! `machband calibrate`

use super::{OutPath, columns, message, print_line};
use crate::{
    display::photometer::largest_percent,
    report::{document::TextTable, figures::calibration_tables},
    store::{Writer, profile},
    system::found,
    work::{
        calibrate::{Calibrate, Calibrated},
        outdated,
    },
};

/// Make a display profile from photometer readings.
///
/// READINGS.csv has the columns channel,level,luminance_cd_m2. The channel is r, g, b or gray; the level is the code
/// divided by the largest code, 0 to 1. List the readings in the order in which you took them, including repeats.
#[derive(clap::Args)]
#[command(after_help = "Example: machband calibrate left.csv --out left.toml --with \"Konica Minolta LS-150\"\n\n\
    Models: srgb is the sRGB curve; gamma is black + range·V^γ; gog adds an offset, (gain·V + offset)^γ; table \
    interpolates the readings, for displays that no curve fits. By default, each level is left out in turn, \
    and the simplest of the models that predict the left-out levels best is chosen.")]
pub(super) struct Arguments {
    #[command(flatten)]
    request: Calibrate,
    /// Display profile to write.
    #[arg(long, value_name = "PROFILE.toml")]
    out: OutPath,
}

pub(super) fn run(arguments: &Arguments, writer: &Writer) -> anyhow::Result<()> {
    let Arguments { request, out } = arguments;
    let stem = out.file_stem().map_or_else(|| "display".into(), |stem| stem.to_string_lossy().into_owned());
    let made = request.calibrate(&stem)?;
    print(request, &made)?;
    let done = if found(out)?.is_some() { "replaced" } else { "wrote" };
    profile::write(writer, out, &made.profile)?;
    outdated(out, &made.profile).iter().for_each(|warning| message("warning", warning));
    print_line(&format!("{done} {}: {}", out.display(), made.profile.sentence()))
}

/// Prints the results as text.
fn print(request: &Calibrate, made: &Calibrated) -> anyhow::Result<()> {
    let Calibrated { calibration, family, .. } = made;
    let channels: Vec<&str> = calibration.readings.channels().iter().map(|channel| channel.name()).collect();
    let (file, readings) = (request.readings.display(), calibration.readings.all().len());
    let (misfit, light) = (100.0 * calibration.misfit, calibration.luminance_of(*family));
    print_line(&format!(
        "{file}: {readings} readings of {}; they differ from the chosen model by {misfit:.2} %",
        channels.join(", ")
    ))?;
    print_line(&format!("black {:.4} cd/m², white {:.2} cd/m²", light.black_cd_m2, light.white_cd_m2))?;
    print_line("")?;
    let [fits, validation] = calibration_tables(calibration);
    print_table(&fits)?;
    print_line("")?;
    print_line(&validation.caption)?;
    print_table(&validation)?;
    print_line("")?;
    let sums = &calibration.additivity;
    if !sums.is_empty() {
        print_line(&format!(
            "additivity: gray differs from red + green + blue − 2 black by at most {:.2} %",
            largest_percent(sums).abs(),
        ))?;
    }
    calibration.notes.iter().try_for_each(|note| print_line(&format!("note: {note}")))?;
    let better = calibration.chosen;
    print_line(&format!("best by cross-validation: {better} (the simplest of the best-predicting models)"))?;
    print_line(&format!("chosen: {family}{}", if request.model.is_some() { ", as requested" } else { "" }))
}

fn print_table(table: &TextTable) -> anyhow::Result<()> {
    let header: Vec<&str> = table.header.iter().map(String::as_str).collect();
    columns(&header, &table.rows).iter().try_for_each(|line| print_line(line))
}
