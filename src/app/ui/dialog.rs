//! The file dialogs of the desktop. They run on a separate thread, so the window stays responsive.

use std::{
    path::PathBuf,
    time::{Duration, Instant},
};

use eframe::egui::{self, Role, WidgetInfo};

use super::{status::complain, work::BackgroundTask};

/// The kind of file requested.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FileKind {
    Toml,
    Mesh,
    /// One or more CSV files.
    Data,
    Folder,
}

/// A file dialog, which may be open.
#[derive(Default)]
pub struct Dialog {
    open: Option<(BackgroundTask<Option<Vec<PathBuf>>>, Instant)>,
}

impl Dialog {
    /// Draws the button that opens the dialog; screen readers call it `name`. Stores the chosen path in `path`; returns
    /// whether a path was chosen.
    pub fn browse(&mut self, ui: &mut egui::Ui, kind: FileKind, name: &str, path: &mut String) -> bool {
        let button = ui.button("Browse…");
        button.widget_info(|| WidgetInfo::labeled(Role::Button, true, name));
        if button.clicked() {
            self.open(ui.ctx(), kind);
        }
        let chosen = self.take(ui.ctx()).and_then(|paths| paths.into_iter().next());
        if let Some(chosen) = &chosen {
            *path = chosen.display().to_string();
        }
        chosen.is_some()
    }

    /// Opens the dialog unless it is already open.
    pub fn open(&mut self, ctx: &egui::Context, kind: FileKind) {
        if self.open.is_some() {
            return;
        }
        let ask = move || {
            let dialog = rfd::FileDialog::new();
            let one = |path: Option<PathBuf>| path.map(|path| vec![path]);
            match kind {
                FileKind::Toml => one(dialog.add_filter("TOML", &["toml"]).pick_file()),
                FileKind::Mesh => one(dialog.add_filter("mesh", &["obj", "ply", "gltf", "glb"]).pick_file()),
                FileKind::Data => {
                    dialog.add_filter("tables", &["csv", "gz", "xlsx"]).add_filter("all files", &["*"]).pick_files()
                }
                FileKind::Folder => one(dialog.pick_folder()),
            }
        };
        self.open = Some((BackgroundTask::start(ctx, ask), Instant::now()));
    }

    /// Takes the chosen paths. If the dialog never opened, the status line says so.
    pub fn take(&mut self, ctx: &egui::Context) -> Option<Vec<PathBuf>> {
        let (task, opened) = self.open.as_ref()?;
        let paths = task.poll()?.unwrap_or_default();
        // Nobody closes a dialog this fast, so none was opened. The system itself does not report this.
        if paths.is_none() && opened.elapsed() < Duration::from_millis(400) {
            complain(ctx, "The system could not open a file dialog. Type the path, or drop a file on this window.");
        }
        self.open = None;
        paths
    }
}
