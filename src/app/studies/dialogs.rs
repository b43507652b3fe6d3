//! The dialogs, and the results of what ran in the background.

use eframe::egui::{self, ScrollArea};

use super::{
    grid::Cell,
    jobs::Made,
    page::{Destination, Now, Open, Studies},
};
use crate::{
    app::ui::{self, Field, FileKind, Step, theme::GAP},
    report::document::numbers::count,
};

impl Studies {
    /// Draws the open dialog; returns where it leads.
    pub(super) fn dialog(&mut self, ui: &mut egui::Ui, open: Open, now: &mut Now<'_>) -> Option<Destination> {
        let ctx = &ui.ctx().clone();
        self.open = match open {
            Open::Session => {
                self.open = Some(Open::Session);
                return self.session_dialog(ui, now);
            }
            Open::Definition(path) => self.definition_dialog(ctx, path).map(Open::Definition),
            Open::Request(mut form) => match form.show(ctx) {
                Step::Stay => Some(Open::Request(form)),
                Step::Back => None,
                Step::Next(job) => {
                    self.job = Some(job);
                    None
                }
            },
            Open::Planned(planned) => {
                let (done, closed) = ui::modal(ctx, "planned", 680.0, |ui, height| {
                    ui.heading("Plan");
                    ScrollArea::vertical().max_height(height - 120.0).show(ui, |ui| {
                        planned.iter().for_each(|sentence| ui::paragraph(ui, sentence));
                    });
                    ui.add_space(GAP);
                    ui.button("Close").clicked()
                });
                (!done && !closed).then_some(Open::Planned(planned))
            }
            Open::Removal(session) => {
                let title = Cell::of(&session.identity).title();
                let text = format!("Nothing was rated in {title}, so no rating is lost.");
                match ui::ask(ctx, "Remove the empty session?", &text, ["Keep", "Remove"]) {
                    None => Some(Open::Removal(session)),
                    Some(false) => None,
                    Some(true) => {
                        match session.remove() {
                            Ok(()) => ui::say(ctx, format!("{title} was removed.")),
                            Err(error) => ui::complain(ctx, error.to_string()),
                        }
                        (self.checked, self.selected) = (None, None);
                        self.form.cell.subject.clear();
                        self.sessions.refresh();
                        None
                    }
                }
            }
        };
        None
    }

    /// Draws the dialog that opens a definition; returns what was typed, unless it is closed.
    fn definition_dialog(&mut self, ctx: &egui::Context, mut path: String) -> Option<String> {
        let entered = ui::entered(ctx);
        let (done, closed) = ui::modal(ctx, "definition", 560.0, |ui, _| {
            ui.heading("Open a definition");
            ui::hint(ui, "A file in the format of docs/definitions.md. It can also be dropped on this window.");
            ui.add_space(GAP);
            let field = Field::new("Definition").column(96.0).hint("path of a .toml file");
            let browse = (FileKind::Toml, "Choose a definition…");
            let (field, browsed) = field.path(ui, &mut path, &mut self.experiment, browse);
            if std::mem::take(&mut self.opening) {
                field.request_focus();
            }
            ui.add_space(GAP);
            ui.horizontal(|ui| {
                let ready = !path.trim().is_empty();
                let opened = ui::primary(ui, "Open", ready, "") || ready && (entered || browsed);
                opened.then_some(true).or(ui.button("Cancel").clicked().then_some(false))
            })
            .inner
        });
        if done == Some(true) {
            self.choose_experiment(path.trim().to_owned());
        }
        (done.is_none() && !closed).then_some(path)
    }

    /// Takes the result of the job; a simulated study is analyzed.
    pub(super) fn take_made(&mut self, ctx: &egui::Context) -> Option<Destination> {
        let job = self.job.as_ref()?;
        let (made, warnings) = (job.poll()?, job.warnings());
        (self.job, self.error) = (None, None);
        warnings.into_iter().for_each(|warning| ui::complain(ctx, warning));
        match made {
            Err(error) => ui::complain(ctx, error),
            Ok(Made::Checked(found)) => {
                let sessions = count(found.sessions as u64, "session");
                match found.errors.len() as u64 {
                    0 => ui::say(ctx, format!("{sessions} checked; no errors")),
                    n => ui::complain(ctx, format!("{sessions} checked; {}", count(n, "error"))),
                }
                self.found = found;
            }
            Ok(Made::Planned(planned)) => self.open = Some(Open::Planned(planned)),
            Ok(Made::Told(text)) => ui::say(ctx, text),
            Ok(Made::Pilot(folder)) => {
                ui::say(ctx, format!("Simulated in {}", folder.display()));
                return Some(Destination::Analysis(folder));
            }
        }
        None
    }
}
