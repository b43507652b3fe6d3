//! The file dialogs of the desktop, on a separate thread so that the window is still drawn.

use std::{
    path::PathBuf,
    sync::mpsc::{Receiver, TryRecvError, channel},
    time::{Duration, Instant},
};

use eframe::egui::{self, Role, WidgetInfo};

use super::text;

/// The kind of file requested.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ask {
    /// A TOML file.
    Toml,
    /// An OBJ file.
    Obj,
    /// CSV files, one or more.
    Data,
    Folder,
}

/// A dialog that may be open.
#[derive(Default)]
pub struct Dialog {
    open: Option<(Receiver<Option<Vec<PathBuf>>>, Instant)>,
    missing: bool,
}

impl Dialog {
    /// The button that opens the dialog, named `name` for screen readers. Puts the chosen path into `path`; returns
    /// whether one was chosen.
    pub fn browse(&mut self, ui: &mut egui::Ui, ask: Ask, name: &str, path: &mut String) -> bool {
        let button = ui.button("Browse…");
        button.widget_info(|| WidgetInfo::labeled(Role::Button, true, name));
        if button.clicked() {
            self.open(ui.ctx(), ask);
        }
        let chosen = self.take();
        if let Some(chosen) = &chosen {
            *path = chosen.display().to_string();
        }
        chosen.is_some()
    }

    /// Opens it, unless it is open already.
    pub fn open(&mut self, ctx: &egui::Context, ask: Ask) {
        if self.open.is_some() {
            return;
        }
        let (send, receive) = channel();
        let ctx = ctx.clone();
        std::thread::spawn(move || {
            let dialog = rfd::FileDialog::new();
            let one = |path: Option<PathBuf>| path.map(|path| vec![path]);
            let paths = match ask {
                Ask::Toml => one(dialog.add_filter("TOML", &["toml"]).pick_file()),
                Ask::Obj => one(dialog.add_filter("OBJ", &["obj"]).pick_file()),
                Ask::Data => dialog.add_filter("CSV", &["csv"]).add_filter("all files", &["*"]).pick_files(),
                Ask::Folder => one(dialog.pick_folder()),
            };
            // The window may be closed; then nobody needs the answer.
            let _ = send.send(paths);
            ctx.request_repaint();
        });
        self.open = Some((receive, Instant::now()));
        self.missing = false;
    }

    /// Shows an error if the last dialog never opened.
    pub fn missing_fault(&self, ui: &mut egui::Ui) {
        if self.missing {
            text::fault(ui, "The system could not open a file dialog. Type the path, or drop a file on this window.");
        }
    }

    /// The chosen path, once; the first of several.
    pub fn take(&mut self) -> Option<PathBuf> {
        self.take_all()?.into_iter().next()
    }

    /// All chosen paths, once.
    pub fn take_all(&mut self) -> Option<Vec<PathBuf>> {
        let (answer, opened) = self.open.as_ref()?;
        let paths = match answer.try_recv() {
            Err(TryRecvError::Empty) => return None,
            Err(TryRecvError::Disconnected) => None,
            Ok(paths) => {
                // Nobody closes a dialog this fast, so none was opened. The system itself does not report this.
                self.missing = paths.is_none() && opened.elapsed() < Duration::from_millis(400);
                paths
            }
        };
        self.open = None;
        paths
    }
}
