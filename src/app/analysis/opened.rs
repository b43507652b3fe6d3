//! Ratings that were read, what is asked of them, and what came out.

use std::{path::PathBuf, sync::Arc};

use eframe::egui;

use super::{
    NARROW,
    charts::{self, Sort},
    comparisons::Comparisons,
    export::Export,
    filters::{self, Filters},
    look,
    model::ModelView,
    plots,
    settings::Settings,
    source::SourceView,
    tables::Tables,
    words::many,
    work::{Progress, Work},
};
use crate::{
    analysis::{Options, Results, analyse},
    app::theme,
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
                egui::ScrollArea::vertical().auto_shrink(false).show(ui, |ui| {
                    theme::compact(ui);
                    // Room for the scroll bar.
                    ui.set_max_width(ui.available_width() - 6.0);
                    back = head(ui);
                    self.controls(ui);
                });
            });
        }
        egui::CentralPanel::default().frame(egui::Frame::NONE.inner_margin(12.0)).show(ui, |ui| {
            theme::compact(ui);
            if narrow {
                back = head(ui);
            }
            self.tabs(ui, tab, narrow);
            self.view(ui, *tab);
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

    /// Whether something newer than what is shown is on its way.
    fn is_busy(&self) -> bool {
        self.work.is_some()
    }

    fn tabs(&self, ui: &mut egui::Ui, tab: &mut Tab, narrow: bool) {
        let names = [
            (Tab::Data, "Data"),
            (Tab::Plots, "Plots"),
            (Tab::Tables, "Tables"),
            (Tab::Model, "Model"),
            (Tab::Tests, "Tests"),
        ];
        ui.horizontal_wrapped(|ui| {
            for (one, name) in names.into_iter().skip(usize::from(!narrow)) {
                let text = egui::RichText::new(name).size(17.0).strong();
                if ui.selectable_label(*tab == one, text).clicked() {
                    *tab = one;
                }
            }
            if self.is_busy() {
                ui.spinner();
                ui.label(theme::quiet("Analysing…"));
            }
        });
        ui.separator();
    }

    fn view(&mut self, ui: &mut egui::Ui, tab: Tab) {
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
            Tab::Plots => plots::show(ui, &outcome.sorts, &mut self.plot),
            Tab::Tables => outcome.tables.show(ui, &mut self.table),
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
        ui.separator();
        self.take_along(ui);
    }

    fn take_along(&mut self, ui: &mut egui::Ui) {
        // What is on the page, and nothing that is still being computed.
        let outcome = self.shown.as_ref().filter(|_| self.work.is_none());
        let left = outcome.map(|outcome| outcome.left_out(&self.study)).unwrap_or_default();
        self.export.show(ui, &self.study, outcome.map(|outcome| &outcome.results), &left);
        let whole = !self.filters.is_narrowed();
        let copy = ui.add_enabled(whole, egui::Button::new("Copy as command"));
        if copy.on_disabled_hover_text("The command analyses everything: check everything first.").clicked() {
            let command = self.command();
            ui.ctx().copy_text(command.clone());
            self.copied = Some(command);
        }
        if let Some(command) = self.copied.as_ref().filter(|_| whole) {
            look::quiet(ui, format!("Copied: {command}"));
        }
    }

    /// The same analysis by command.
    fn command(&self) -> String {
        let mut words = vec!["machband".to_owned(), "analyze".to_owned()];
        words.extend(self.paths.iter().map(|path| path.display().to_string()));
        words.extend(["--out".to_owned(), "analysis".to_owned()]);
        let columns =
            [("--subject", &self.how.subject), ("--response", &self.how.response), ("--count", &self.how.count)];
        for (name, column) in columns {
            words.extend(column.iter().flat_map(|column| [name.to_owned(), column.clone()]));
        }
        words.extend(self.settings.arguments());
        words.iter().map(|word| quoted(word)).collect::<Vec<_>>().join(" ")
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

/// The pane's name and the way back.
fn head(ui: &mut egui::Ui) -> bool {
    ui.horizontal(|ui| {
        ui.heading("Analysis");
        let back = ui.button("Back").clicked();
        ui.label(theme::quiet("Esc"));
        back
    })
    .inner
}

/// A word for a shell.
fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./:,=@%+".contains(c);
    if !word.is_empty() && word.chars().all(plain) {
        word.to_owned()
    } else {
        format!("'{}'", word.replace('\'', r"'\''"))
    }
}
