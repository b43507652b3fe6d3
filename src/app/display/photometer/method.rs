//! How a screen is measured with a photometer.

use std::path::Path;

use eframe::egui;

use super::{
    findings::PhotometerFindings,
    patches::{PatchRun, PatchView},
};
use crate::{
    app::{
        display::calibrate::Method,
        ui::{Field, number},
    },
    display::{
        Channel, Viewing,
        photometer::{Patch, PatchSettings, patches},
    },
};

/// Seconds that reading and typing take, for the estimate.
const READING_S: f64 = 5.0;

/// The settings.
pub struct Photometer {
    levels: usize,
    repeats: usize,
    settle_s: String,
    percent: u32,
    gray_around: bool,
}

impl Default for Photometer {
    fn default() -> Self {
        let PatchSettings { levels, repeats, .. } = PatchSettings::default();
        Self { levels, repeats, settle_s: "1".to_owned(), percent: 40, gray_around: false }
    }
}

impl Photometer {
    fn settle_s(&self) -> Result<f64, String> {
        let seconds = number(&self.settle_s).filter(|seconds| (0.0..=60.0).contains(seconds));
        seconds.ok_or_else(|| format!("{:?} is not a time to settle; expected seconds, 0 to 60.", self.settle_s))
    }

    fn patches(&self, channels: &[Channel]) -> Result<Vec<Patch>, String> {
        let (levels, repeats) = (self.levels, self.repeats);
        let settings = PatchSettings { channels: channels.to_vec(), levels, repeats, ..PatchSettings::default() };
        patches(&settings).map_err(|error| format!("{error}."))
    }
}

impl Method for Photometer {
    type Findings = PhotometerFindings;
    type Run = PatchRun;

    const BEGIN: &'static str = "Show patches";
    const FORMAT: &'static str = "CSV with the columns channel,level,luminance_cd_m2: channel r, g, b or gray; level the code divided by the largest code, 0 to 1.";
    const INTRODUCTION: &'static str = "Patches are shown one by one; type what the photometer reads. Let the screen warm up for half an hour, and darken the room.";
    const ITEMS: &'static str = "readings";
    const TITLE: &'static str = "Photometer";

    fn fields(&mut self, ui: &mut egui::Ui, _: Option<&Viewing>) {
        Field::new("Levels of each channel").slider(ui, &mut self.levels, 5..=33, 1.0);
        Field::new("Readings of each patch").slider(ui, &mut self.repeats, 1..=5, 1.0);
        Field::new("Seconds to settle").width(70.0).text(ui, &mut self.settle_s);
        Field::new("Height of the patch, % of the screen").slider(ui, &mut self.percent, 10..=80, 1.0);
        ui.checkbox(&mut self.gray_around, "Gray around the patch instead of black");
    }

    fn extent(&self, channels: &[Channel]) -> Result<(usize, f64), String> {
        let patches = self.patches(channels)?.len();
        Ok((patches, patches as f64 * (self.settle_s()? + READING_S)))
    }

    fn begin(&self, channels: &[Channel], file: &Path) -> Result<PatchRun, String> {
        let view = PatchView { settle_s: self.settle_s()?, percent: self.percent, gray_around: self.gray_around };
        PatchRun::begin(self.patches(channels)?, file, view).map_err(|error| error.to_string())
    }
}
