//! Steps of equal brightness: the table, and the wedge to look at.

use eframe::egui::{self, Key, TextureHandle};

use super::{ToolGo, picture::wide_picture, tool};
use crate::{
    app::{Monitor, form::parse, pixels, theme},
    display::{
        DisplayProfile,
        profile::short,
        steps::{Step, csv, steps},
    },
    light::{CodeImage, Samples},
};

/// Lowest intensity where black was not measured and none is typed.
const ASSUMED_I0: f64 = 0.005;
/// Height of the wedge, physical pixels.
const HEIGHT_PX: u32 = 140;
/// Most steps: as many as 8 bits have codes.
const MOST: usize = 255;

/// The page.
pub struct StepsPane {
    profile: DisplayProfile,
    number: String,
    i0: String,
    wedge: Option<(Vec<Step>, u32, TextureHandle)>,
    copied: bool,
}

impl StepsPane {
    /// For a screen of this profile.
    pub fn new(profile: DisplayProfile) -> Self {
        let measured = profile.luminance.map(|range| range.lowest_intensity()).filter(|i0| *i0 > 0.0);
        let i0 = format!("{:.6}", measured.unwrap_or(ASSUMED_I0));
        let i0 = i0.trim_end_matches('0').to_owned();
        Self { profile, number: "12".to_owned(), i0, wedge: None, copied: false }
    }

    /// Draws the page.
    pub fn show(&mut self, ui: &mut egui::Ui, _: &Monitor) -> ToolGo {
        let mut back = false;
        tool(ui, "Steps of equal brightness", &mut back, |ui| {
            ui.label("Equal steps of light look wide in the dark and narrow in the bright; equal ratios look equal.");
            ui.add(egui::Label::new(theme::quiet(format!("{}.", self.profile.sentence()))).wrap());
            ui.add_space(8.0);
            self.fields(ui);
            ui.add_space(8.0);
            match self.steps() {
                Ok(steps) => {
                    self.wedge(ui, &steps);
                    self.copy(ui, &steps);
                    table(ui, &steps);
                }
                Err(fault) => theme::fault(ui, &fault),
            }
        });
        if back || ui.input(|input| input.key_pressed(Key::Escape)) { ToolGo::Back } else { ToolGo::Stay }
    }

    fn fields(&mut self, ui: &mut egui::Ui) {
        ui.horizontal_wrapped(|ui| {
            let label = ui.label("Number of steps n");
            ui.add(egui::TextEdit::singleline(&mut self.number).desired_width(60.0)).labelled_by(label.id);
        });
        ui.horizontal_wrapped(|ui| {
            let label = ui.label("Lowest intensity I₀, black over white");
            ui.add(egui::TextEdit::singleline(&mut self.i0).desired_width(100.0)).labelled_by(label.id);
        });
        let from = match self.profile.luminance {
            Some(range) => format!("Measured: {}.", range.sentence()),
            None => "Black was not measured on this screen: the number is assumed.".to_owned(),
        };
        ui.add(egui::Label::new(theme::quiet(from)).wrap());
    }

    fn steps(&self) -> Result<Vec<Step>, String> {
        let number = self.number.trim().parse::<usize>().ok().filter(|number| (1..=MOST).contains(number));
        let number = number.ok_or_else(|| format!("{:?} steps cannot be made; expected 1 to {MOST}.", self.number))?;
        let i0 = parse(&self.i0).ok_or_else(|| format!("{:?} is no number; expected one such as 0.005.", self.i0))?;
        steps(&self.profile, i0, number).map_err(|error| format!("{error}."))
    }

    fn wedge(&mut self, ui: &mut egui::Ui, steps: &[Step]) {
        let room = (ui.available_width() * ui.ctx().pixels_per_point()).floor().max(1.0) as u32;
        // Bars of the same whole number of pixels.
        let width = (room / steps.len() as u32).max(1) * steps.len() as u32;
        let fresh = self.wedge.as_ref().is_none_or(|(shown, at, _)| shown != steps || *at != width);
        if fresh {
            let texture = pixels::texture_of(ui.ctx(), "wedge", &wedge(steps, width, HEIGHT_PX));
            self.wedge = Some((steps.to_vec(), width, texture));
            self.copied = false;
        }
        if let Some((_, width, texture)) = &self.wedge {
            let label = format!("A wedge of {} uniform bars, dark to light", steps.len());
            wide_picture(ui, texture, [*width, HEIGHT_PX], &label);
        }
    }

    fn copy(&mut self, ui: &mut egui::Ui, steps: &[Step]) {
        ui.horizontal_wrapped(|ui| {
            if ui.button("Copy as CSV").clicked() {
                ui.ctx().copy_text(csv(steps));
                self.copied = true;
            }
            if self.copied {
                ui.label(theme::quiet("Copied."));
            }
        });
        let lost = steps.iter().filter(|step| step.nearest != step.level).count();
        let same = steps.windows(2).filter(|pair| pair[0].codes == pair[1].codes).count();
        if lost + same > 0 {
            let text = format!(
                "8 bits are too few here: {same} steps have the code of the step before, and {lost} make light nearer to another level."
            );
            ui.add(egui::Label::new(egui::RichText::new(text).small().color(theme::NOTE)).wrap());
        }
    }
}

/// Bars of equal width, each of one code, from the first step on the left.
fn wedge(steps: &[Step], width: u32, height: u32) -> CodeImage {
    let bar = (width as usize / steps.len().max(1)).max(1);
    let row: Vec<u8> = steps.iter().flat_map(|step| step.codes.repeat(bar)).collect();
    CodeImage { width, height, samples: Samples::Eight(row.repeat(height as usize)) }
}

fn table(ui: &mut egui::Ui, steps: &[Step]) {
    egui::ScrollArea::horizontal().id_salt("steps").show(ui, |ui| {
        egui::Grid::new("steps").striped(true).num_columns(7).spacing([18.0, 2.0]).show(ui, |ui| {
            for name in ["j", "I_j of white", "cd/m²", "red", "green", "blue", "nearest j"] {
                ui.label(theme::quiet(name));
            }
            ui.end_row();
            for step in steps {
                let cells = [
                    step.level.to_string(),
                    format!("{:.5}", step.intensity),
                    step.cd_m2.map_or_else(|| "–".to_owned(), short),
                    step.codes[0].to_string(),
                    step.codes[1].to_string(),
                    step.codes[2].to_string(),
                    step.nearest.to_string(),
                ];
                for cell in cells {
                    ui.monospace(cell);
                }
                ui.end_row();
            }
        });
    });
}
