//! Whether the luminance of white depends on the size of the patch, as on screens that limit their power.

use std::path::Path;

use eframe::egui::{self, Color32};

use super::{
    calibrate::{Findings, LABELS, Method, SLIDER},
    patch_run::PatchRun,
    photometer::{READING_S, SETTLING_S},
};
use crate::{
    app::ui::{Field, hint, note},
    display::{Channel, Viewing, photometer::Patch},
    store::readings,
};

/// Heights of the patches in percent of the screen's height.
const PERCENTS: [u32; 5] = [5, 10, 20, 40, 70];
/// A smaller change, as a share of the largest luminance, is not told from the noise of a photometer.
const NOISE: f64 = 0.02;

/// The settings of the test.
pub struct SizeTest {
    pub settle_s: f64,
}

impl Method for SizeTest {
    type Findings = SizeFindings;
    type Run = PatchRun;

    const FORMAT: &'static str =
        "A CSV file can be used that has one row for each size, from the smallest to the largest.";
    const HAS_CHANNELS: bool = false;
    const INTRODUCTION: &'static str = "White patches of five sizes on black are shown one at a time; type each \
        photometer reading. Some screens, OLED ones above all, dim large bright areas, so that a profile holds for one \
        size only.";
    const ITEMS: &'static str = "sizes";
    const TITLE: &'static str = "Patch size";

    fn fields(&mut self, ui: &mut egui::Ui, _: Option<&Viewing>) {
        let field = Field::new("Settling time, seconds").column(LABELS).width(SLIDER);
        field.slider(ui, &mut self.settle_s, SETTLING_S, 0.5);
    }

    fn estimate(&self, _: &[Channel]) -> Result<(usize, f64), String> {
        Ok((PERCENTS.len(), PERCENTS.len() as f64 * (self.settle_s + READING_S)))
    }

    fn begin(&self, _: &[Channel], file: &Path) -> Result<PatchRun, String> {
        let white = Patch { channel: Channel::Gray, code: u8::MAX, level: 1.0 };
        let run = PatchRun::begin(vec![white; PERCENTS.len()], file, self.settle_s, PERCENTS.to_vec(), Color32::BLACK);
        run.map_err(|error| error.to_string())
    }
}

/// The luminance of white at each size.
pub struct SizeFindings([f64; PERCENTS.len()]);

impl Findings for SizeFindings {
    fn read(path: &Path) -> Result<Self, String> {
        let readings = readings::open_incomplete(path).map_err(|errors| errors.to_string())?;
        let whites = readings.iter().filter(|one| one.channel == Channel::Gray && one.level >= 1.0);
        let cd_m2: Vec<f64> = whites.map(|one| one.luminance_cd_m2).collect();
        let wrong = |found: Vec<f64>| {
            let (path, sizes) = (path.display(), PERCENTS.len());
            format!("{path}: there are {} readings of white; expected {sizes}, one for each size", found.len())
        };
        cd_m2.try_into().map(Self).map_err(wrong)
    }

    fn summary(&mut self, ui: &mut egui::Ui) {
        let [small, .., large] = self.0;
        let most = self.0.into_iter().fold(0.0, f64::max);
        let change = (most - self.0.into_iter().fold(f64::INFINITY, f64::min)) / most.max(f64::MIN_POSITIVE);
        let digits = usize::from(change <= NOISE);
        let told = format!("White changes by {:.digits$} % with the size of the patch", 100.0 * change);
        if change <= NOISE {
            hint(ui, format!("{told}: the size hardly matters."));
        } else {
            let text = format!(
                "{told}: {small:.1} cd/m² for the smallest, {large:.1} cd/m² for the largest. Calibrate with a patch as \
                    large as the stimulus, on a similar field."
            );
            note(ui, text);
        }
        for (percent, cd_m2) in PERCENTS.iter().zip(self.0) {
            hint(ui, format!("{percent} % of the screen's height: {cd_m2:.1} cd/m²"));
        }
    }
}
