//! The title of a study, and what can be done with it.

use std::path::Path;

use eframe::egui::{self, Align, Layout, Popup, RichText, Ui};

use super::{
    form::Checked,
    grid::Cell,
    jobs::Job,
    page::{Destination, LIST, Open, Studies},
    pilot::{ExportForm, PilotForm},
};
use crate::{
    app::ui::{
        self, Monitor, action, main_action, quiet,
        theme::{self, Icon, NARROW},
    },
    experiment::Protocol,
    store::{definition::BUILT_IN, session::overview::SessionState, settings::Settings},
};

/// In a page narrower than this, in points, what is rarely needed is in a menu.
const ROOM_FOR_ACTIONS: f32 = 560.0;
/// In a window narrower than this, in points, buttons beside the title have no words.
const SMALL: f32 = 600.0;
/// In a page narrower than this, in points, all but beginning and resuming sessions is in a menu.
const ROOM_FOR_ALL: f32 = 720.0;

impl Studies {
    /// Draws the title of the study, its extent, and what is rarely needed.
    pub(super) fn title(&mut self, ui: &mut Ui, checked: &Checked, settings: &mut Settings) -> Option<Destination> {
        let experiment = self.form.experiment.trim().to_owned();
        let is_built_in = BUILT_IN.iter().any(|built_in| built_in.name == experiment);
        let mut next = None;
        ui.with_layout(Layout::right_to_left(Align::Min), |ui| {
            let is_wide = ui.available_width() >= ROOM_FOR_ACTIONS;
            let more = quiet(ui, Icon::More, "", "More");
            Popup::menu(&more).show(|ui| {
                if !is_wide && !is_built_in && ui.button("Duplicate as…").clicked() {
                    next = Some(Destination::Editor(experiment.clone(), None));
                }
                if ui.button("Open the folder").clicked()
                    && let Some(error) = ui::open(&self.folder())
                {
                    ui::complain(ui.ctx(), error);
                }
                if !is_built_in && ui.button("Remove from the list").clicked() {
                    settings.recent.experiments.retain(|other| *other != experiment);
                    self.choose_experiment(BUILT_IN[0].name.to_owned());
                    ui::say(ui.ctx(), format!("{experiment} is no longer listed; the file and its sessions stay."));
                }
            });
            if (is_wide || is_built_in) && quiet(ui, Icon::Plus, "Duplicate as…", "Duplicate as…").clicked() {
                next = Some(Destination::Editor(experiment.clone(), None));
            }
            let word = |ui: &Ui, word| if ui.ctx().content_rect().width() < SMALL { "" } else { word };
            if !is_built_in && quiet(ui, Icon::Edit, word(ui, "Edit"), "Edit").clicked() {
                let name = checked.protocol.as_ref().map_or("", |protocol| &protocol.name);
                next = Some(Destination::Editor(experiment.clone(), Some(self.sessions.of(name).count())));
            }
            if ui.ctx().content_rect().width() < NARROW {
                let menu = quiet(ui, Icon::Down, word(ui, "Studies"), "Choose another study");
                Popup::menu(&menu).width(LIST[1]).show(|ui| {
                    ui.set_max_height(420.0);
                    self.studies(ui);
                });
            }
            ui.with_layout(Layout::top_down(Align::Min), |ui| {
                let file = Path::new(&experiment).file_name().unwrap_or_default().to_string_lossy().into_owned();
                let title = checked.protocol.as_ref().map_or(file.as_str(), |protocol| &protocol.title);
                ui.add(egui::Label::new(RichText::new(title).heading().strong()).wrap());
                if let Some(protocol) = &checked.protocol {
                    let (conditions, sessions) = (protocol.conditions().len(), protocol.plan.sessions);
                    let task = match &protocol.adaptive {
                        Some(adaptive) => {
                            format!("{}, {}", protocol.task.name(), ui::parameter::method(adaptive.method.name()))
                        }
                        None if protocol.task.is_default() => {
                            format!("rating, {} categories", protocol.response.categories.len())
                        }
                        None => protocol.task.name().to_owned(),
                    };
                    let mut parts = vec![
                        file.clone(),
                        task,
                        if conditions == 1 { "1 condition".to_owned() } else { format!("{conditions} conditions") },
                        ui::extent(protocol),
                    ];
                    if sessions > 1 {
                        parts.push(format!("{sessions} sessions"));
                    }
                    ui::hint(ui, parts.join(" · "));
                }
            });
        });
        next
    }

    /// Draws what can be done with the study.
    pub(super) fn actions(
        &mut self,
        ui: &mut Ui,
        checked: &Checked,
        protocol: &Protocol,
        monitor: &Monitor,
        settings: &Settings,
    ) -> Option<Destination> {
        let mut next = None;
        let folder = self.folder();
        let unfinished = self.sessions.of(&protocol.name).find(|session| !session.complete).cloned();
        let is_wide = ui.available_width() >= ROOM_FOR_ALL;
        ui.horizontal(|ui| {
            let hover = format!("For {}, the next participant.", self.suggested);
            if main_action(ui, Icon::Play, "New session").on_hover_text(hover).clicked() {
                self.open_session(None);
            }
            ui.add_enabled_ui(unfinished.is_some(), |ui| {
                let title = unfinished.as_ref().map(|session| format!("Resume {}", Cell::of(session).title()));
                let title = title.as_deref().unwrap_or("Resume");
                let resume = action(ui, Icon::Resume, "Resume").on_hover_text(title);
                ui::text::name(ui, &resume, title);
                if let Some(session) = unfinished.filter(|_| resume.clicked()) {
                    next = self.resume(ui, &session, monitor, checked, settings);
                }
            });
            let mut rest = |ui: &mut Ui| next = self.rest(ui, protocol, &folder).or(next.take());
            if is_wide {
                rest(ui);
            } else {
                Popup::menu(&quiet(ui, Icon::More, "", "More actions")).show(rest);
            }
        });
        // The room for the progress is there before and after.
        ui.allocate_ui(egui::vec2(ui.available_width(), theme::MESSAGE), |ui| {
            ui.set_min_height(theme::MESSAGE);
            if let Some(job) = &self.job {
                job.show(ui);
            }
        });
        next
    }

    /// Draws what can be done besides beginning and resuming sessions.
    fn rest(&mut self, ui: &mut Ui, protocol: &Protocol, folder: &Path) -> Option<Destination> {
        // The result of a job that another one replaced would be lost.
        let is_free = self.job.is_none();
        let has_sessions = self.sessions.of(&protocol.name).next().is_some();
        let mut next = None;
        ui.add_enabled_ui(is_free, |ui| {
            if action(ui, Icon::Pilot, "Simulate a pilot…").clicked() {
                self.open = Some(Open::Pilot(PilotForm::new(protocol)));
            }
        });
        ui.add_enabled_ui(has_sessions && is_free, |ui| {
            if quiet(ui, Icon::Check, "Check", "Check").clicked() {
                self.job = Some(Job::check(ui.ctx(), folder.to_owned()));
            }
        });
        ui.add_enabled_ui(has_sessions, |ui| {
            if quiet(ui, Icon::Analyze, "Analyze", "Analyze this study").clicked() {
                next = Some(Destination::Analysis(folder.to_owned()));
            }
        });
        ui.add_enabled_ui(has_sessions && is_free, |ui| {
            if quiet(ui, Icon::Out, "Export…", "Export…").clicked() {
                self.open = Some(Open::Export(ExportForm::new(folder)));
            }
        });
        next
    }

    /// Opens the dialog of a session; `None` for the next participant.
    pub(super) fn open_session(&mut self, cell: Option<&Cell>) {
        match cell {
            Some(cell) => {
                self.form.participant.clone_from(&cell.subject);
                self.form.session.clone_from(&cell.session);
            }
            None => {
                self.form.participant.clone_from(&self.suggested);
                "1".clone_into(&mut self.form.session);
            }
        }
        self.error = None;
        self.open = Some(Open::Session);
    }

    /// Returns the session of a cell, if it was begun.
    pub(super) fn recorded(&self, cell: &Cell) -> Option<SessionState> {
        let name = self.checked()?.protocol.as_ref()?.name.clone();
        self.sessions.of(&name).find(|session| Cell::of(session) == *cell).cloned()
    }

    /// Resumes, begins or opens the session of a cell.
    pub(super) fn enter(
        &mut self,
        ui: &Ui,
        cell: &Cell,
        checked: &Checked,
        monitor: &Monitor,
        settings: &Settings,
    ) -> Option<Destination> {
        match self.recorded(cell) {
            None if self.form.participant == cell.subject && self.form.session == cell.session => {
                let begun = self.begin_checked(ui, checked, monitor, settings);
                self.open = begun.is_none().then_some(Open::Session);
                return begun;
            }
            None => self.open_session(Some(cell)),
            Some(session) if session.complete => open_file(ui, &session),
            Some(session) => return self.resume(ui, &session, monitor, checked, settings),
        }
        None
    }
}

/// Opens the data file of a session with the desktop's program for tables.
pub(super) fn open_file(ui: &Ui, session: &SessionState) {
    if let Some(error) = ui::open(&session.csv) {
        ui::complain(ui.ctx(), error);
    }
}
