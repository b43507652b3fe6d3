//! `machband timing`

use std::sync::mpsc;

use super::OutPath;
use crate::{
    app,
    app::timing::{FLICKER_WARNING, Patch, Place, Scene, TimingPlan, TimingRequest},
    report::figures,
    store::Writer,
    text::number::whole,
};

/// Measure frame intervals.
///
/// Opens a window whose content changes in every frame, and reports the frame intervals, their percentiles, dropped
/// frames (intervals longer than 1.5 refreshes), missed refreshes, and whether the frames follow a steady refresh at
/// all. The patch is a target for a photodiode, because only its light shows when a frame reaches the eye.
///
/// With the scene `patch`, a small patch flickers at the screen's refresh rate. Do not look at it.
#[derive(clap::Args)]
#[command(after_help = "Example: machband timing --frames 1800 --fullscreen --out intervals.csv --plot intervals.svg")]
pub(super) struct Arguments {
    /// Number of frames to measure.
    #[arg(long, value_name = "N", default_value_t = 600, value_parser = whole::<u32>(2..=10_000_000))]
    frames: u32,
    /// Use the full screen.
    #[arg(long, conflicts_with = "windowed")]
    fullscreen: bool,
    /// Use a window; this is the default.
    #[arg(long)]
    windowed: bool,
    /// What to draw: a flickering patch, or the screen of a trial.
    #[arg(long, default_value = "patch")]
    scene: Scene,
    /// Side of the patch in pixels.
    #[arg(long, value_name = "PX", default_value_t = Patch::default().size_px, value_parser = whole::<u32>(1..=8192))]
    size: u32,
    /// Position of the patch.
    #[arg(long, default_value = "corner")]
    place: Place,
    /// Where to write every interval as CSV.
    #[arg(long, value_name = "FILE.csv")]
    out: Option<OutPath>,
    /// Where to write a chart of the intervals.
    #[arg(long, value_name = "FILE.svg")]
    plot: Option<OutPath>,
}

pub(super) fn run(arguments: &Arguments, writer: &Writer) -> anyhow::Result<()> {
    let patch = Patch { size_px: arguments.size, place: arguments.place };
    let plan = TimingPlan { scene: arguments.scene, frames: arguments.frames, patch };
    if plan.scene == Scene::Patch {
        super::message("warning", FLICKER_WARNING);
    }
    let (report, measured) = mpsc::channel();
    app::time(TimingRequest { plan, fullscreen: arguments.fullscreen, report })?;
    let found = measured.try_recv().map_err(|_| {
        anyhow::anyhow!(
            "timing: the window was closed before {} frames were measured; expected it to close by itself",
            plan.frames
        )
    })?;
    for (name, value) in found.rows() {
        super::print_line(&format!("{name:<18}{value}"))?;
    }
    super::print_line(&found.verdict())?;
    if let Some(path) = &arguments.out {
        writer.write(path, found.csv().as_bytes())?;
        super::report_written(path)?;
    }
    if let Some(path) = &arguments.plot {
        writer.write(path, figures::intervals(found.intervals_us(), found.refresh).svg.as_bytes())?;
        super::report_written(path)?;
    }
    Ok(())
}
