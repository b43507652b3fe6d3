//! The title of a study, and what can be done with it.

use std::path::{Path, PathBuf};

use eframe::egui::{self, Align, Layout, RichText, Ui};

use super::{
    grid::Cell,
    jobs::{DEVIATIONS, EFFECTS, Job},
    page::{Destination, LIST, Now, Open, Studies},
    request_form::RequestForm,
};
use crate::{
    app::ui::{
        self, action, main_action, menu, quiet,
        theme::{self, Icon, NARROW},
    },
    experiment::Protocol,
    report::document::numbers::count,
    store::{
        definition::{self, BUILT_IN},
        draft::Draft,
        session::overview::SessionState,
    },
    system::found,
};

/// In a page narrower than this, in points, all but beginning and resuming sessions is in a menu.
const ROOM_FOR_ALL: f32 = 816.0;
/// Number of simulated participants if none is planned.
const PARTICIPANTS: u32 = 8;

impl Studies {
    /// Draws the title of the study, its extent, and what is rarely needed.
    pub(super) fn title(&mut self, ui: &mut Ui, now: &mut Now<'_>) -> Option<Destination> {
        let Now { checked, settings, .. } = now;
        let experiment = self.form.experiment.trim().to_owned();
        let is_built_in = BUILT_IN.iter().any(|built_in| built_in.name == experiment);
        let mut next = None;
        // The buttons are at the right edge, and Tab reaches them from left to right.
        let id = ui.scope_id().with("buttons");
        let width: f32 = ui.data(|data| data.get_temp(id)).unwrap_or_default();
        let needed = ui.horizontal_top(|ui| {
            let room = ui.available_width() - width - ui.spacing().item_spacing.x;
            ui.allocate_ui_with_layout(egui::vec2(room, 0.0), Layout::top_down(Align::Min), |ui| {
                ui.set_width(room);
                let file = Path::new(&experiment).file_name().unwrap_or_default().to_string_lossy().into_owned();
                let title = checked.protocol.as_ref().map_or(file.as_str(), |protocol| &protocol.title);
                ui::paragraph(ui, RichText::new(title).heading().color(theme::ink(ui).ink));
                if let Some(protocol) = &checked.protocol {
                    ui::hint(ui, facts(file, protocol));
                }
            });
            let buttons = ui.horizontal(|ui| {
                let is_narrow = ui.ctx().content_rect().width() < NARROW;
                let word = |word| if is_narrow { "" } else { word };
                if is_narrow {
                    let button = quiet(ui, Icon::Down, "Studies", "Choose another study");
                    menu(&button, |ui| {
                        ui.set_width(LIST[1]);
                        ui.set_max_height(420.0);
                        self.studies(ui);
                    });
                }
                if !is_built_in && quiet(ui, Icon::Edit, word("Edit"), "Edit").clicked() {
                    // A definition with errors may have sessions, too.
                    let text = definition::text(Path::new(&experiment));
                    let draft = text.and_then(|text| Draft::parse(&experiment, &text));
                    let name = draft.ok().and_then(|draft| draft.get("name")).unwrap_or_default();
                    next = Some(Destination::Editor(experiment.clone(), Some(self.sessions.of(&name).count())));
                }
                if quiet(ui, Icon::Plus, word("Duplicate as…"), "Duplicate as…").clicked() {
                    next = Some(Destination::Editor(experiment.clone(), None));
                }
                let more = quiet(ui, Icon::More, "", "More");
                menu(&more, |ui| {
                    if ui.button("Open the folder").clicked() {
                        open(ui, &self.folder());
                    }
                    if !is_built_in && ui.button("Remove from the list").clicked() {
                        settings.recent.experiments.retain(|other| *other != experiment);
                        self.choose_experiment(BUILT_IN[0].name.to_owned());
                        ui::say(
                            ui.ctx(),
                            format!("{experiment} is no longer listed; the file and its sessions are kept."),
                        );
                    }
                });
            });
            buttons.response.rect.width()
        });
        if needed.inner != width {
            ui.data_mut(|data| data.insert_temp(id, needed.inner));
            ui.ctx().request_discard("the buttons have another width");
        }
        next
    }

    /// Draws what can be done with the study.
    pub(super) fn actions(&mut self, ui: &mut Ui, protocol: &Protocol, now: &mut Now<'_>) -> Option<Destination> {
        let mut next = None;
        let folder = self.folder();
        let unfinished = self.sessions.of(&protocol.name).find(|session| !session.complete).cloned();
        let is_wide = ui.available_width() >= ROOM_FOR_ALL;
        ui.horizontal(|ui| {
            let hover = format!("For {}, the next participant.", self.suggested);
            if main_action(ui, Icon::Play, "New session").on_hover_text(hover).clicked() {
                self.open_session(Cell::first(&self.suggested));
            }
            ui.add_enabled_ui(unfinished.is_some(), |ui| {
                let title =
                    unfinished.as_ref().map(|session| format!("Resume {}", Cell::of(&session.identity).title()));
                let title = title.as_deref().unwrap_or("Resume");
                let resume = action(ui, Icon::Resume, "Resume").on_hover_text(title);
                ui::text::name(ui, &resume, title);
                if let Some(session) = unfinished.filter(|_| resume.clicked()) {
                    next = self.resume(ui, &session, now);
                }
            });
            let mut rest = |ui: &mut Ui| next = self.rest(ui, protocol, &folder).or(next.take());
            if is_wide {
                rest(ui);
            } else {
                menu(&quiet(ui, Icon::More, "", "More actions"), rest);
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
        ui.add_enabled_ui(is_free, |ui| {
            if action(ui, Icon::Pilot, "Simulate a pilot…").clicked() {
                self.open = Some(Open::Request(Box::new(self.pilot(protocol))));
            }
        });
        let clicked = |ui: &mut Ui, enabled: bool, icon: Icon, text: &str, name: &str| {
            ui.add_enabled_ui(enabled, |ui| quiet(ui, icon, text, name).clicked()).inner
        };
        if clicked(ui, is_free, Icon::People, "Plan…", "Plan…") {
            self.open = Some(Open::Request(Box::new(self.plan(protocol))));
        }
        if clicked(ui, has_sessions && is_free, Icon::Check, "Check", "Check") {
            self.job = Some(Job::check(ui.ctx(), folder.to_owned()));
        }
        let analyzes = clicked(ui, has_sessions, Icon::Analyze, "Analyze", "Analyze this study");
        if clicked(ui, has_sessions && is_free, Icon::Out, "Export…", "Export…") {
            self.open = Some(Open::Request(Box::new(export(folder))));
        }
        analyzes.then(|| Destination::Analysis(folder.to_owned()))
    }

    /// Returns the dialog that finds how many participants the study needs.
    fn plan(&self, protocol: &Protocol) -> RequestForm {
        let about =
            "Simulates studies of several sizes, and says how often each finds an effect. Separate numbers by commas.";
        let planned = protocol.plan.participants.map_or_else(|| "8, 16, 24".to_owned(), |planned| planned.to_string());
        let mut shown = vec![
            ("participants", "Numbers of participants", planned, ""),
            ("effects", EFFECTS, String::new(), "FACTOR:LEVEL=SIZE"),
            ("deviations", DEVIATIONS, String::new(), "FACTOR=SD"),
            ("studies", "Simulated studies", "200".to_owned(), ""),
        ];
        shown.push(match protocol.task.is_default() {
            false => ("trials", "Trials", protocol.repetitions().to_string(), ""),
            true => ("target", "Target power", String::new(), ""),
        });
        let given = [("experiment", self.form.experiment.clone())];
        RequestForm::new(["Plan", "Simulate"], about.to_owned(), &shown, &given, Job::plan)
    }

    /// Returns the dialog that simulates a pilot.
    fn pilot(&self, protocol: &Protocol) -> RequestForm {
        // Simulated sessions never lie among those of people.
        let free = free(|number| self.form.results().with_file_name(format!("{}-pilot-{number}", protocol.name)));
        // The findings of the paper are about ratings.
        let observer = if protocol.task.is_default() { "paper" } else { "vision" };
        let participants = protocol.plan.participants.unwrap_or(PARTICIPANTS).to_string();
        let about = format!(
            "Simulated observers do every trial, and their answers are analyzed as those of people would be. The files go \
                into the new folder {}.",
            free.display()
        );
        let shown =
            [("participants", "Participants", participants, ""), ("observer", "Observer", observer.to_owned(), "")];
        let given = [("experiment", self.form.experiment.clone()), ("results", free.display().to_string())];
        let protocol = protocol.clone();
        RequestForm::new(["Simulate a pilot", "Simulate"], about, &shown, &given, move |ctx, request| {
            Job::pilot(ctx, request, protocol.clone())
        })
    }

    /// Opens the dialog of a session.
    fn open_session(&mut self, cell: Cell) {
        self.form.cell = cell;
        self.error = None;
        self.opening = true;
        self.open = Some(Open::Session);
    }

    /// Returns the session of a cell, if it was begun.
    pub(super) fn recorded(&self, cell: &Cell) -> Option<SessionState> {
        let name = self.checked()?.protocol.as_ref()?.name.clone();
        self.sessions.of(&name).find(|session| Cell::of(&session.identity) == *cell).cloned()
    }

    /// Resumes, begins or opens the session of a cell.
    pub(super) fn enter(&mut self, ui: &Ui, cell: &Cell, now: &mut Now<'_>) -> Option<Destination> {
        match self.recorded(cell) {
            None if self.form.cell == *cell => {
                let begun = self.begin_checked(ui, now);
                self.opening = begun.is_none();
                self.open = self.opening.then_some(Open::Session);
                return begun;
            }
            None => self.open_session(cell.clone()),
            Some(session) if session.complete => open(ui, &session.csv),
            Some(session) => return self.resume(ui, &session, now),
        }
        None
    }
}

/// Returns the facts about a study in one line.
fn facts(file: String, protocol: &Protocol) -> String {
    let (conditions, sessions) = (protocol.conditions().len(), protocol.plan.sessions);
    let task = match &protocol.adaptive {
        Some(adaptive) => format!("{}, {}", protocol.task.name(), ui::parameter::method(adaptive.method.name())),
        None if protocol.task.is_default() => format!("rating, {} categories", protocol.response.categories.len()),
        None => protocol.task.name().to_owned(),
    };
    let mut parts = vec![file, task, count(conditions as u64, "condition"), ui::extent(protocol)];
    if sessions > 1 {
        parts.push(format!("{sessions} sessions"));
    }
    parts.join(" · ")
}

/// Returns the first of the numbered folders that does not exist.
fn free(numbered: impl Fn(u32) -> PathBuf) -> PathBuf {
    (1..).map(numbered).find(|folder| !matches!(found(folder), Ok(Some(_)))).unwrap_or_default()
}

/// Returns the dialog that exports the study in a folder.
fn export(folder: &Path) -> RequestForm {
    let name = folder.file_name().unwrap_or_default().display().to_string();
    let beside = folder.parent().and_then(Path::parent).unwrap_or(Path::new(""));
    let out = free(|number| match number {
        1 => beside.join(format!("{name}-export")),
        _ => beside.join(format!("{name}-export-{number}")),
    });
    let shown = [
        ("format", "Format", "psych-ds".to_owned(), ""),
        ("out", "New folder", out.display().to_string(), ""),
        ("complete_only", "Only finished sessions", String::new(), ""),
    ];
    let given = [("folder", folder.display().to_string())];
    RequestForm::new(["Export", "Export"], folder.display().to_string(), &shown, &given, Job::export)
}

/// Opens a file or a folder with the desktop's program for it.
pub(super) fn open(ui: &Ui, path: &Path) {
    if let Some(error) = ui::open(path) {
        ui::complain(ui.ctx(), error);
    }
}
