//! Shows the analysis of a task other than a rating.

use std::sync::Arc;

use eframe::egui;

use super::{
    document::DocumentView,
    opened::{Exported, Files, Opened},
    query,
};
use crate::{
    app::ui::hint,
    report::{
        document::numbers::count,
        task_files,
        tasks::{TaskResults, TaskStudy, document, figures},
        write_files,
    },
    store::{FileError, table::List},
    text::names::natural,
    work::Analyze,
};

/// The results of a task, as they are shown.
pub struct OpenTask {
    asked: Analyze,
    made: Arc<(TaskStudy, TaskResults)>,
    /// All participants, and those who are to be left out.
    people: Vec<String>,
    excluded: Vec<String>,
    view: DocumentView,
}

impl OpenTask {
    /// Analyzes a study.
    pub fn new(study: TaskStudy, asked: &Analyze) -> Self {
        let results = TaskResults::of(&study, asked.resampling.seed);
        let view = DocumentView::new(document(&study, &results, &figures(&study, &results), None));
        let excluded = asked.ratings.how.exclude.clone().unwrap_or_default().0;
        // Those who are left out were not read.
        let mut people = [&study.people[..], &excluded].concat();
        people.sort_by(|a, b| natural(a, b));
        Self { asked: asked.clone(), made: Arc::new((study, results)), people, excluded, view }
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
        let study = &self.made.0;
        (study.asked.title.clone(), [&study.errors, &[]])
    }

    fn controls(&mut self, ui: &mut egui::Ui, _: &Files) -> Option<Analyze> {
        let study = &self.made.0;
        let people = count(study.people.len() as u64, "participant");
        hint(ui, format!("{people}, {}.", count(study.answers(), "answer")));
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

    fn exported(&self) -> (Option<&Analyze>, Option<Exported<'_>>) {
        let Self { asked, made, excluded, .. } = self;
        let made = made.clone();
        let exported = Exported {
            request: asked,
            is_filtered: !excluded.is_empty(),
            write: Arc::new(move |writer, provenance, folder| {
                let contents = task_files(&made.0, &made.1, provenance, folder, false)?;
                Ok(write_files(writer, folder, contents)?.len())
            }),
        };
        (Some(asked), Some(exported))
    }
}
