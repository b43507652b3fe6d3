//! Exports the analysis: writes the files that `machband analyze` writes, or copies the equivalent command.

use std::{
    path::{Path, PathBuf},
    sync::Arc,
};

use eframe::egui;

use crate::{
    app::ui::{
        Dialog, Field, FileKind, Saving, complain, full, open, say,
        text::two_lines,
        theme::ink,
        work::{BackgroundTask, Lost},
    },
    report::{Provenance, study::shell_command},
    store::{StoreError, Writer},
    system::now,
    work::{Analyze, words},
};

/// Maximum number of lines of a message. The lower edge grows upward with it.
const MESSAGE: usize = 6;

/// The folder field and the outcome of the last export.
#[derive(Default)]
pub struct Export {
    /// The paths and the files in those that are folders. The export never replaces them.
    inputs: Vec<PathBuf>,
    folder: String,
    dialog: Dialog,
    work: Option<(PathBuf, BackgroundTask<Result<usize, StoreError>>)>,
    saving: Saving,
    /// What was shown when the outcome of the last export was; it says nothing about other results.
    of: Option<Analyze>,
    /// The folder with the last export.
    written: Option<PathBuf>,
}

/// Writes the files of an analysis into a folder; returns their number.
type Write = dyn Fn(&Writer, &Provenance, &Path) -> Result<usize, StoreError> + Send + Sync;

pub struct Exported<'a> {
    /// What was requested.
    pub request: &'a Analyze,
    /// A phrase that describes the selected data; empty if nothing is excluded.
    pub filter: String,
    pub write: Arc<Write>,
}

impl Export {
    /// Creates the controls for results from these files, which are what was found at the paths that were asked for.
    pub fn new(paths: &[PathBuf], files: impl Iterator<Item = PathBuf>) -> Self {
        let name = paths.first().and_then(|path| path.file_stem()).filter(|name| !name.is_empty());
        let name = name.map_or("machband".into(), |name| name.to_string_lossy());
        let folder = format!("{name}-analysis");
        Self { folder, inputs: paths.iter().cloned().chain(files).collect(), ..Self::default() }
    }

    /// Draws the controls. Nothing can be exported while no results are shown; `request` is what was asked for.
    pub fn show(&mut self, ui: &mut egui::Ui, request: Option<&Analyze>, exported: Option<&Exported<'_>>) {
        self.take_outcome(ui.ctx());
        if let Some(Exported { request, .. }) = exported
            && self.of.as_ref() != Some(request)
        {
            self.of = Some((*request).clone());
            self.saving = Saving::default();
        }
        let width = ui.available_width();
        let field = Field::new("Export to the folder").width(width).text(ui, &mut self.folder);
        let mut changed = field.changed();
        ui.horizontal_wrapped(|ui| {
            let folder = PathBuf::from(self.folder.trim());
            let ready = exported.is_some() && self.work.is_none() && !folder.as_os_str().is_empty();
            let writer = self.saving.button(ui, "Export", ready, &folder, &self.inputs);
            if let Some((exported, writer)) = exported.zip(writer) {
                self.start(ui.ctx(), folder, writer, exported);
            }
            changed |= self.dialog.browse(ui, FileKind::Folder, "Choose the folder to export to…", &mut self.folder);
        });
        if changed {
            self.forget();
        }
        let ink = ink(ui);
        let (note, color) = match self.saving.told(ui.ctx()) {
            _ if self.work.is_some() => ("Writing…", ink.dim),
            Some(error) => (error, ink.bad),
            None => ("", ink.dim),
        };
        two_lines(ui, note, color, MESSAGE);
        let copy = self.open_buttons(ui, request.is_some());
        if let Some(request) = request.filter(|_| copy) {
            let command = self.command(request);
            ui.ctx().copy_text(command.clone());
            say(ui.ctx(), format!("Copied: {command}"));
        }
        let included = match exported.map(|exported| exported.filter.as_str()) {
            None => String::new(),
            Some("") => "The export includes all data.".to_owned(),
            Some(filter) => format!("The export includes only the data shown: {filter}."),
        };
        two_lines(ui, &included, ink.dim, 2);
    }

    fn take_outcome(&mut self, ctx: &egui::Context) {
        let Some((folder, work)) = &self.work else { return };
        let Some(files) = work.poll() else { return };
        let files = files.unwrap_or_else(|Lost| {
            let what = "the export ended unexpectedly; expected files in the folder".to_owned();
            Err(StoreError::Protected { path: folder.clone(), what })
        });
        let outcome = files.map(|files| format!("{files} files written to {}", full(folder).display()));
        self.written = outcome.is_ok().then(|| folder.clone());
        self.saving.finish(folder, outcome);
        self.work = None;
        ctx.request_repaint();
    }

    fn forget(&mut self) {
        (self.saving, self.written) = (Saving::default(), None);
    }

    /// Draws the buttons that open the last export in other programs, and the one that copies the command, which it
    /// returns.
    fn open_buttons(&self, ui: &mut egui::Ui, is_ready: bool) -> bool {
        ui.horizontal_wrapped(|ui| {
            let folder = self.written.clone().unwrap_or_default();
            for (text, path) in [("Open report", folder.join("report.html")), ("Open folder", folder.clone())] {
                let button = ui.add_enabled(self.written.is_some(), egui::Button::new(text));
                if button.clicked()
                    && let Some(error) = open(&path)
                {
                    complain(ui.ctx(), error);
                }
            }
            ui.add_enabled(is_ready, egui::Button::new("Copy as command")).clicked()
        })
        .inner
    }

    fn start(&mut self, ctx: &egui::Context, folder: PathBuf, writer: Writer, exported: &Exported<'_>) {
        self.written = None;
        let (write, to, command) = (exported.write.clone(), folder.clone(), self.command(exported.request));
        let work = move || write(&writer, &Provenance::new(command, now()), &to);
        self.work = Some((folder, BackgroundTask::start(ctx, work)));
    }

    /// Returns the command that repeats the request.
    fn command(&self, request: &Analyze) -> String {
        let out = ["--out".to_owned(), self.folder.trim().to_owned()];
        shell_command(["analyze".to_owned()].into_iter().chain(words(request)).chain(out))
    }
}
