//! What the results of ratings and of other tasks share: the column of controls beside the sections; the export, which
//! writes the files that `machband analyze` writes, or copies the command; and the files as they were when they were read.

use std::{path::PathBuf, sync::Arc, time::SystemTime};

use eframe::egui::{self, CentralPanel, CollapsingHeader, Frame, Panel, RichText, ScrollArea};

use crate::{
    analysis::counts::Exclusions,
    app::ui::{
        Field, FileKind, Saving, Step, browse, complain, folded, full, heading, open, paragraph, pinned, say,
        text::{self, two_lines},
        theme::{self, ink},
        work::{BackgroundTask, Lost},
    },
    report::{Analyzed, Provenance, document::numbers::whole},
    store::{FileError, StoreError, ratings::with_files},
    system::{found, now},
    work::{self, Analyze},
};

/// Maximum number of listed errors, and of listed warnings.
const MAX_ERRORS: usize = 200;
/// In a window narrower than this, in points, the data and filters have a separate view.
const NARROW: f32 = 700.0;
/// Address of the section that says what was found, and address and heading of the view of data and filters.
pub const SUMMARY: &str = "summary";
const DATA: (&str, &str) = ("data", "Data");

/// An action that only the page can perform.
pub enum Request {
    OtherData,
    /// Read the same files again with other options.
    Read(Box<Analyze>),
}

/// Data that were read, and their analysis.
pub trait Opened {
    /// Takes and begins computations.
    fn update(&mut self, _: &egui::Context, _: &Files) {}

    /// Returns the address and the heading of every section.
    fn headings(&self) -> Vec<(&'static str, &'static str)>;

    /// Returns the title, and the errors and the warnings in the files.
    fn about(&self) -> (String, [&[FileError]; 2]);

    /// Draws what is selected of the files; returns how to read them in another way.
    fn controls(&mut self, ui: &mut egui::Ui, files: &Files) -> Option<Analyze>;

    /// Returns what is asked for, if anything is selected, and the results if they are of that.
    fn exported(&self) -> (Option<&Analyze>, Option<&Arc<Analyzed>>);

    /// Draws of which data the section at an address is, and how far a newer analysis is.
    fn state(&mut self, _: &mut egui::Ui, _: &str) {}

    /// Draws the section at an address; returns whether it exists.
    fn document(&mut self, ui: &mut egui::Ui, section: &str) -> bool;
}

/// What is around opened data: their files, the open section, and the export.
pub struct Shell {
    pub files: Files,
    /// The address of the open section.
    section: &'static str,
    /// The paths that were asked for, and the files in those that are folders. The export never replaces them.
    inputs: Vec<PathBuf>,
    /// The folder of the export, and the outcome of the last one.
    saving: Saving,
    export: Option<(PathBuf, BackgroundTask<Result<usize, StoreError>>)>,
    /// The folder with the last export.
    written: Option<PathBuf>,
}

impl Shell {
    /// Creates it for files that were asked for; `read` are the files that were read.
    pub fn new(files: Files, read: impl Iterator<Item = PathBuf>) -> Self {
        let paths = &files.asked.ratings.paths;
        let name = paths.first().and_then(|path| path.file_stem()).filter(|name| !name.is_empty());
        let name = name.map_or("machband".into(), |name| name.to_string_lossy());
        let saving = Saving::to(format!("{name}-analysis"));
        let inputs = paths.iter().cloned().chain(read).collect();
        Self { files, section: SUMMARY, inputs, saving, export: None, written: None }
    }

    /// Keeps the place and the export of the same files.
    pub fn after(self, before: Self) -> Self {
        Self { files: self.files, ..before }
    }

    /// Draws the data, which are dimmed while they are read again, and the `error` in reading them in another way.
    pub fn show(&mut self, ui: &mut egui::Ui, opened: &mut dyn Opened, is_stale: bool, error: &str) -> Step<Request> {
        opened.update(ui.ctx(), &self.files);
        let narrow = ui.available_width() < NARROW;
        let (mut back, mut request) = (false, None);
        let frame = Frame::NONE.inner_margin(12.0);
        if !narrow {
            if self.section == DATA.0 {
                self.section = SUMMARY;
            }
            let width = (ui.available_width() * 0.3).clamp(290.0, 360.0);
            let panel = Panel::left("analysis").resizable(false).exact_size(width).frame(frame);
            panel.show(ui, |ui| {
                theme::compact(ui);
                let mut both = (&mut *self, &mut *opened);
                pinned(
                    ui,
                    &mut both,
                    |ui, (shell, opened)| {
                        ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
                            back = heading(ui, "Analyze");
                            request = shell.controls(ui, &mut **opened, error);
                        });
                    },
                    |ui, (shell, opened)| shell.export(ui, &**opened, is_stale),
                );
            });
        }
        CentralPanel::default().frame(frame).show(ui, |ui| {
            theme::compact(ui);
            ui.horizontal_wrapped(|ui| {
                let all = opened.headings();
                if narrow {
                    back = ui.button("Back").clicked();
                    let all: Vec<_> = std::iter::once(DATA).chain(all).collect();
                    let heading =
                        |id: &&'static str| all.iter().find(|(one, _)| one == id).map_or("", |(_, heading)| heading);
                    let ids: Vec<&'static str> = all.iter().map(|(id, _)| *id).collect();
                    let field = Field::new("Section").width(180.0);
                    field.choice(ui, &mut self.section, &ids, |id| heading(id).to_owned());
                } else {
                    for (id, heading) in all {
                        ui.selectable_value(&mut self.section, id, heading);
                    }
                }
            });
            opened.state(ui, self.section);
            ui.separator();
            if self.section == DATA.0 {
                ScrollArea::vertical().id_salt("data").auto_shrink(false).show(ui, |ui| {
                    request = self.controls(ui, opened, error);
                    self.export(ui, opened, is_stale);
                });
                return;
            }
            if is_stale {
                ui.multiply_opacity(theme::STALE);
            }
            if !opened.document(ui, self.section) {
                self.section = SUMMARY;
            }
        });
        request.map_or(Step::back_if(back), Step::Next)
    }

    fn controls(&self, ui: &mut egui::Ui, opened: &mut dyn Opened, error: &str) -> Option<Request> {
        let (title, [errors, warnings]) = opened.about();
        paragraph(ui, RichText::new(title).strong());
        problems(ui, "Errors", errors, ink(ui).bad);
        problems(ui, "Warnings", warnings, ink(ui).warn);
        let other = ui.button("Other data…").clicked().then_some(Request::OtherData);
        ui.separator();
        let asked = opened.controls(ui, &self.files);
        text::errors(ui, error);
        other.or(asked.map(|asked| Request::Read(Box::new(asked))))
    }
}

/// Lists errors or warnings about the files.
fn problems(ui: &mut egui::Ui, title: &str, problems: &[FileError], color: egui::Color32) {
    if problems.is_empty() {
        return;
    }
    let header = RichText::new(format!("{title}: {}", problems.len())).color(color);
    folded(ui, CollapsingHeader::new(header).id_salt(title).default_open(true), |ui| {
        ScrollArea::vertical().id_salt(title).max_height(170.0).show(ui, |ui| {
            let more = problems.len().saturating_sub(MAX_ERRORS);
            let shown = problems.iter().take(MAX_ERRORS).map(ToString::to_string);
            for line in shown.chain((more > 0).then(|| format!("… and {} more", whole(more as u64)))) {
                paragraph(ui, RichText::new(line).small().color(color));
            }
        });
    });
}

/// Files that were read, and how.
pub struct Files {
    pub asked: Analyze,
    seen: Seen,
}

/// The size of each file and when it was last changed, or why that is not known.
type Seen = Result<Vec<(PathBuf, Option<(u64, Option<SystemTime>)>)>, String>;

impl Files {
    /// Looks at the files. Call this before they are read, so that no change is missed.
    pub fn of(asked: Analyze) -> Self {
        Self { seen: seen(&asked), asked }
    }

    /// Returns whether the files are now others, or have changed.
    pub fn have_changed(&self) -> bool {
        self.seen != seen(&self.asked)
    }
}

fn seen(asked: &Analyze) -> Seen {
    let files = with_files(asked.ratings.paths.clone()).map_err(|error| error.to_string())?;
    let state = |path: PathBuf| {
        let metadata = found(&path).map_err(|error| error.to_string())?;
        // The time of a folder also changes when something else is written into it.
        let file = metadata.filter(|metadata| !metadata.is_dir());
        Ok((path, file.map(|file| (file.len(), file.modified().ok()))))
    };
    files.into_iter().map(state).collect()
}

/// Maximum number of lines of a message. The lower edge grows upward with it.
const MESSAGE: usize = 6;

/// Returns whether a request excludes something.
pub fn is_filtered(request: &Analyze) -> bool {
    Exclusions::from(&request.ratings.how) != Exclusions::default()
}

impl Shell {
    /// Draws the controls of the export. Nothing can be exported while no results are shown.
    fn export(&mut self, ui: &mut egui::Ui, opened: &dyn Opened, is_stale: bool) {
        self.take_outcome(ui.ctx());
        let (request, analyzed) = opened.exported();
        let analyzed = analyzed.filter(|_| !is_stale);
        let width = ui.available_width();
        let mut changed = self.saving.field(ui, Field::new("Export to the folder").width(width)).changed();
        ui.horizontal_wrapped(|ui| {
            let folder = self.saving.path();
            let ready = analyzed.is_some() && self.export.is_none() && !folder.as_os_str().is_empty();
            let writer = self.saving.button(ui, "Export", ready, &self.inputs);
            if let Some(((analyzed, request), writer)) = analyzed.zip(request).zip(writer) {
                self.written = None;
                let (analyzed, made, to) = (analyzed.clone(), self.command(request), folder.clone());
                let work = move || {
                    let files = analyzed.write(&writer, &to, &Provenance::new(made, now()), false)?;
                    Ok(files.len())
                };
                self.export = Some((folder, BackgroundTask::start(ui.ctx(), work)));
            }
            let name = "Choose the folder to export to…";
            changed |= browse(ui, FileKind::Folder, name, &mut self.saving.typed);
        });
        if changed {
            self.saving.forget();
            self.written = None;
        }
        let ink = ink(ui);
        let (note, color) = match self.saving.told(ui.ctx()) {
            _ if self.export.is_some() => ("Writing…", ink.dim),
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
        let included = match request.filter(|_| analyzed.is_some()).map(is_filtered) {
            None => "",
            Some(false) => "The export includes all data.",
            Some(true) => "The export includes only the data shown.",
        };
        two_lines(ui, included, ink.dim, 2);
    }

    fn take_outcome(&mut self, ctx: &egui::Context) {
        let Some((folder, work)) = &self.export else { return };
        let Some(files) = work.poll() else { return };
        let files = files.unwrap_or_else(|Lost| {
            let what = "the export ended unexpectedly; expected files in the folder".to_owned();
            Err(StoreError::Protected { path: folder.clone(), what })
        });
        let outcome = files.map(|files| format!("{files} files written to {}", full(folder).display()));
        self.written = outcome.is_ok().then(|| folder.clone());
        self.saving.finish(folder, outcome);
        self.export = None;
        ctx.request_repaint();
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

    /// Returns the command that repeats the request.
    fn command(&self, request: &Analyze) -> String {
        work::command("analyze", request, &["--out", self.saving.typed.trim()])
    }
}
