//! The page that is shown while an answer cannot be saved. The answer stays in memory until it is on disk.

use std::path::PathBuf;

use eframe::egui;

use crate::{
    app::ui::{self, Dialog, Field, FileKind, theme},
    system::{data_folder, make_private_folder},
};

pub struct UnsavedAnswerPage {
    /// Why the answer is not saved, also after a choice that did not help.
    pub what: String,
    /// The folder that is proposed: the user's own, which survives a restart of the machine and which nobody else can
    /// read. `None` if the user has no home folder.
    rescue: Option<PathBuf>,
    folder: String,
    dialog: Dialog,
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
        Self { what, rescue, folder, dialog: Dialog::default() }
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
            if let Some(rescue) = &self.rescue {
                ui.label(format!("The folder {} belongs to you, and nobody else can open it.", rescue.display()));
            }
            let field = Field::new("Or save the entire session in another folder:").column(theme::COLUMN).width(380.0);
            field.path(ui, &mut self.folder, &mut self.dialog, (FileKind::Folder, "Choose a folder…"));
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
