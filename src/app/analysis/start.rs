//! Before anything is opened: what there is to analyse.

use std::path::{Path, PathBuf};

use eframe::egui::{self, Key, TextEdit};

use super::look;
use crate::app::theme;

/// The page without data.
#[derive(Default)]
pub struct Start {
    typed: String,
    found: Vec<Found>,
}

/// An experiment with results.
struct Found {
    name: String,
    path: PathBuf,
}

/// What is to be opened.
pub enum Wish {
    /// These files and folders.
    Open(Vec<PathBuf>),
    /// Files that are chosen in a dialog.
    Files,
    /// A folder that is chosen in a dialog.
    Folder,
}

impl Start {
    /// With the experiments that have data in a results folder.
    pub fn new(results: &Path) -> Self {
        let mut found: Vec<Found> = (results.read_dir().into_iter().flatten().flatten())
            .map(|entry| entry.path())
            .filter(|path| has_data(path))
            .map(|path| Found { name: path.file_name().unwrap_or_default().to_string_lossy().into_owned(), path })
            .collect();
        found.sort_by(|l, r| l.name.cmp(&r.name));
        Self { typed: String::new(), found }
    }

    /// Draws it.
    pub fn show(&mut self, ui: &mut egui::Ui, no_dialog: bool) -> Option<Wish> {
        let mut wish = None;
        ui.label("Drop files or a folder on this window: result files, a table of counts, or any CSV file with one row a rating, whose columns you then name.");
        ui.add_space(6.0);
        ui.horizontal_wrapped(|ui| {
            if ui.button("Open files…").clicked() {
                wish = Some(Wish::Files);
            }
            if ui.button("Open folder…").clicked() {
                wish = Some(Wish::Folder);
            }
        });
        if no_dialog {
            theme::fault(ui, "No file dialog opened on this system: type the path, or drop files on this window.");
        }
        if !self.found.is_empty() {
            look::heading(ui, "In the results folder");
            for found in &self.found {
                if ui
                    .button(format!("Analyse {}", found.name))
                    .on_hover_text(found.path.display().to_string())
                    .clicked()
                {
                    wish = Some(Wish::Open(vec![found.path.clone()]));
                }
            }
        }
        ui.add_space(6.0);
        let label = ui.label("Or the path of a file or folder");
        ui.horizontal_wrapped(|ui| {
            let width = (ui.available_width() - 90.0).max(160.0);
            let field = ui.add(TextEdit::singleline(&mut self.typed).desired_width(width)).labelled_by(label.id);
            let entered = field.lost_focus() && ui.input(|input| input.key_pressed(Key::Enter));
            let ready = !self.typed.trim().is_empty();
            if ui.add_enabled(ready, egui::Button::new("Open")).clicked() || entered && ready {
                wish = Some(Wish::Open(vec![PathBuf::from(self.typed.trim())]));
            }
        });
        wish
    }
}

/// Whether a folder is an experiment's data set with at least one session in it.
fn has_data(path: &Path) -> bool {
    let session = |name: &std::ffi::OsStr| name.to_string_lossy().ends_with("_data.csv");
    (path.join("data").read_dir().into_iter().flatten().flatten()).any(|entry| session(&entry.file_name()))
}
