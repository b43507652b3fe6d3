//! Shows the analysis of a task other than a rating.

use eframe::egui::{self, CentralPanel, Frame};

use super::{document::DocumentView, open_study::dense};
use crate::{
    app::ui::{heading, hint},
    report::{
        study::shell_command,
        tasks::{TaskResults, TaskStudy, document, figures},
    },
    work::{Analyze, words},
};

/// The results of a task, as they are shown.
pub struct OpenTask {
    view: DocumentView,
    section: &'static str,
    /// The command that writes the report.
    command: String,
    copied: bool,
}

/// A document that was made on another thread.
pub struct TaskDocument(crate::report::document::Document);

impl TaskDocument {
    /// Analyzes a study.
    pub fn of(study: &TaskStudy, asked: &Analyze) -> Self {
        let results = TaskResults::of(study, asked.resampling.seed);
        Self(document(study, &results, &figures(study, &results), None))
    }
}

impl OpenTask {
    /// Shows a document.
    pub fn new(TaskDocument(document): TaskDocument, asked: &Analyze) -> Self {
        let out = ["--out", "analysis"].map(str::to_owned);
        let command = shell_command(["analyze".to_owned()].into_iter().chain(words(asked)).chain(out));
        Self { view: DocumentView::new(document, None), section: "summary", command, copied: false }
    }

    /// Draws the page; returns whether the user leaves it.
    pub fn show(&mut self, ui: &mut egui::Ui) -> bool {
        let mut back = false;
        CentralPanel::default().frame(Frame::NONE.inner_margin(12.0)).show(ui, |ui| {
            dense(ui);
            back = heading(ui, "Analysis");
            ui.horizontal_wrapped(|ui| {
                for (id, heading) in self.view.headings() {
                    ui.selectable_value(&mut self.section, id, heading);
                }
                ui.separator();
                if ui.button("Copy as command").clicked() {
                    ui.ctx().copy_text(self.command.clone());
                    self.copied = true;
                }
            });
            if self.copied {
                hint(ui, format!("Copied: {}. It writes the report, its figures and the tables.", self.command));
            }
            ui.separator();
            self.view.show(ui, self.section);
        });
        back
    }
}
