//! Shows the analysis of a task other than a rating.

use std::sync::Arc;

use eframe::egui;

use super::{
    document::DocumentView,
    opened::{Files, Opened},
    query,
};
use crate::{
    app::ui::hint,
    report::{Analyzed, document::numbers::count, tasks::TaskStudy},
    store::{FileError, table::List},
    text::names::natural,
    work::Analyze,
};

/// The results of a task, as they are shown.
pub struct OpenTask {
    asked: Analyze,
    title: String,
    /// How many people gave how many answers.
    sample: String,
    analyzed: Arc<Analyzed>,
    /// All participants, and those who are to be left out.
    people: Vec<String>,
    excluded: Vec<String>,
    view: DocumentView,
}

impl OpenTask {
    /// Analyzes a study.
    pub fn new(study: TaskStudy, asked: &Analyze) -> Self {
        let excluded = asked.ratings.how.exclude.clone().unwrap_or_default().0;
        // Those who are left out were not read.
        let mut people = [&study.people[..], &excluded].concat();
        people.sort_by(|a, b| natural(a, b));
        let sample =
            format!("{}, {}.", count(study.people.len() as u64, "participant"), count(study.answers(), "answer"));
        let title = study.asked.title.clone();
        let analyzed = asked.analyze_task(study);
        let view = DocumentView::new(analyzed.document(&analyzed.figures(), None));
        Self { asked: asked.clone(), title, sample, analyzed: analyzed.into(), people, excluded, view }
    }

    /// Keeps the pictures of the same data with another selection, or as they were before.
    pub fn after(self, before: Self) -> Self {
        Self { view: self.view.after(&before.view), ..self }
    }
}

impl Opened for OpenTask {
    fn headings(&self) -> Vec<(&'static str, &'static str)> {
        self.view.headings().collect()
    }

    fn document(&mut self, ui: &mut egui::Ui, section: &str) -> bool {
        self.view.show(ui, section)
    }

    fn about(&self) -> (String, [&[FileError]; 2]) {
        (self.title.clone(), self.analyzed.problems())
    }

    fn controls(&mut self, ui: &mut egui::Ui, _: &Files) -> Option<Analyze> {
        hint(ui, &self.sample);
        let before = self.excluded.clone();
        query::people(ui, &self.people, &mut self.excluded);
        if ui.add_enabled(!self.excluded.is_empty(), egui::Button::new("Select everything")).clicked() {
            self.excluded.clear();
        }
        (self.excluded != before).then(|| {
            let mut asked = self.asked.clone();
            asked.ratings.how.exclude = (!self.excluded.is_empty()).then(|| List(self.excluded.clone()));
            asked
        })
    }

    fn exported(&self) -> (Option<&Analyze>, Option<&Arc<Analyzed>>) {
        (Some(&self.asked), Some(&self.analyzed))
    }
}
