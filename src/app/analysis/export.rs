//! Exports the analysis: writes the files that `machband analyze` writes, or copies the equivalent command.

use std::{
    path::{Path, PathBuf},
    sync::Arc,
};

use eframe::egui;

use crate::{
    analysis::Results,
    app::ui::{
        Dialog, FileKind, Saving, full, hint, open, secondary, show_error,
        work::{BackgroundTask, Progress},
    },
    report::{Provenance, Study, study::shell_command, write_all},
    store::{StoreError, Writer},
    system::now,
    work::{Analyze, words},
};

/// The folder field and the outcome of the last export.
#[derive(Default)]
pub struct Export {
    /// The paths and the files in those that are folders. The export never replaces them.
    inputs: Vec<PathBuf>,
    folder: String,
    dialog: Dialog,
    work: Option<(PathBuf, BackgroundTask<Result<usize, StoreError>>)>,
    saving: Saving,
    copied: Option<String>,
    /// The folder with the last export.
    written: Option<PathBuf>,
    /// Why it could not be opened.
    not_opened: Option<String>,
}

pub struct Exported<'a> {
    pub study: &'a Arc<Study>,
    /// What was requested.
    pub request: &'a Analyze,
    pub results: &'a Arc<Results>,
    /// A phrase that describes the selected data; empty if nothing is excluded.
    pub filter: String,
}

impl Export {
    /// Creates the controls for results from these files, which are what was found at the paths that were asked for.
    pub fn new(paths: &[PathBuf], files: impl Iterator<Item = PathBuf>) -> Self {
        let name = paths.first().and_then(|path| path.file_stem()).filter(|name| !name.is_empty());
        let name = name.map_or("machband".into(), |name| name.to_string_lossy());
        let folder = format!("{name}-analysis");
        Self { folder, inputs: paths.iter().cloned().chain(files).collect(), ..Self::default() }
    }

    /// Draws the controls. Nothing can be exported while no results are shown.
    pub fn show(&mut self, ui: &mut egui::Ui, exported: Option<&Exported<'_>>) {
        self.take_outcome(ui.ctx());
        let label = ui.label("Export to the folder");
        let width = ui.available_width();
        let field = ui.add(egui::TextEdit::singleline(&mut self.folder).desired_width(width)).labelled_by(label.id);
        let mut changed = field.changed();
        ui.horizontal_wrapped(|ui| {
            let folder = PathBuf::from(self.folder.trim());
            let ready = exported.is_some() && self.work.is_none() && !folder.as_os_str().is_empty();
            let writer = self.saving.button(ui, "Export", ready, &folder, &self.inputs);
            if let Some((exported, writer)) = exported.zip(writer) {
                self.start(ui.ctx(), folder, writer, exported);
            }
            changed |= self.dialog.browse(ui, FileKind::Folder, "Choose the folder to export to…", &mut self.folder);
            if self.work.is_some() {
                ui.spinner();
                ui.label(secondary("Writing…"));
            }
        });
        if changed {
            self.forget();
        }
        if let Some(Exported { filter, .. }) = exported.filter(|exported| !exported.filter.is_empty()) {
            hint(ui, format!("The export includes only the data shown: {filter}."));
        }
        self.dialog.missing_error(ui);
        self.saving.show(ui);
        self.open_buttons(ui);
        let copy = ui.add_enabled(exported.is_some(), egui::Button::new("Copy as command")).clicked();
        if let Some(exported) = exported.filter(|_| copy) {
            let command = self.command(exported);
            ui.ctx().copy_text(command.clone());
            self.copied = Some(command);
        }
        if let Some(command) = &self.copied {
            hint(ui, format!("Copied: {command}"));
        }
    }

    fn take_outcome(&mut self, ctx: &egui::Context) {
        let Some((folder, work)) = &self.work else { return };
        let outcome = match work.poll() {
            Progress::Running => return,
            Progress::Done(files) => files.map(|files| format!("{files} files written to {}", full(folder).display())),
            Progress::Lost => Err(StoreError::Protected {
                path: folder.clone(),
                what: "the export ended unexpectedly; expected files in the folder".to_owned(),
            }),
        };
        self.written = outcome.is_ok().then(|| folder.clone());
        self.saving.finish(folder, outcome);
        self.work = None;
        ctx.request_repaint();
    }

    fn forget(&mut self) {
        (self.saving, self.written, self.not_opened) = (Saving::default(), None, None);
    }

    /// Draws the buttons that open the last export in other programs.
    fn open_buttons(&mut self, ui: &mut egui::Ui) {
        let Some(folder) = &self.written else { return };
        ui.horizontal_wrapped(|ui| {
            for (text, path) in [("Open report", folder.join("report.html")), ("Open folder", folder.clone())] {
                if ui.button(text).clicked() {
                    self.not_opened = open(&path);
                }
            }
        });
        if let Some(error) = &self.not_opened {
            show_error(ui, error);
        }
    }

    fn start(&mut self, ctx: &egui::Context, folder: PathBuf, writer: Writer, exported: &Exported<'_>) {
        self.written = None;
        let (study, results, to) = (exported.study.clone(), exported.results.clone(), folder.clone());
        let command = self.command(exported);
        self.work = Some((folder, BackgroundTask::start(ctx, move || write(&writer, &study, &results, &command, &to))));
    }

    /// Returns the command that repeats the request.
    fn command(&self, exported: &Exported<'_>) -> String {
        let out = ["--out".to_owned(), self.folder.trim().to_owned()];
        shell_command(["analyze".to_owned()].into_iter().chain(words(exported.request)).chain(out))
    }
}

/// Writes everything that `machband analyze` writes; returns the number of files.
fn write(writer: &Writer, study: &Study, results: &Results, command: &str, folder: &Path) -> Result<usize, StoreError> {
    // The report covers the ratings on which the results are based.
    let shown = Study { source: study.source.clone(), measured: results.measured.clone() };
    let made = Provenance::new(command, now());
    Ok(write_all(writer, &shown, results, &made, folder, false)?.files.len())
}
