//! `machband calibrate`

use super::{OutPath, columns, message, print_line};
use crate::{
    report::figures::calibration_tables,
    store::{Writer, profile},
    system::found,
    work::{calibrate::Calibrate, outdated},
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
    made.sentences().iter().try_for_each(|sentence| print_line(sentence))?;
    for table in calibration_tables(&made.calibration) {
        print_line("")?;
        print_line(&table.caption)?;
        let header: Vec<&str> = table.header.iter().map(String::as_str).collect();
        columns(&header, &table.rows).iter().try_for_each(|line| print_line(line))?;
    }
    print_line("")?;
    made.calibration.notes.iter().try_for_each(|note| print_line(&format!("note: {note}")))?;
    let done = if found(out)?.is_some() { "replaced" } else { "wrote" };
    profile::write(writer, out, &made.profile)?;
    outdated(out, &made.profile).iter().for_each(|warning| message("warning", warning));
    print_line(&format!("{done} {}: {}", out.display(), made.profile.sentence()))
}
