//! Whether the luminance of white depends on the size of the patch, as on screens that limit their power.

use std::path::Path;

use eframe::egui::{self, Color32};

use super::{
    calibrate::{About, Findings, LABELS, Method, Run, SLIDER},
    patch_run::PatchRun,
    photometer::{READING_S, SETTLING_S},
};
use crate::{
    app::ui::Field,
    display::{Channel, DisplayProfile, Viewing, photometer::Patch},
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
    fn about(&self) -> About {
        About {
            title: "Patch size",
            purpose: "Find out with a photometer whether the screen dims large bright areas, as OLED screens do.",
            introduction: "White patches of five sizes on black are shown one at a time; type each photometer reading. Some \
                screens, OLED ones above all, dim large bright areas, so that a profile holds for one size only.",
            items: "sizes",
            format: Some("A CSV file can be used that has one row for each size, from the smallest to the largest."),
        }
    }

    fn fields(&mut self, ui: &mut egui::Ui, _: Option<&Viewing>) {
        let field = Field::new("Settling time, seconds").column(LABELS).width(SLIDER);
        field.slider(ui, &mut self.settle_s, SETTLING_S, 0.5);
    }

    fn estimate(&self, _: &[Channel]) -> Result<(usize, f64), String> {
        Ok((PERCENTS.len(), PERCENTS.len() as f64 * (self.settle_s + READING_S)))
    }

    fn begin(&self, _: &[Channel], file: &Path) -> Result<Box<dyn Run>, String> {
        let white = Patch { channel: Channel::Gray, code: u8::MAX };
        PatchRun::begin(vec![white; PERCENTS.len()], file, self.settle_s, PERCENTS.to_vec(), Color32::BLACK)
    }

    fn read(&self, file: &Path, _: &DisplayProfile) -> Result<Findings, String> {
        let readings = readings::open_incomplete(file).map_err(|errors| errors.to_string())?;
        let whites = readings.iter().filter(|one| one.channel == Channel::Gray && one.level >= 1.0);
        let cd_m2: Vec<f64> = whites.map(|one| one.luminance_cd_m2).collect();
        let &[small, _, _, _, large] = &cd_m2[..] else {
            let (path, found, sizes) = (file.display(), cd_m2.len(), PERCENTS.len());
            return Err(format!("{path}: there are {found} readings of white; expected {sizes}, one for each size"));
        };
        let most = cd_m2.iter().copied().fold(0.0, f64::max);
        let change = (most - cd_m2.iter().copied().fold(most, f64::min)) / most.max(f64::MIN_POSITIVE);
        let digits = usize::from(change <= NOISE);
        let changes = format!("White changes by {:.digits$} % with the size of the patch", 100.0 * change);
        let mut told = vec![if change <= NOISE {
            (format!("{changes}: the size hardly matters."), false)
        } else {
            let luminances = format!("{small:.1} cd/m² for the smallest, {large:.1} cd/m² for the largest");
            let advice = "Calibrate with a patch as large as the stimulus, on a similar field.";
            (format!("{changes}: {luminances}. {advice}"), true)
        }];
        let each = PERCENTS.iter().zip(&cd_m2);
        told.extend(each.map(|(size, cd_m2)| (format!("{size} % of the screen's height: {cd_m2:.1} cd/m²"), false)));
        Ok(Findings { told, ..Findings::default() })
    }
}
