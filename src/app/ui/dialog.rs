//! The file dialogs of the desktop. They run on a separate thread, so the window stays responsive.

use std::{
    path::PathBuf,
    sync::{Arc, Mutex, PoisonError},
    time::{Duration, Instant},
};

use eframe::egui::{self, Id, Role, WidgetInfo};

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

/// The open dialog: the name of what opened it, what it will return, and when it was opened.
type Open = Option<(String, BackgroundTask<Option<Vec<PathBuf>>>, Instant)>;

fn with<R>(ctx: &egui::Context, change: impl FnOnce(&mut Open) -> R) -> R {
    let open: Arc<Mutex<Open>> =
        ctx.data_mut(|data| data.get_temp_mut_or_default::<Arc<Mutex<Open>>>(Id::unique("file dialog")).clone());
    change(&mut open.lock().unwrap_or_else(PoisonError::into_inner))
}

/// Draws the button that opens a dialog; screen readers call it `name`. Stores the chosen path in `path`; returns whether a
/// path was chosen.
pub fn browse(ui: &mut egui::Ui, kind: FileKind, name: &str, path: &mut String) -> bool {
    let button = ui.button("Browse…");
    button.widget_info(|| WidgetInfo::labeled(Role::Button, true, name));
    if button.clicked() {
        ask(ui.ctx(), kind, name);
    }
    let chosen = answer(ui.ctx(), name).and_then(|paths| paths.into_iter().next());
    if let Some(chosen) = &chosen {
        *path = chosen.display().to_string();
    }
    chosen.is_some()
}

/// Opens the dialog unless `name` has already opened it.
pub fn ask(ctx: &egui::Context, kind: FileKind, name: &str) {
    if with(ctx, |open| open.as_ref().is_some_and(|(by, ..)| by == name)) {
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
    let task = BackgroundTask::start(ctx, ask);
    with(ctx, |open| *open = Some((name.to_owned(), task, Instant::now())));
}

/// Takes the paths that were chosen in the dialog that `name` opened. If it never opened, the status line says so.
pub fn answer(ctx: &egui::Context, name: &str) -> Option<Vec<PathBuf>> {
    let (paths, opened) = with(ctx, |open| {
        let (_, task, opened) = open.as_ref().filter(|(by, ..)| by == name)?;
        let answer = (task.poll()?.unwrap_or_default(), *opened);
        *open = None;
        Some(answer)
    })?;
    // Nobody closes a dialog this fast, so none was opened. The system itself does not report this.
    if paths.is_none() && opened.elapsed() < Duration::from_millis(400) {
        complain(ctx, "The system could not open a file dialog. Type the path, or drop a file on this window.");
    }
    paths
}
