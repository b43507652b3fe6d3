//! Shows the analysis of a task other than a rating.

use std::sync::Arc;

use eframe::egui::{self, RichText};

use super::{
    document::DocumentView,
    opened::{Export, Exported, Files, Opened, Request, problems, show_opened},
    query,
};
use crate::{
    app::ui::{Step, hint, paragraph, theme},
    report::{
        document::numbers::count,
        task_files,
        tasks::{TaskResults, TaskStudy, document, figures},
        write_files,
    },
    store::table::List,
    text::names::natural,
};

/// The results of a task, as they are shown.
pub struct OpenTask {
    made: Arc<(TaskStudy, TaskResults)>,
    files: Arc<Files>,
    /// All participants, and those who are to be left out.
    people: Vec<String>,
    excluded: Vec<String>,
    view: DocumentView,
    section: &'static str,
    export: Export,
    /// Whether the data are being read with another selection.
    is_stale: bool,
    request: Option<Request>,
}

impl OpenTask {
    /// Analyzes a study.
    pub fn new(study: TaskStudy, files: Arc<Files>) -> Self {
        let asked = &files.asked.ratings;
        let results = TaskResults::of(&study, files.asked.resampling.seed);
        let view = DocumentView::new(document(&study, &results, &figures(&study, &results), None));
        let excluded = asked.how.exclude.clone().unwrap_or_default().0;
        // Those who are left out were not read.
        let mut people = [&study.people[..], &excluded].concat();
        people.sort_by(|a, b| natural(a, b));
        let export = Export::new(&asked.paths, study.files.iter().map(|(path, _)| path.clone()));
        let made = Arc::new((study, results));
        Self { made, files, people, excluded, view, section: "summary", export, is_stale: false, request: None }
    }

    /// Keeps the place and the pictures of the same data with another selection, or as they were before.
    pub fn after(self, before: Self) -> Self {
        let view = self.view.after(before.view);
        Self { view, section: before.section, export: before.export, ..self }
    }

    /// Draws the page. `is_stale`: the data are being read with another selection; `error`: why they could not be.
    pub fn show(&mut self, ui: &mut egui::Ui, is_stale: bool, error: &str) -> Step<Request> {
        self.is_stale = is_stale;
        let back = show_opened(ui, self, error);
        self.request.take().map_or(Step::back_if(back), Step::Next)
    }
}

impl Opened for OpenTask {
    fn section(&mut self) -> &mut &'static str {
        &mut self.section
    }

    fn headings(&self) -> Vec<(&'static str, &'static str)> {
        self.view.headings().collect()
    }

    fn document(&mut self, ui: &mut egui::Ui) {
        if self.is_stale {
            ui.multiply_opacity(theme::STALE);
        }
        if !self.view.show(ui, self.section) {
            self.section = "summary";
        }
    }

    fn controls(&mut self, ui: &mut egui::Ui) {
        let study = &self.made.0;
        paragraph(ui, RichText::new(&study.asked.title).strong());
        let people = count(study.people.len() as u64, "participant");
        hint(ui, format!("{people}, {}.", count(study.answers(), "answer")));
        problems(ui, "Errors", &study.errors, theme::ink(ui).bad);
        if ui.button("Other data…").clicked() {
            self.request = Some(Request::OtherData);
        }
        ui.separator();
        let before = self.excluded.clone();
        query::people(ui, &self.people, &mut self.excluded);
        if ui.add_enabled(!self.excluded.is_empty(), egui::Button::new("Select everything")).clicked() {
            self.excluded.clear();
        }
        if self.excluded != before {
            let mut asked = self.files.asked.clone();
            asked.ratings.how.exclude = (!self.excluded.is_empty()).then(|| List(self.excluded.clone()));
            self.request = Some(Request::Read(Box::new(asked)));
        }
    }

    fn export(&mut self, ui: &mut egui::Ui) {
        let Self { made, files, people, excluded, is_stale, .. } = self;
        let left = people.len() - excluded.len();
        let filter =
            if excluded.is_empty() { String::new() } else { format!("{left} of {} participants", people.len()) };
        let made = made.clone();
        let exported = Exported {
            request: &files.asked,
            filter,
            write: Arc::new(move |writer, provenance, folder| {
                let contents = task_files(&made.0, &made.1, provenance, folder, false)?;
                Ok(write_files(writer, folder, contents)?.len())
            }),
        };
        self.export.show(ui, Some(&files.asked), Some(&exported).filter(|_| !*is_stale));
    }
}
