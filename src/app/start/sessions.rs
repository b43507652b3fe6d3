//! The sessions in the results folder, with a button to resume each unfinished one.

use std::path::{Path, PathBuf};

use eframe::egui::{self, Align, Label, Layout, ScrollArea, Ui};

use crate::{
    app::ui::{hint, secondary, show_error, text::name, work::Latest},
    store::session::overview::{Overview, SessionState},
};

/// The sessions in a results folder, which are read on a separate thread.
#[derive(Default)]
pub struct SessionList {
    /// Increased to read the folder again.
    edition: u64,
    read: Latest<(PathBuf, u64), Overview>,
    /// What was read last; it stays until the folder has been read again.
    shown: Overview,
}

impl SessionList {
    /// Reads the folder again, because it may have changed.
    pub fn refresh(&mut self) {
        self.edition += 1;
    }

    /// Draws the list; returns the session to resume.
    pub fn show(&mut self, ui: &mut Ui, results: &Path) -> Option<SessionState> {
        let key = (results.to_owned(), self.edition);
        self.read.want(ui.ctx(), key.clone(), || {
            let results = results.to_owned();
            move || Ok(Overview::of(&results))
        });
        if let Some(Ok(read)) = self.read.get(&key)
            && self.shown != *read
        {
            self.shown.clone_from(read);
        }
        let Overview { sessions, errors } = &self.shown;
        if sessions.is_empty() && errors.is_empty() {
            hint(ui, format!("There are no sessions in the folder {} yet.", results.display()));
            return None;
        }
        let mut resume = None;
        let height = ui.spacing().interact_size.y;
        ScrollArea::vertical().id_salt("sessions").auto_shrink(false).show(ui, |ui| {
            errors.iter().flat_map(|error| error.lines()).for_each(|error| show_error(ui, error));
            for session in sessions {
                ui.allocate_ui_with_layout(
                    egui::vec2(ui.available_width(), height),
                    Layout::right_to_left(Align::Center),
                    |ui| {
                        if row(ui, session) {
                            resume = Some(session.clone());
                        }
                    },
                );
            }
        });
        resume
    }

    /// Returns how many sessions there are, and how many of them are complete.
    pub fn counts(&self) -> (usize, usize) {
        let sessions = &self.shown.sessions;
        (sessions.len(), sessions.iter().filter(|session| session.complete).count())
    }
}

/// Draws a session, from right to left; returns whether to resume it.
fn row(ui: &mut Ui, session: &SessionState) -> bool {
    let SessionState { identity, experiment, rated, planned, complete, .. } = session;
    let (subject, number) = (identity.subject(), identity.session());
    let mut resume = false;
    let state = if *complete {
        ui.label(secondary(session.day()));
        format!("{planned} trials, done")
    } else {
        let button = ui.button("Resume");
        name(ui, &button, &format!("Resume {subject}, session {number} of {experiment}"));
        resume = button.on_hover_text(format!("Last used on {}.", session.day())).clicked();
        format!("{rated} of {planned}")
    };
    ui.with_layout(Layout::left_to_right(Align::Center), |ui| {
        let text = format!("{subject} · session {number} · {experiment} · {state}");
        ui.add(Label::new(text).truncate());
    });
    resume
}
