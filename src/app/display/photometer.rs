//! Calibration with a photometer: the measurements and the fitted models.

use std::path::Path;

use eframe::egui::{self, Color32};

use super::{
    calibrate::{About, Findings, LABELS, Method, Run, SLIDER},
    patch_run::PatchRun,
};
use crate::{
    app::{
        analysis::TableView,
        ui::{Field, figure::FigureView},
    },
    display::{
        Channel, DisplayProfile, Viewing,
        photometer::{Patch, patches},
    },
    report::figures,
    work::calibrate::{Calibrate, Calibrated},
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
    fn about(&self) -> About {
        About {
            title: "Photometer",
            purpose: "Measure the luminance of every level: point a photometer at patches, or load readings from a file.",
            introduction: "Patches are shown one at a time; type each photometer reading. First let the screen warm up for \
                half an hour, and darken the room.",
            items: "readings",
            format: Some(
                "Readings of other programs can be used: CSV with the columns channel,level,luminance_cd_m2, where channel is \
                    r, g, b or gray, and level is the code divided by the largest code, 0 to 1; .ti3 files of ArgyllCMS; \
                    monitor files of PsychoPy; .mat files of Psychtoolbox.",
            ),
        }
    }

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

    fn begin(&self, channels: &[Channel], file: &Path) -> Result<Box<dyn Run>, String> {
        let around = if self.gray_around { AROUND } else { Color32::BLACK };
        PatchRun::begin(self.patches(channels)?, file, self.settle_s, vec![self.percent], around)
    }

    fn read(&self, file: &Path, known: &DisplayProfile) -> Result<Findings, String> {
        let request = Calibrate::of(file.to_owned());
        let made = request.fit("").map_err(|errors| errors.to_string())?;
        let found = made.sentences().into_iter().map(|sentence| (sentence, false));
        let Calibrated { calibration, profile, .. } = made;
        let refusal = calibration.refusal(None);
        let notes = calibration.notes.iter().chain(&refusal).map(|note| (note.clone(), true));
        let DisplayProfile { primaries, bits, screen_width_cm, native_px, .. } = known.clone();
        Ok(Findings {
            told: found.chain(notes).collect(),
            figure: Some(FigureView::new(figures::calibration(&calibration))),
            tables: figures::calibration_tables(&calibration).map(TableView::new).into(),
            profile: refusal.is_none().then_some(DisplayProfile {
                primaries,
                bits,
                screen_width_cm,
                native_px,
                ..profile
            }),
            instrument: request.with,
        })
    }
}
