//! The analysis as files: what `machband analyze` writes.

use std::{
    path::{Path, PathBuf},
    sync::Arc,
};

use eframe::egui;
use jiff::Timestamp;

use super::look;
use crate::{
    analysis::Results,
    app::{
        dialog::{Ask, Dialog},
        theme,
        work::{Progress, Work},
    },
    report::{Extent, Repetition, Study, write_all},
};

/// The field, and what was said of the last export.
pub struct Export {
    folder: String,
    dialog: Dialog,
    work: Option<(PathBuf, Work<Result<usize, String>>)>,
    said: Option<Result<String, String>>,
    /// A folder with files in it, which may be written into if asked again.
    standing: Option<PathBuf>,
}

/// What is to be written.
pub struct Shown<'a> {
    /// What was read.
    pub study: &'a Arc<Study>,
    /// What was made of it.
    pub results: &'a Arc<Results>,
    /// What the filters left, in words; empty where that is everything.
    pub filter: String,
    /// The command that does the same without filters.
    pub command: String,
}

impl Export {
    /// For the results of these files.
    pub fn new(paths: &[PathBuf]) -> Self {
        let name = paths.first().and_then(|path| path.file_stem()).map(|name| name.to_string_lossy().into_owned());
        Self {
            folder: format!(
                "{}-analysis",
                name.filter(|name| !name.is_empty()).unwrap_or_else(|| "machband".to_owned())
            ),
            dialog: Dialog::default(),
            work: None,
            said: None,
            standing: None,
        }
    }

    /// The folder as it is typed.
    pub fn folder(&self) -> &str {
        self.folder.trim()
    }

    /// Draws it; there is nothing to write while nothing is shown.
    pub fn show(&mut self, ui: &mut egui::Ui, shown: Option<Shown<'_>>) {
        self.take(ui.ctx());
        let label = ui.label("Export to the folder");
        let width = ui.available_width();
        let field = ui.add(egui::TextEdit::singleline(&mut self.folder).desired_width(width)).labelled_by(label.id);
        if field.changed() {
            self.said = None;
            self.standing = None;
        }
        let folder = PathBuf::from(self.folder.trim());
        let again = self.standing.as_ref() == Some(&folder);
        ui.horizontal_wrapped(|ui| {
            let text = if again { "Write into it" } else { "Export" };
            let ready = shown.is_some() && self.work.is_none() && !folder.as_os_str().is_empty();
            if ui.add_enabled(ready, egui::Button::new(text)).clicked()
                && let Some(shown) = &shown
            {
                self.start(ui.ctx(), folder, again, shown);
            }
            let browse = ui.button("Browse…");
            look::named(ui, &browse, "Choose the folder to export to…");
            if browse.clicked() {
                self.dialog.open(ui.ctx(), Ask::Folder);
            }
            if self.work.is_some() {
                ui.spinner();
                ui.label(theme::quiet("Writing…"));
            }
        });
        if let Some(Shown { filter, .. }) = shown.filter(|shown| !shown.filter.is_empty()) {
            look::quiet(ui, format!("Exported is what is shown: {filter}."));
        }
        if self.dialog.is_missing() {
            theme::fault(ui, "No file dialog opened on this system: type the folder's path.");
        }
        match &self.said {
            Some(Ok(text)) => look::quiet(ui, text),
            Some(Err(text)) => theme::fault(ui, text),
            None => {}
        }
    }

    fn take(&mut self, ctx: &egui::Context) {
        if let Some(path) = self.dialog.take() {
            self.folder = path.display().to_string();
            self.said = None;
            self.standing = None;
        }
        let Some((folder, work)) = &self.work else { return };
        let said = match work.poll() {
            Progress::Going => return,
            Progress::Done(Ok(files)) => Ok(format!("{files} files written to {}", folder.display())),
            Progress::Done(Err(fault)) => Err(fault),
            Progress::Lost => Err("The export ended unexpectedly; expected files in the folder".to_owned()),
        };
        self.said = Some(said);
        self.work = None;
        ctx.request_repaint();
    }

    fn start(&mut self, ctx: &egui::Context, folder: PathBuf, again: bool, shown: &Shown<'_>) {
        let occupied = folder.read_dir().is_ok_and(|mut entries| entries.next().is_some());
        if occupied && !again {
            let text = format!("{} has files in it, which may be replaced; expected a new folder", folder.display());
            self.said = Some(Err(text));
            self.standing = Some(folder);
            return;
        }
        self.standing = None;
        self.said = None;
        let (study, results, to) = (shown.study.clone(), shown.results.clone(), folder.clone());
        let mut command = shown.command.clone();
        if !shown.filter.is_empty() {
            // A comment of the shell: no command filters.
            command += &format!(" # filtered in the window: {}", shown.filter);
        }
        self.work = Some((folder, Work::start(ctx, move || write(&study, &results, &command, &to))));
    }
}

/// Writes everything that `machband analyze` writes; the number of files.
fn write(study: &Study, results: &Results, command: &str, folder: &Path) -> Result<usize, String> {
    // The report is about the ratings that the results are of.
    let shown = Study { source: study.source.clone(), measured: results.measured.clone() };
    let made = Repetition::new(command, Timestamp::now());
    let written = write_all(&shown, results, &made, folder, Extent::Everything).map_err(|error| error.to_string())?;
    Ok(written.files.len())
}
