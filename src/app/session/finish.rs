//! The last page: thanks the participant and plots their ratings. A closed section tells the experimenter where the data
//! are and how the frames were.

use std::path::PathBuf;

use eframe::egui::{self, Key};

use crate::{
    app::ui::{self, Step, own_plot::OwnPlot, theme},
    experiment::{Protocol, TrialRecord},
};

pub struct Finish {
    protocol: Protocol,
    /// Path of the data file.
    pub path: PathBuf,
    /// Whether every planned trial is rated.
    pub complete: bool,
    plot: Option<OwnPlot>,
    opened: Option<String>,
    /// One sentence about the frames of the sitting, if there were any.
    frames: Option<String>,
    /// The error if the end of the sitting could not be recorded.
    error: Option<String>,
}

impl Finish {
    /// Creates the last page of a completed or interrupted session.
    pub fn new(
        protocol: Protocol,
        rows: &[TrialRecord],
        path: PathBuf,
        complete: bool,
        frames: Option<String>,
        error: Option<String>,
    ) -> Self {
        let plot = OwnPlot::new(&protocol, rows);
        Self { protocol, path, complete, plot, opened: None, frames, error }
    }

    /// Draws the page. `direct`: leaving it closes the window.
    pub fn show(&mut self, ui: &mut egui::Ui, direct: bool) -> Step<PathBuf> {
        let texts = self.protocol.instructions.clone();
        let mut leave = false;
        let mut analyze = false;
        ui::page(ui, |ui| {
            if self.complete {
                ui.heading(&texts.thanks);
                ui.label(&texts.done);
            } else {
                ui.heading(&texts.left_heading);
                ui.label(&texts.left);
            }
            ui.add_space(8.0);
            let own = self.plot.as_ref().filter(|_| self.complete && self.protocol.session.own_means);
            own.into_iter().for_each(|plot| plot.show(ui));
            ui.add_space(8.0);
            if let Some(error) = &self.error {
                let told = "The end of this sitting could not be recorded. Please call the experimenter.";
                ui::show_error(ui, format!("{told} {error}"));
            }
            leave = ui::neutral_primary(ui, if direct { &texts.close } else { &texts.back }, true, "Enter");
            ui.add_space(theme::LARGE_GAP);
            let section = egui::CollapsingHeader::new(ui::secondary(&texts.experimenter)).id_salt(&self.path);
            ui::folded(ui, section, |ui| analyze = self.details(ui));
        });
        let focused = ui.ctx().memory(|memory| memory.focused().is_some());
        let entered = !focused && ui.input(|input| input.key_pressed(Key::Enter));
        // The folder with all sessions of the experiment.
        if let Some(data_set) = self.path.ancestors().nth(2).filter(|_| analyze) {
            return Step::Next(data_set.to_owned());
        }
        Step::back_if(leave || entered)
    }

    /// Draws what only the experimenter needs; returns whether they want to analyze the results.
    fn details(&mut self, ui: &mut egui::Ui) -> bool {
        let texts = &self.protocol.instructions;
        ui.label(&texts.saved_in);
        ui.add(egui::Label::new(egui::RichText::new(self.path.display().to_string()).monospace()).wrap());
        let analyze = ui.horizontal_wrapped(|ui| {
            if ui.button(&texts.open_folder).clicked() {
                let folder = self.path.parent().unwrap_or(&self.path);
                self.opened = ui::open(folder);
            }
            // Participants who return must not see trends in their answers.
            self.complete && ui.button("Analyze these results").clicked()
        });
        if let Some(frames) = &self.frames {
            ui::hint(ui, frames);
        }
        if let Some(error) = &self.opened {
            ui::show_error(ui, error);
        }
        analyze.inner
    }
}
