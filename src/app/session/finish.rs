//! The last page: thanks the participant and plots their ratings. A closed section tells the experimenter where the data
//! are and how the frames were. And the page that is shown while an answer cannot be saved.

use std::path::PathBuf;

use eframe::egui::{self, Key};

use crate::{
    app::ui::{self, Field, FileKind, own_plot::OwnPlot, theme},
    experiment::Protocol,
    system::{data_folder, make_private_folder},
};

pub struct Finish {
    pub protocol: Protocol,
    /// Path of the data file.
    pub path: PathBuf,
    /// Whether every planned trial is rated.
    pub complete: bool,
    pub plot: Option<OwnPlot>,
    /// Why the folder could not be opened.
    pub unopened: Option<String>,
    /// One sentence about the frames of the sitting, if there were any.
    pub frames: Option<String>,
    /// The error if the end of the sitting could not be recorded.
    pub error: Option<String>,
}

impl Finish {
    /// Draws the page; returns whether the user left it. `direct`: leaving it closes the window.
    pub fn show(&mut self, ui: &mut egui::Ui, direct: bool) -> bool {
        let texts = self.protocol.instructions.clone();
        let mut leave = false;
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
            if let Some(plot) = own {
                ui.label(&plot.caption);
                plot.draw(ui, 280.0);
            }
            ui.add_space(8.0);
            if let Some(error) = &self.error {
                let told = "The end of this sitting could not be recorded. Please call the experimenter.";
                ui::show_error(ui, format!("{told} {error}"));
            }
            leave = ui::neutral_primary(ui, if direct { &texts.close } else { &texts.back }, true, "Enter");
            ui.add_space(theme::LARGE_GAP);
            let section = egui::CollapsingHeader::new(ui::secondary(&texts.experimenter)).id_salt(&self.path);
            ui::folded(ui, section, |ui| self.details(ui));
        });
        let focused = ui.ctx().memory(|memory| memory.focused().is_some());
        let entered = !focused && ui.input(|input| input.key_pressed(Key::Enter));
        leave || entered
    }

    /// Draws what only the experimenter needs.
    fn details(&mut self, ui: &mut egui::Ui) {
        let texts = &self.protocol.instructions;
        ui.label(&texts.saved_in);
        ui.add(egui::Label::new(egui::RichText::new(self.path.display().to_string()).monospace()).wrap());
        if ui.button(&texts.open_folder).clicked() {
            let folder = self.path.parent().unwrap_or(&self.path);
            self.unopened = ui::open(folder);
        }
        if let Some(frames) = &self.frames {
            ui::hint(ui, frames);
        }
        if let Some(error) = &self.unopened {
            ui::show_error(ui, error);
        }
    }
}

/// The page that is shown while an answer cannot be saved. The answer stays in memory until it is on disk.
pub struct UnsavedAnswerPage {
    /// Why the answer is not saved, also after a choice that did not help.
    pub what: String,
    /// The folder that is proposed: the user's own, which survives a restart of the machine and which nobody else can
    /// read. `None` if the user has no home folder.
    rescue: Option<PathBuf>,
    folder: String,
}

/// What the user chose to do about it.
pub enum SaveChoice {
    /// Try the same folder again.
    Retry,
    /// Use another results folder.
    ContinueIn(PathBuf),
}

impl UnsavedAnswerPage {
    /// Creates the page for an error of the store; `what` is its message.
    pub fn new(what: String) -> Self {
        let rescue = data_folder().map(|folder| folder.join("rescued"));
        let folder = rescue.as_ref().map_or_else(String::new, |rescue| rescue.display().to_string());
        Self { what, rescue, folder }
    }

    pub fn show(&mut self, ui: &mut egui::Ui) -> Option<SaveChoice> {
        ui::page(ui, |ui| {
            let mut choice = None;
            ui.heading("The last answer could not be saved");
            ui::show_error(ui, &self.what);
            ui.label(
                "Nothing is lost: every answer of this session is still in memory. Please call the experimenter. \
                The session continues once the answers are saved.",
            );
            ui.add_space(12.0);
            if ui::neutral_primary(ui, "Try again", true, "") {
                choice = Some(SaveChoice::Retry);
            }
            ui.add_space(12.0);
            let field = Field::new("Or save the entire session in another folder:").column(theme::COLUMN).width(380.0);
            field.path(ui, &mut self.folder, (FileKind::Folder, "Choose a folder…"));
            let usable = !self.folder.trim().is_empty();
            if ui.add_enabled(usable, egui::Button::new("Save there and continue")).clicked() {
                let folder = PathBuf::from(self.folder.trim());
                if self.rescue.as_ref() == Some(&folder) {
                    // If this fails, saving there fails too and reports why.
                    let _ = make_private_folder(&folder);
                }
                choice = Some(SaveChoice::ContinueIn(folder));
            }
            choice
        })
    }
}
