//! Steps of equal brightness: the table and the wedge.

use std::path::PathBuf;

use eframe::egui::{self, TextureHandle};

use super::{calibrate::LABELS, tool::Tool};
use crate::{
    app::{
        analysis::TableView,
        ui::{Field, Monitor, Step as PageStep, hint, number, pixels, show_error, tool_page, work::Kept},
    },
    display::{
        DisplayProfile, Viewing,
        profile::{Step, short, steps},
    },
    light::{CodeImage, Samples},
    report::document::{Shown, TableOf, TextTable},
};

/// Suggested lowest intensity, relative to white, if black was not measured.
const ASSUMED_I0: f64 = 0.005;
/// Height of the wedge, physical pixels.
const HEIGHT_PX: u32 = 140;
/// Maximum number of steps. With 255 steps, there are as many levels as 8-bit codes.
const MAX_STEPS: usize = 255;

pub struct StepsPage {
    profile: DisplayProfile,
    number: String,
    i0: String,
    /// The wedge and the table, by the steps and the width that are shown.
    shown: Kept<(Vec<Step>, u32), (TextureHandle, TableView)>,
}

impl StepsPage {
    /// Creates the page for a screen with this profile.
    pub fn new(profile: DisplayProfile) -> Self {
        let measured = profile.luminance.map(|range| range.lowest_intensity()).filter(|i0| *i0 > 0.0);
        let i0 = format!("{:.6}", measured.unwrap_or(ASSUMED_I0));
        let i0 = i0.trim_end_matches('0').to_owned();
        Self { profile, number: "12".to_owned(), i0, shown: Kept::default() }
    }

    fn steps(&self) -> Result<Vec<Step>, String> {
        let n = self.number.trim().parse::<usize>().ok().filter(|n| (1..=MAX_STEPS).contains(n));
        let n = n.ok_or_else(|| format!("{:?} is not a number of steps; expected 1 to {MAX_STEPS}.", self.number))?;
        let i0 =
            number(&self.i0).ok_or_else(|| format!("{:?} is not a number; expected one such as 0.005.", self.i0))?;
        steps(&self.profile, i0, n).map_err(|error| format!("{error}."))
    }

    fn show_steps(&mut self, ui: &mut egui::Ui, steps: &[Step]) {
        let room = (ui.available_width() * ui.ctx().pixels_per_point()).floor().max(1.0) as u32;
        // All bars have the same whole number of pixels.
        let width = (room / steps.len() as u32).max(1) * steps.len() as u32;
        let (texture, table) = self.shown.get((steps.to_vec(), width), || {
            let texture = pixels::texture(ui.ctx(), "wedge", &wedge(steps, width, HEIGHT_PX));
            (texture, TableView::new(table(steps)))
        });
        pixels::picture(ui, texture, &format!("A wedge of {} uniform bars, dark to light", steps.len()));
        table.show(ui, 0);
    }
}

impl Tool for StepsPage {
    fn show(&mut self, ui: &mut egui::Ui, _: &Monitor, _: Option<&Viewing>) -> PageStep<PathBuf> {
        let back = tool_page(ui, "Steps of equal brightness", |ui| {
            ui.label("Equal steps of light look larger at dark levels than at bright levels; equal ratios look equal.");
            hint(ui, format!("{}.", self.profile.sentence()));
            ui.add_space(8.0);
            Field::new("Number of steps n").column(LABELS).width(60.0).text(ui, &mut self.number);
            Field::new("Lowest intensity I₀").column(LABELS).width(100.0).text(ui, &mut self.i0);
            hint(
                ui,
                match self.profile.luminance {
                    Some(range) => format!("Black relative to white. Measured: {}.", range.sentence()),
                    None => {
                        "Black relative to white. It was not measured for this screen; this value is an assumption."
                            .to_owned()
                    }
                },
            );
            ui.add_space(8.0);
            match self.steps() {
                Ok(steps) => self.show_steps(ui, &steps),
                Err(message) => show_error(ui, message),
            }
        });
        PageStep::back_if(back)
    }
}

/// Creates uniform bars of equal width, one per level, with the darkest on the left.
fn wedge(steps: &[Step], width: u32, height: u32) -> CodeImage {
    let bar = (width as usize / steps.len().max(1)).max(1);
    let row: Vec<u8> = steps.iter().flat_map(|step| step.codes.repeat(bar)).collect();
    CodeImage { width, height, samples: Samples::Eight(row.repeat(height as usize)) }
}

fn table(steps: &[Step]) -> TextTable {
    let whole = |number: usize| Shown::new(number, number.to_string());
    let code = |channel: usize| move |step: &Step| whole(step.codes[channel].into());
    TableOf::new("Steps", steps)
        .number("j", |step| whole(step.level))
        .number("relative to white", |step| Shown::new(step.intensity, format!("{:.5}", step.intensity)))
        .number("cd/m²", |step| Shown::new(step.cd_m2, step.cd_m2.map_or_else(|| "–".to_owned(), short)))
        .number("red", code(0))
        .number("green", code(1))
        .number("blue", code(2))
        .number("nearest j", |step| whole(step.nearest))
        .into()
}
