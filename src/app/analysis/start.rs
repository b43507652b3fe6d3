//! Before anything is opened: what there is to analyze.

use std::path::{Path, PathBuf};

use eframe::egui::{self, Key};

use crate::app::ui::{Field, paragraph, section};

/// The page without data.
pub struct Start {
    typed: String,
    /// Experiments that have data in the results folder.
    found: Vec<PathBuf>,
}

/// What is to be opened.
pub enum Choice {
    /// This file or folder.
    Open(PathBuf),
    /// Files that are chosen in a dialog.
    Files,
    /// A folder that is chosen in a dialog.
    Folder,
}

impl Start {
    /// With the experiments that have data in a results folder.
    pub fn new(results: &Path) -> Self {
        let entries = results.read_dir().into_iter().flatten().flatten();
        let mut found: Vec<PathBuf> = entries.map(|entry| entry.path()).filter(|path| has_data(path)).collect();
        found.sort();
        Self { typed: String::new(), found }
    }

    /// Draws it.
    pub fn show(&mut self, ui: &mut egui::Ui) -> Option<Choice> {
        let mut choice = None;
        paragraph(
            ui,
            "Drop files or a folder on this window: result files, a table of counts, or any CSV file with one rating in a \
             row, whose columns you then name.",
        );
        ui.horizontal_wrapped(|ui| {
            if ui.button("Open files…").clicked() {
                choice = Some(Choice::Files);
            }
            if ui.button("Open folder…").clicked() {
                choice = Some(Choice::Folder);
            }
        });
        if !self.found.is_empty() {
            section(ui, "In the results folder");
        }
        for path in &self.found {
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            if ui.button(format!("Analyze {name}")).on_hover_text(path.display().to_string()).clicked() {
                choice = Some(Choice::Open(path.clone()));
            }
        }
        ui.add_space(6.0);
        ui.horizontal_wrapped(|ui| {
            let field = Field::new("Or the path of a file or folder").text(ui, &mut self.typed);
            let entered = field.lost_focus() && ui.input(|input| input.key_pressed(Key::Enter));
            let ready = !self.typed.trim().is_empty();
            if ui.add_enabled(ready, egui::Button::new("Open")).clicked() || entered && ready {
                choice = Some(Choice::Open(self.typed.trim().into()));
            }
        });
        choice
    }
}

/// Whether a folder is an experiment's data set with at least one session in it.
fn has_data(path: &Path) -> bool {
    let is_session = |name: &std::ffi::OsStr| name.to_string_lossy().ends_with("_data.csv");
    (path.join("data").read_dir().into_iter().flatten().flatten()).any(|entry| is_session(&entry.file_name()))
}
