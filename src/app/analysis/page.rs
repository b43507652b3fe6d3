//! The page: what is read, and what is shown of it.

use std::path::{Path, PathBuf};

use eframe::egui;

use super::{
    columns::Columns,
    open_study::{OpenStudy, Request},
    start::{Choice, Start},
};
use crate::{
    app::ui::{
        Ask, Dialog, Step, escaped, fault, heading, hint, page_from,
        work::{Progress, Work},
    },
    report::Study,
    store::{FileFaults, ratings::ReadOptions},
};

/// The page.
pub struct Analysis {
    start: Start,
    dialog: Dialog,
    /// What is being read.
    reading: Option<Pending>,
    /// Why the last files could not be read.
    fault: Option<String>,
    columns: Option<Columns>,
    /// What was opened last.
    paths: Vec<PathBuf>,
    open: Option<Box<OpenStudy>>,
}

/// Files that are being read.
struct Pending {
    read_options: ReadOptions,
    /// The files that are open now, in another way.
    again: bool,
    work: Work<Result<Study, FileFaults>>,
}

impl Analysis {
    /// The page without data, for what is in a results folder and elsewhere.
    pub fn new(results: &Path) -> Self {
        Self {
            start: Start::new(results),
            dialog: Dialog::default(),
            reading: None,
            fault: None,
            columns: None,
            paths: Vec::new(),
            open: None,
        }
    }

    /// The page with a data set.
    pub fn of(ctx: &egui::Context, data_set: PathBuf) -> Self {
        let mut page = Self::new(data_set.parent().unwrap_or(Path::new("")));
        page.read(ctx, vec![data_set], ReadOptions::default(), false);
        page
    }

    /// Reads files, and folders of them. What was being read before is forgotten.
    fn read(&mut self, ctx: &egui::Context, paths: Vec<PathBuf>, read_options: ReadOptions, again: bool) {
        let read_options = ReadOptions { details: true, ..read_options };
        self.paths.clone_from(&paths);
        self.fault = None;
        let asked = read_options.clone();
        self.reading =
            Some(Pending { read_options, again, work: Work::start(ctx, move || Study::read(&paths, &asked)) });
    }

    fn read_new(&mut self, ctx: &egui::Context, paths: Vec<PathBuf>) {
        self.columns = None;
        self.read(ctx, paths, ReadOptions::default(), false);
    }

    /// Draws the page.
    pub fn show(&mut self, ui: &mut egui::Ui) -> Step {
        let escaped = escaped(ui) && ui.memory(|memory| memory.focused().is_none());
        self.take_files(ui.ctx());
        self.take_study();
        let back = match &mut self.open {
            Some(open) if self.columns.is_none() && self.reading.is_none() => {
                let back = open.show(ui);
                self.follow(ui.ctx());
                back
            }
            _ => self.show_start(ui),
        };
        Step::back_if(back || escaped)
    }

    fn take_files(&mut self, ctx: &egui::Context) {
        let dropped: Vec<PathBuf> =
            ctx.input(|input| input.raw.dropped_files.iter().map(|file| file.path().to_owned()).collect());
        let paths = if dropped.is_empty() { self.dialog.take_all() } else { Some(dropped) };
        if let Some(paths) = paths {
            self.read_new(ctx, paths);
        }
    }

    /// Takes what was read, if it is done.
    fn take_study(&mut self) {
        let Some(pending) = &self.reading else { return };
        let read = match pending.work.poll() {
            Progress::Going => return,
            Progress::Done(read) => read.map_err(|faults| faults.to_string()),
            Progress::Lost => Err("The files could not be read: reading ended unexpectedly".to_owned()),
        };
        let Some(Pending { read_options, again, .. }) = self.reading.take() else { return };
        match read {
            Ok(study) => {
                self.columns = None;
                let before = self.open.take().filter(|_| again);
                self.open = Some(Box::new(match before {
                    Some(before) => OpenStudy::reread(study, read_options, *before),
                    None => OpenStudy::new(study, self.paths.clone(), read_options),
                }));
            }
            Err(fault) => match self.open.as_mut().filter(|_| again) {
                Some(open) => open.keep(&read_options, fault),
                None => {
                    self.open = None;
                    self.columns = Columns::needed(&self.paths, &read_options);
                    // Before any column is named there is nothing wrong with the names.
                    let asked = self.columns.is_some() && read_options.subject.is_none();
                    self.fault = (!asked).then_some(fault);
                }
            },
        }
    }

    /// Does what the study's own controls ask for.
    fn follow(&mut self, ctx: &egui::Context) {
        let Some(open) = &mut self.open else { return };
        match open.take_request() {
            Some(Request::OtherData) => self.open = None,
            Some(Request::Columns) => self.columns = Columns::of(&self.paths, open.read_options()),
            Some(Request::Read(read_options)) => self.read(ctx, self.paths.clone(), read_options, true),
            None => {}
        }
    }

    /// The page while there is no study to show.
    fn show_start(&mut self, ui: &mut egui::Ui) -> bool {
        let ctx = ui.ctx().clone();
        page_from(ui, 0.02, |ui| {
            let back = heading(ui, "Analysis");
            if self.reading.is_some() {
                ui.horizontal(|ui| {
                    ui.spinner();
                    ui.label("Reading…");
                });
                for path in self.paths.iter().take(5) {
                    hint(ui, path.display().to_string());
                }
                return back;
            }
            let mut named = None;
            let mut keep = false;
            if let Some(columns) = &mut self.columns {
                named = columns.show(ui);
                keep = self.open.is_some() && ui.button("Leave the columns as they are").clicked();
            }
            for line in self.fault.iter().flat_map(|fault| fault.lines()).take(20) {
                fault(ui, line);
            }
            if self.columns.is_some() {
                ui.separator();
            }
            let choice = self.start.show(ui);
            self.dialog.missing_fault(ui);
            if keep {
                self.columns = None;
            }
            if let Some(read_options) = named {
                self.read(&ctx, self.paths.clone(), read_options, false);
            }
            match choice {
                Some(Choice::Open(path)) => self.read_new(&ctx, vec![path]),
                Some(Choice::Files) => self.dialog.open(&ctx, Ask::Data),
                Some(Choice::Folder) => self.dialog.open(&ctx, Ask::Folder),
                None => {}
            }
            back
        })
    }
}
