//! Ratings that were read, what is asked of them, and what came out.

use std::{path::PathBuf, sync::Arc};

use eframe::egui;

use super::{
    NARROW,
    charts::{self, Sort},
    command,
    comparisons::Comparisons,
    export::{Export, Shown},
    filters::{self, Filters},
    look,
    model::ModelView,
    plots,
    settings::Settings,
    source::SourceView,
    tables::Tables,
    words::many,
};
use crate::{
    analysis::{Options, Results, analyse},
    app::{
        theme,
        work::{Progress, Work},
    },
    report::Study,
    store::ratings::Reading,
};

/// The views.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tab {
    /// Files, filters, model options: beside the others where there is room.
    Data,
    /// Plots.
    Plots,
    /// Tables.
    Tables,
    /// The model.
    Model,
    /// Tests on ranks, agreement.
    Tests,
}

/// Something that only the page can do.
pub enum Wish {
    /// Other data.
    Other,
    /// Other columns of the same file.
    Columns,
    /// The same files, read in another way.
    Again(Reading),
}

/// The data and its analysis.
pub struct Opened {
    study: Arc<Study>,
    how: Reading,
    source: SourceView,
    filters: Filters,
    settings: Settings,
    /// What the last analysis was asked, finished or not.
    asked: Option<Query>,
    work: Option<Work<Option<Outcome>>>,
    /// The last one that finished.
    shown: Option<Outcome>,
    fault: Option<String>,
    /// Why the files could not be read in another way.
    refused: Option<String>,
    plot: plots::Chosen,
    table: usize,
    export: Export,
    paths: Vec<PathBuf>,
    copied: Option<String>,
    wish: Option<Wish>,
}

/// What is asked of the data.
#[derive(Clone, Debug, PartialEq)]
struct Query {
    filters: Filters,
    options: Options,
}

/// What came out, ready to be drawn.
struct Outcome {
    query: Query,
    results: Arc<Results>,
    sorts: Vec<Sort>,
    tables: Tables,
    model: ModelView,
    comparisons: Comparisons,
}

impl Opened {
    /// A study that was read.
    pub fn new(study: Study, paths: Vec<PathBuf>, how: Reading) -> Self {
        Self {
            source: SourceView::new(&study.source),
            filters: Filters::new(&study.measured.counts),
            settings: Settings::default(),
            asked: None,
            work: None,
            shown: None,
            fault: None,
            refused: None,
            plot: plots::Chosen::default(),
            table: 0,
            export: Export::new(&paths),
            study: Arc::new(study),
            paths,
            how,
            copied: None,
            wish: None,
        }
    }

    /// The same files read in another way: what was chosen stays, as far as there still is a choice.
    pub fn again(study: Study, how: Reading, before: Self) -> Self {
        let (old, new) = (&before.study.measured.counts, &study.measured.counts);
        let same = old.subjects == new.subjects && old.factors == new.factors && old.conditions == new.conditions;
        Self {
            source: SourceView::new(&study.source),
            filters: if same { before.filters } else { Filters::new(new) },
            study: Arc::new(study),
            how,
            asked: None,
            work: None,
            shown: None,
            fault: None,
            wish: None,
            copied: None,
            refused: None,
            ..before
        }
    }

    /// The files could not be read in another way: what is here stays.
    pub fn refused(&mut self, how: &Reading, why: String) {
        // Not to be asked for again and again.
        self.how.also.clone_from(&how.also);
        self.refused = Some(why);
    }

    /// How it was read.
    pub fn how(&self) -> &Reading {
        &self.how
    }

    /// What is asked of the page, once.
    pub fn take_wish(&mut self) -> Option<Wish> {
        self.wish.take()
    }

    /// Draws everything; true where the page is to be left.
    pub fn show(&mut self, ui: &mut egui::Ui, tab: &mut Tab) -> bool {
        self.take_outcome();
        self.ask(ui.ctx());
        let narrow = ui.available_width() < NARROW;
        let mut back = false;
        if !narrow {
            *tab = if *tab == Tab::Data { Tab::Plots } else { *tab };
            let width = (ui.available_width() * 0.3).clamp(290.0, 360.0);
            let panel = egui::Panel::left("analysis").resizable(false).exact_size(width);
            panel.frame(egui::Frame::NONE.inner_margin(12.0)).show(ui, |ui| {
                look::dense(ui);
                egui::ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
                    back = theme::heading(ui, "Analysis");
                    self.controls(ui);
                });
            });
        }
        egui::CentralPanel::default().frame(egui::Frame::NONE.inner_margin(12.0)).show(ui, |ui| {
            look::dense(ui);
            ui.horizontal_wrapped(|ui| {
                if narrow {
                    back = ui.button("Back").clicked();
                }
                self.tabs(ui, tab, narrow);
            });
            ui.separator();
            self.view(ui, *tab, narrow);
        });
        back
    }

    /// What has come from the computation, if it has.
    fn take_outcome(&mut self) {
        match self.work.as_ref().map(Work::poll) {
            None | Some(Progress::Going) => return,
            Some(Progress::Done(outcome)) => self.shown = outcome,
            Some(Progress::Lost) => {
                self.fault = Some("The analysis ended unexpectedly; try other options or less data".to_owned());
            }
        }
        self.work = None;
    }

    /// Computes what is asked for, one thing at a time: what is asked meanwhile waits, and only the last of it is done.
    fn ask(&mut self, ctx: &egui::Context) {
        let Ok(options) = self.settings.options() else { return };
        let query = Query { filters: self.filters.clone(), options };
        if self.work.is_some() || self.asked.as_ref() == Some(&query) {
            return;
        }
        self.fault = None;
        self.asked = Some(query.clone());
        let study = self.study.clone();
        self.work = Some(Work::start(ctx, move || Outcome::new(&study, query)));
    }

    fn tabs(&self, ui: &mut egui::Ui, tab: &mut Tab, narrow: bool) {
        let names = [
            (Tab::Data, "Data"),
            (Tab::Plots, "Plots"),
            (Tab::Tables, "Tables"),
            (Tab::Model, "Model"),
            (Tab::Tests, "Tests"),
        ];
        for (one, name) in names.into_iter().skip(usize::from(!narrow)) {
            let text = egui::RichText::new(name).size(17.0).strong();
            if ui.selectable_label(*tab == one, text).clicked() {
                *tab = one;
            }
        }
        if self.work.is_some() {
            ui.spinner();
            ui.label(theme::quiet("Analysing…"));
        }
    }

    fn view(&mut self, ui: &mut egui::Ui, tab: Tab, narrow: bool) {
        if tab == Tab::Data {
            egui::ScrollArea::vertical().id_salt("data").auto_shrink(false).show(ui, |ui| self.controls(ui));
            return;
        }
        if let Some(fault) = &self.fault {
            theme::fault(ui, fault);
        }
        let Some(outcome) = &mut self.shown else {
            if self.work.is_none() && self.fault.is_none() {
                filters::nothing_left(ui);
            }
            return;
        };
        let left = outcome.left_out(&self.study);
        let people = many(outcome.results.people() as u64, "participant");
        let ratings = many(outcome.results.measured.counts.total(), "rating");
        let shown = if left.is_empty() { String::new() } else { format!(" Filtered: {left}.") };
        look::quiet(ui, format!("{ratings} of {people}.{shown}"));
        match tab {
            Tab::Data => {}
            Tab::Plots => plots::show(ui, &outcome.sorts, &mut self.plot, narrow),
            Tab::Tables => outcome.tables.show(ui, &mut self.table, narrow),
            Tab::Model => outcome.model.show(ui),
            Tab::Tests => outcome.comparisons.show(ui),
        }
    }

    /// Files, filters, model, export.
    fn controls(&mut self, ui: &mut egui::Ui) {
        self.source.show(ui);
        if self.source.unfinished {
            let mut complete = self.how.complete_only;
            if ui.checkbox(&mut complete, "Leave out unfinished sessions").changed() {
                self.wish = Some(Wish::Again(Reading { complete_only: complete, ..self.how.clone() }));
            }
        }
        if let Some(why) = &self.refused {
            theme::fault(ui, why);
        }
        ui.horizontal_wrapped(|ui| {
            if ui.button("Other data…").clicked() {
                self.wish = Some(Wish::Other);
            }
            if self.source.named && ui.button("Columns…").clicked() {
                self.wish = Some(Wish::Columns);
            }
        });
        ui.separator();
        let counts = &self.study.measured.counts;
        self.filters.show(ui, counts);
        if self.filters.is_narrowed() && ui.button("Everything again").clicked() {
            self.filters = Filters::new(counts);
        }
        ui.separator();
        let error = self.shown.as_ref().and_then(|outcome| outcome.results.model.as_ref().err());
        self.settings.show(ui, counts, self.filters.people(), error);
        self.read_columns_of_terms();
        ui.separator();
        self.take_along(ui);
    }

    fn take_along(&mut self, ui: &mut egui::Ui) {
        // What is on the page, and nothing that is still being computed.
        let outcome = self.shown.as_ref().filter(|_| self.work.is_none());
        let command =
            |outcome: &Outcome, out: &str| command::analyze(&self.paths, &self.how, &outcome.query.options, out);
        let shown = outcome.map(|outcome| Shown {
            study: &self.study,
            results: &outcome.results,
            filter: outcome.left_out(&self.study),
            command: command(outcome, self.export.folder()),
        });
        self.export.show(ui, shown);
        let whole = outcome.filter(|_| !self.filters.is_narrowed());
        let copy = ui.add_enabled(whole.is_some(), egui::Button::new("Copy as command"));
        if copy.on_disabled_hover_text("The command analyses everything: check everything first.").clicked() {
            self.copied = whole.map(|outcome| command(outcome, self.export.folder()));
            ui.ctx().copy_text(self.copied.clone().unwrap_or_default());
        }
        if let Some(command) = self.copied.as_ref().filter(|_| whole.is_some()) {
            look::quiet(ui, format!("Copied: {command}"));
        }
    }

    /// Columns that the terms name and that nobody has read yet, or that they name no more: then the files are read
    /// again.
    fn read_columns_of_terms(&mut self) {
        let counts = &self.study.measured.counts;
        let usual = counts
            .factors
            .iter()
            .map(|factor| factor.name.as_str())
            .filter(|name| !self.how.also.iter().any(|also| also == name));
        let also = self.settings.missing(usual);
        if also != self.how.also && self.wish.is_none() {
            self.wish = Some(Wish::Again(Reading { also, ..self.how.clone() }));
        }
    }
}

impl Outcome {
    /// Analyses what the filters leave; none where that is nothing.
    fn new(study: &Study, query: Query) -> Option<Self> {
        let measured = query.filters.apply(&study.measured);
        if measured.counts.total() == 0 {
            return None;
        }
        let results = analyse(measured, &query.options);
        Some(Self {
            sorts: charts::all(&results),
            tables: Tables::new(&results),
            model: ModelView::new(&results),
            comparisons: Comparisons::new(&results),
            results: Arc::new(results),
            query,
        })
    }

    /// What the filters left of a study, in words.
    fn left_out(&self, study: &Study) -> String {
        self.query.filters.words(&study.measured.counts)
    }
}
