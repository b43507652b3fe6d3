//! Exports the analysis: writes the files that `machband analyze` writes, or copies the equivalent command.

use std::{
    path::{Path, PathBuf},
    sync::Arc,
};

use eframe::egui;

use crate::{
    analysis::{Link, Options, Random, Results, Slopes},
    app::ui::{
        Dialog, FileKind, Saving, full, hint, secondary, show_error,
        work::{BackgroundTask, Progress},
    },
    report::{Provenance, Study, study::shell_command, write_all},
    store::{
        StoreError, Writer,
        ratings::{ReadOptions, with_files},
        table::list,
    },
    system::now,
};

/// The folder field and the outcome of the last export.
pub struct Export {
    paths: Vec<PathBuf>,
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
    /// The data and how they were read.
    pub study: &'a Arc<Study>,
    pub read_options: &'a ReadOptions,
    pub results: &'a Arc<Results>,
    /// A phrase that describes the selected data; empty if nothing is excluded.
    pub filter: String,
}

impl Export {
    /// Creates the controls for results from these files.
    pub fn new(paths: Vec<PathBuf>) -> Self {
        let name = paths.first().and_then(|path| path.file_stem()).filter(|name| !name.is_empty());
        let name = name.map_or("machband".into(), |name| name.to_string_lossy());
        Self {
            folder: format!("{name}-analysis"),
            inputs: with_files(paths.clone()),
            paths,
            dialog: Dialog::default(),
            work: None,
            saving: Saving::default(),
            copied: None,
            written: None,
            not_opened: None,
        }
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
        let whole = exported.filter(|exported| exported.filter.is_empty());
        let copy = ui.add_enabled(whole.is_some(), egui::Button::new("Copy as command"));
        let copy = copy.on_disabled_hover_text("The command analyzes all data; select everything first.").clicked();
        if let Some(whole) = whole.filter(|_| copy) {
            let command = self.command(whole);
            ui.ctx().copy_text(command.clone());
            self.copied = Some(command);
        }
        if let Some(command) = self.copied.as_ref().filter(|_| whole.is_some()) {
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
                    let opened = open::that_detached(&path);
                    self.not_opened =
                        opened.err().map(|error| format!("{} cannot be opened: {error}", full(&path).display()));
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
        let mut command = self.command(exported);
        if !exported.filter.is_empty() {
            // A shell comment, because no command applies filters.
            command += &format!(" # filtered in the window: {}", exported.filter);
        }
        self.work = Some((folder, BackgroundTask::start(ctx, move || write(&writer, &study, &results, &command, &to))));
    }

    /// Returns the `machband analyze` command for these files and options. Filters and options with default values are
    /// omitted.
    fn command(&self, Exported { read_options, results, .. }: &Exported<'_>) -> String {
        let Options { terms, link, random, slopes, .. } = &results.options;
        let mut arguments = vec!["analyze".to_owned()];
        arguments.extend(self.paths.iter().map(|path| path.display().to_string()));
        let mut option = |name: &str, value: Option<String>| {
            arguments.extend(value.into_iter().flat_map(|value| [name.to_owned(), value]));
        };
        option("--subject", read_options.subject.clone());
        option("--response", read_options.response.clone());
        option("--count", read_options.count.clone());
        option("--categories", read_options.categories.as_ref().map(list));
        option("--factors", read_options.factors.as_ref().map(list));
        option("--terms", terms.as_ref().map(ToString::to_string));
        option("--link", (*link != Link::default()).then(|| link.to_string()));
        option("--random", (*random == Some(Random::None)).then(|| "none".to_owned()));
        option("--slopes", (*slopes != Slopes::default()).then(|| slopes.to_string()));
        option("--out", Some(self.folder.trim().to_owned()));
        arguments.extend(read_options.complete_only.then(|| "--complete-only".to_owned()));
        shell_command(arguments)
    }
}

/// Writes everything that `machband analyze` writes; returns the number of files.
fn write(writer: &Writer, study: &Study, results: &Results, command: &str, folder: &Path) -> Result<usize, StoreError> {
    // The report covers the ratings on which the results are based.
    let shown = Study { source: study.source.clone(), measured: results.measured.clone() };
    let made = Provenance::new(command, now());
    Ok(write_all(writer, &shown, results, &made, folder, false)?.files.len())
}
