//! Calibration with a photometer: the measurements and the fitted models.

use std::path::Path;

use eframe::egui::{self, Color32};

use super::{
    calibrate::{Findings, LABELS, Method, SLIDER},
    patch_run::PatchRun,
};
use crate::{
    app::{
        analysis::TableView,
        ui::{Field, figure::FigureView, note, show_error},
    },
    display::{
        Channel, DisplayProfile, Measurement, Viewing,
        photometer::{Calibration, Patch, largest_percent, patches},
    },
    report::figures,
    store::readings,
};

/// Gray around a patch; this code emits about a fifth of full light.
const AROUND: Color32 = Color32::from_gray(128);
/// Assumed time to read the photometer and type the reading, seconds.
pub const READING_S: f64 = 5.0;
/// How long a patch may settle, seconds.
pub const SETTLING_S: std::ops::RangeInclusive<f64> = 0.0..=30.0;

/// The settings of the method.
pub struct Photometer {
    levels: usize,
    repeats: usize,
    settle_s: f64,
    percent: u32,
    gray_around: bool,
}

impl Default for Photometer {
    fn default() -> Self {
        Self { levels: 17, repeats: 1, settle_s: 1.0, percent: 40, gray_around: false }
    }
}

impl Photometer {
    fn patches(&self, channels: &[Channel]) -> Result<Vec<Patch>, String> {
        patches(channels, self.levels, self.repeats).map_err(|error| format!("{error}."))
    }
}

impl Method for Photometer {
    type Findings = PhotometerFindings;
    type Run = PatchRun;

    const FORMAT: &'static str = "Readings of other programs can be used: CSV with the columns channel,level,luminance_cd_m2, where channel is r, g, b or gray, and level is the code divided by the largest code, 0 to 1; .ti3 files of ArgyllCMS; monitor files of PsychoPy; .mat files of Psychtoolbox.";
    const INTRODUCTION: &'static str = "Patches are shown one at a time; type each photometer reading. First let the \
        screen warm up for half an hour, and darken the room.";
    const ITEMS: &'static str = "readings";
    const TITLE: &'static str = "Photometer";

    fn fields(&mut self, ui: &mut egui::Ui, _: Option<&Viewing>) {
        let field = |label| Field::new(label).column(LABELS).width(SLIDER);
        field("Levels per channel").slider(ui, &mut self.levels, 5..=33, 1.0);
        field("Readings per patch").slider(ui, &mut self.repeats, 1..=5, 1.0);
        field("Settling time, seconds").slider(ui, &mut self.settle_s, SETTLING_S, 0.5);
        field("Patch height, % of the screen").slider(ui, &mut self.percent, 10..=80, 1.0);
        Field::new("").column(LABELS).show(ui, |ui, _| {
            ui.checkbox(&mut self.gray_around, "Gray around the patch instead of black");
        });
    }

    fn estimate(&self, channels: &[Channel]) -> Result<(usize, f64), String> {
        let patches = self.patches(channels)?.len();
        Ok((patches, patches as f64 * (self.settle_s + READING_S)))
    }

    fn begin(&self, channels: &[Channel], file: &Path) -> Result<PatchRun, String> {
        let around = if self.gray_around { AROUND } else { Color32::BLACK };
        let run = PatchRun::begin(self.patches(channels)?, file, self.settle_s, vec![self.percent], around);
        run.map_err(|error| error.to_string())
    }
}

/// The models fitted to the readings.
pub struct PhotometerFindings {
    calibration: Calibration,
    /// The readings and the curves of the chosen model.
    figure: FigureView,
    tables: [TableView; 2],
}

impl Findings for PhotometerFindings {
    fn read(path: &Path) -> Result<Self, String> {
        let readings = readings::open(path).map_err(|errors| errors.to_string())?;
        let calibration = Calibration::new(&readings);
        let figure = FigureView::new(figures::calibration(&calibration, calibration.chosen));
        let tables = figures::calibration_tables(&calibration).map(TableView::new);
        Ok(Self { calibration, figure, tables })
    }

    fn summary(&mut self, ui: &mut egui::Ui) {
        let calibration = &self.calibration;
        let light = calibration.luminance_of(calibration.chosen);
        ui.label(format!(
            "Black {:.3} cd/m², white {:.1} cd/m². Readings differ from the chosen model by {:.2} %.",
            light.black_cd_m2,
            light.white_cd_m2,
            100.0 * calibration.misfit
        ));
        if !calibration.additivity.is_empty() {
            let percent = largest_percent(&calibration.additivity).abs();
            ui.label(format!("Gray differs from the sum of the three channels by at most {percent:.1} %."));
        }
        calibration.notes.iter().for_each(|text| note(ui, text));
        calibration.refusal(None).iter().for_each(|message| show_error(ui, message));
        let chosen = calibration.chosen;
        ui.strong(format!("Chosen: {chosen}, the simplest of the models that predict left-out levels best."));
    }

    fn details(&mut self, ui: &mut egui::Ui) {
        self.figure.show(ui);
        self.tables.iter_mut().enumerate().for_each(|(id, table)| table.show(ui, id));
    }

    fn profile(&self, known: &DisplayProfile) -> Option<DisplayProfile> {
        if self.calibration.refusal(None).is_some() {
            return None;
        }
        let made = self.calibration.profile(self.calibration.chosen, "", Measurement::default());
        let DisplayProfile { primaries, bits, screen_width_cm, native_px, .. } = known.clone();
        Some(DisplayProfile { primaries, bits, screen_width_cm, native_px, ..made })
    }
}
