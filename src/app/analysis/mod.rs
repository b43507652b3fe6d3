//! The analysis: files read, filtered and modelled; the plots, tables and tests of `machband analyze`, to be looked at
//! and taken along.

mod charts;
mod columns;
mod command;
mod comparisons;
mod export;
mod filters;
mod grid;
mod look;
mod model;
mod opened;
mod plots;
mod settings;
mod source;
mod start;
mod tables;
mod words;

use std::path::{Path, PathBuf};

use eframe::egui::{self, Key};

use super::{
    Go,
    dialog::{Ask, Dialog},
    theme,
    work::{Progress, Work},
};
use crate::{
    report::Study,
    store::{FileFaults, ratings::Reading},
};
use columns::Columns;
use opened::{Opened, Tab};
use start::{Start, Wish};

/// Narrower than this, the data and filters are a view of their own.
const NARROW: f32 = 700.0;

/// The page.
pub struct Analysis {
    start: Start,
    dialog: Dialog,
    /// What is being read.
    reading: Option<Pending>,
    /// Why the last files could not be read.
    fault: Option<String>,
    columns: Option<Columns>,
    /// What was asked for last.
    paths: Vec<PathBuf>,
    opened: Option<Box<Opened>>,
    tab: Tab,
}

/// Files on their way.
struct Pending {
    how: Reading,
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
            opened: None,
            tab: Tab::Plots,
        }
    }

    /// The page with a data set.
    pub fn of(ctx: &egui::Context, data_set: PathBuf) -> Self {
        let mut page = Self::new(data_set.parent().unwrap_or(Path::new("")));
        page.open(ctx, vec![data_set], Reading::default());
        page
    }

    /// Reads files, and folders of them. What was being read before is forgotten.
    fn open(&mut self, ctx: &egui::Context, paths: Vec<PathBuf>, how: Reading) {
        let how = Reading { details: true, ..how };
        self.paths.clone_from(&paths);
        self.fault = None;
        let asked = how.clone();
        self.reading = Some(Pending { how, again: false, work: Work::start(ctx, move || Study::read(&paths, &asked)) });
    }

    /// Draws the page.
    pub(super) fn show(&mut self, ui: &mut egui::Ui) -> Go {
        self.take_files(ui.ctx());
        self.take_study();
        // Escape closes an open list first.
        let listing = egui::Popup::is_any_open(ui.ctx());
        let reading = self.reading.is_some();
        let back = match &mut self.opened {
            Some(opened) if self.columns.is_none() && !reading => {
                let back = opened.show(ui, &mut self.tab);
                self.follow(ui.ctx());
                back
            }
            _ => self.empty(ui),
        };
        let typing = ui.ctx().memory(|memory| memory.focused().is_some());
        if back || !typing && !listing && ui.input(|input| input.key_pressed(Key::Escape)) {
            Go::Back
        } else {
            Go::Stay
        }
    }

    fn take_files(&mut self, ctx: &egui::Context) {
        let dropped: Vec<PathBuf> =
            ctx.input(|input| input.raw.dropped_files.iter().map(|file| file.path().to_owned()).collect());
        let paths = if dropped.is_empty() { self.dialog.take_all() } else { Some(dropped) };
        if let Some(paths) = paths {
            self.columns = None;
            self.open(ctx, paths, Reading::default());
        }
    }

    /// What was read, if it has come.
    fn take_study(&mut self) {
        let Some(pending) = &self.reading else { return };
        let read = match pending.work.poll() {
            Progress::Going => return,
            Progress::Done(read) => read.map_err(|faults| faults.to_string()),
            Progress::Lost => Err("The files could not be read: the reading ended unexpectedly".to_owned()),
        };
        let Some(Pending { how, again, .. }) = self.reading.take() else { return };
        match read {
            Ok(study) => {
                self.columns = None;
                let before = self.opened.take().filter(|_| again);
                self.opened = Some(Box::new(match before {
                    Some(before) => Opened::again(study, how, *before),
                    None => Opened::new(study, self.paths.clone(), how),
                }));
            }
            Err(fault) => match self.opened.as_mut().filter(|_| again) {
                Some(opened) => opened.refused(&how, fault),
                None => {
                    self.opened = None;
                    self.columns = Columns::needed(&self.paths, &how);
                    // Before any column is named there is nothing wrong with the names.
                    let asked = self.columns.is_some() && how.subject.is_none();
                    self.fault = (!asked).then_some(fault);
                }
            },
        }
    }

    /// What the data's own controls ask for.
    fn follow(&mut self, ctx: &egui::Context) {
        let Some(opened) = &mut self.opened else { return };
        match opened.take_wish() {
            Some(opened::Wish::Other) => self.opened = None,
            Some(opened::Wish::Columns) => self.columns = Columns::of(&self.paths, opened.how()),
            Some(opened::Wish::Again(how)) => {
                self.open(ctx, self.paths.clone(), how);
                if let Some(pending) = &mut self.reading {
                    pending.again = true;
                }
            }
            None => {}
        }
    }

    /// The page while there is nothing to show.
    fn empty(&mut self, ui: &mut egui::Ui) -> bool {
        let mut back = false;
        let mut wish = None;
        let mut named = None;
        let mut keep = false;
        theme::page_from(ui, 0.02, |ui| {
            back = theme::heading(ui, "Analysis");
            if self.reading.is_some() {
                ui.horizontal(|ui| {
                    ui.spinner();
                    ui.label("Reading…");
                });
                for path in self.paths.iter().take(5) {
                    look::quiet(ui, path.display().to_string());
                }
                return;
            }
            if let Some(columns) = &mut self.columns {
                named = columns.show(ui);
                keep = self.opened.is_some() && ui.button("Leave the columns as they are").clicked();
            }
            for line in self.fault.iter().flat_map(|fault| fault.lines()).take(20) {
                theme::fault(ui, line);
            }
            if self.columns.is_some() {
                ui.add_space(8.0);
                ui.separator();
            }
            wish = self.start.show(ui, self.dialog.is_missing());
        });
        if keep {
            self.columns = None;
        }
        if let Some(how) = named {
            self.open(ui.ctx(), self.paths.clone(), how);
        }
        match wish {
            Some(Wish::Open(paths)) => {
                self.columns = None;
                self.open(ui.ctx(), paths, Reading::default());
            }
            Some(Wish::Files) => self.dialog.open(ui.ctx(), Ask::Data),
            Some(Wish::Folder) => self.dialog.open(ui.ctx(), Ask::Folder),
            None => {}
        }
        back
    }
}
