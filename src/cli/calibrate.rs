//! `machband calibrate`

use std::path::{Path, PathBuf};

use jiff::civil::Date;
use serde_json::{Value, json};

use super::{OutPath, columns, message, print_line, report_written};
use crate::{
    display::{
        Measurement,
        photometer::{Calibration, Family, FittedChannel, Sum, largest},
    },
    report::{document::Shown, figures},
    store::{Writer, profile, readings},
    work::{RequestError, outdated, today},
};

/// Make a display profile from photometer readings.
///
/// READINGS.csv has the columns channel,level,luminance_cd_m2. The channel is r, g, b or gray; the level is the code
/// divided by the largest code, 0 to 1. List the readings in the order in which you took them, including repeats.
#[derive(clap::Args)]
#[command(
    after_help = "Example: machband calibrate left.csv --out left.toml --with \"Konica Minolta LS-150\" --plot left.svg\n\n\
    Models: srgb is the sRGB curve; gamma is black + range·V^γ; gog adds an offset, (gain·V + offset)^γ; table\n\
    interpolates the readings, for displays that no curve fits. auto leaves out each level in turn and chooses the\n\
    simplest of the models that predict the omitted levels best."
)]
pub(super) struct Arguments {
    /// Photometer readings.
    #[arg(value_name = "READINGS.csv")]
    readings: PathBuf,
    /// Display profile to write.
    #[arg(long, value_name = "PROFILE.toml")]
    out: OutPath,
    /// Name of the display [default: the profile's file name].
    #[arg(long)]
    name: Option<String>,
    /// Name of the person who took the readings.
    #[arg(long, value_name = "WHO")]
    by: Option<String>,
    /// Name of the photometer.
    #[arg(long, value_name = "PHOTOMETER", default_value = "photometer")]
    with: String,
    /// Date of the measurement, such as 2026-01-31 [default: today].
    #[arg(long, value_name = "DATE")]
    on: Option<Date>,
    /// Model of the profile.
    #[arg(long, default_value = "auto", value_parser = ["auto", "gamma", "gog", "srgb", "table"])]
    model: String,
    /// Where to write a chart of the readings, curves and errors.
    #[arg(long, value_name = "FILE.svg|FILE.png")]
    plot: Option<OutPath>,
    /// Where to write all results as JSON.
    #[arg(long, value_name = "FILE.json")]
    report: Option<OutPath>,
}

pub(super) fn run(arguments: &Arguments, writer: &Writer) -> anyhow::Result<()> {
    check(arguments)?;
    let readings = readings::open(&arguments.readings)?;
    let calibration = Calibration::new(&readings);
    let requested = Family::ALL.into_iter().find(|family| family.name() == arguments.model);
    let family = requested.unwrap_or(calibration.chosen);
    print(arguments, &calibration, family)?;
    let stem = arguments.out.file_stem().map_or_else(|| "display".into(), |stem| stem.to_string_lossy().into_owned());
    let measured = Measurement {
        on: Some(arguments.on.unwrap_or_else(today)),
        by: arguments.by.clone(),
        with: Some(arguments.with.clone()),
    };
    let made = calibration.profile(family, arguments.name.as_deref().unwrap_or(&stem), measured);
    let done = if arguments.out.exists() { "replaced" } else { "wrote" };
    profile::write(writer, &arguments.out, &made)?;
    if let Some(path) = &arguments.plot {
        plot(writer, path, &calibration)?;
        report_written(path)?;
    }
    if let Some(path) = &arguments.report {
        writer.write(path, format!("{:#}\n", report(&calibration, family)).as_bytes())?;
        report_written(path)?;
    }
    outdated(&arguments.out, &made).iter().for_each(|warning| message("warning", warning));
    print_line(&format!("{done} {}: {}", arguments.out.display(), made.sentence()))
}

fn check(arguments: &Arguments) -> Result<(), RequestError> {
    match &arguments.plot {
        Some(path) if !has_extension(path, "svg") && !has_extension(path, "png") => Err(RequestError::whole(format!(
            "--plot {} is neither an SVG nor a PNG file; expected a name ending in .svg or .png",
            path.display()
        ))),
        _ => Ok(()),
    }
}

fn has_extension(path: &Path, extension: &str) -> bool {
    path.extension().is_some_and(|found| found.eq_ignore_ascii_case(extension))
}

fn plot(writer: &Writer, path: &Path, calibration: &Calibration) -> anyhow::Result<()> {
    let figure = figures::calibration(calibration);
    let bytes = if has_extension(path, "png") { figure.png()? } else { figure.svg.into_bytes() };
    Ok(writer.write(path, &bytes)?)
}

/// Prints the results as text.
fn print(arguments: &Arguments, calibration: &Calibration, family: Family) -> anyhow::Result<()> {
    let channels: Vec<&str> = calibration.readings.channels().iter().map(|channel| channel.name()).collect();
    let (file, readings) = (arguments.readings.display(), calibration.readings.all().len());
    let (scatter, light) = (100.0 * calibration.noise, calibration.luminance_of(family));
    print_line(&format!(
        "{file}: {readings} readings of {}; repeated readings vary by {scatter:.2} %",
        channels.join(", ")
    ))?;
    print_line(&format!("black {:.4} cd/m², white {:.2} cd/m²", light.black_cd_m2, light.white_cd_m2))?;
    print_line("")?;
    let largest_error = ["largest error, codes", "cd/m²"];
    let header = [&["model", "channel", "gamma", "gain", "offset", "R²"], &largest_error[..]].concat();
    let models = || calibration.models.iter();
    let rows = models().flat_map(|model| model.channels.iter().map(|channel| cells(model.family, channel)));
    columns(&header, &rows.collect::<Vec<_>>()).iter().try_for_each(|line| print_line(line))?;
    print_line("")?;
    print_line("leave-one-level-out error")?;
    let header = ["model", "rms codes", "rms cd/m²", "largest codes", "relative to noise"];
    let rows = models().map(|model| {
        let found = &model.validation;
        vec![
            model.family.name().into(),
            decimals(found.rms_codes, 2),
            decimals(found.rms_cd_m2, 3),
            decimals(found.largest_codes, 2),
            decimals(found.score.sqrt(), 2),
        ]
    });
    columns(&header, &rows.collect::<Vec<_>>()).iter().try_for_each(|line| print_line(line))?;
    print_line("")?;
    let sums = &calibration.additivity;
    if !sums.is_empty() {
        print_line(&format!(
            "additivity: gray differs from red + green + blue − 2 black by at most {:+.2} % and {:+.3} cd/m²",
            largest(sums, Sum::deviation_percent),
            largest(sums, Sum::deviation_cd_m2),
        ))?;
    }
    calibration.notes.iter().try_for_each(|note| print_line(&format!("note: {note}")))?;
    let better = calibration.chosen;
    print_line(&format!("best by cross-validation: {better} (the simplest of the best-predicting models)"))?;
    print_line(&format!("chosen: {family}{}", if arguments.model == "auto" { "" } else { ", as requested" }))
}

/// Formats a number with this many decimals.
fn decimals(number: f64, decimals: usize) -> Shown {
    Shown::new(number, format!("{number:.decimals$}"))
}

fn cells(family: Family, channel: &FittedChannel) -> Vec<Shown> {
    let known = |value: Option<f64>, text: &dyn Fn(f64) -> String| {
        Shown::new(value, value.map_or_else(|| "—".to_owned(), text))
    };
    let se = channel.gamma_se.map_or_else(String::new, |se| format!(" ± {se:.4}"));
    let (gain, offset) = channel.curve.gain_and_offset().unzip();
    vec![
        family.name().into(),
        channel.channel.name().into(),
        known(channel.curve.gamma(), &|gamma| format!("{gamma:.4}{se}")),
        known(gain, &|gain| format!("{gain:.4}")),
        known(offset, &|offset| format!("{offset:+.4}")),
        decimals(channel.r_squared, 6),
        decimals(channel.largest_codes, 2),
        decimals(channel.largest_cd_m2, 3),
    ]
}

/// Returns the results as JSON.
fn report(calibration: &Calibration, family: Family) -> Value {
    let models = calibration.models.iter().map(|model| {
        json!({
            "model": model.family.name(),
            "common_shape": model.common_shape,
            "channels": model.channels.iter().map(channel_json).collect::<Value>(),
            "cross_validation": model.validation,
        })
    });
    let sums = &calibration.additivity;
    let additivity = (!sums.is_empty()).then(|| {
        let levels = sums.iter().map(|sum| {
            json!({
                "level": sum.level,
                "gray_cd_m2": sum.gray_cd_m2,
                "sum_cd_m2": sum.sum_cd_m2,
                "deviation_percent": sum.deviation_percent(),
            })
        });
        json!({
            "largest_percent": largest(sums, Sum::deviation_percent),
            "largest_cd_m2": largest(sums, Sum::deviation_cd_m2),
            "levels": levels.collect::<Value>(),
        })
    });
    json!({
        "readings": calibration.readings.all().len(),
        "noise": { "relative": calibration.noise },
        "luminance": calibration.luminance_of(family),
        "models": models.collect::<Value>(),
        "chosen": family.name(),
        "better_by_cross_validation": calibration.chosen.name(),
        "additivity": additivity,
        "drift_percent": calibration.drift_percent,
        "notes": calibration.notes,
    })
}

fn channel_json(channel: &FittedChannel) -> Value {
    let gain_and_offset = channel.curve.gain_and_offset();
    json!({
        "channel": channel.channel.key(),
        "gamma": channel.curve.gamma(),
        "gamma_se": channel.gamma_se,
        "gain": gain_and_offset.map(|(gain, _)| gain),
        "offset": gain_and_offset.map(|(_, offset)| offset),
        "black_cd_m2": channel.curve.black_cd_m2,
        "range_cd_m2": channel.curve.range_cd_m2,
        "r_squared": channel.r_squared,
        "largest_error_codes": channel.largest_codes,
        "largest_error_cd_m2": channel.largest_cd_m2,
    })
}
