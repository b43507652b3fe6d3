//! What stands around the grid of a study: its title, what can be done with it, the cards beside it, and the selected session
//! below it.

use std::path::{Path, PathBuf};

use clap::ValueEnum as _;
use eframe::egui::{self, Align, Color32, Frame, Layout, Panel, RichText, Ui};

use super::{
    grid::{self, Cell},
    jobs::{DEVIATIONS, EFFECTS, Job, RequestForm},
    page::{Destination, LIST, Now, Open, Studies},
};
use crate::{
    app::ui::{
        self, action, main_action, menu, quiet,
        theme::{self, Icon, KEY, LARGE_GAP, NARROW, SECTION, ink},
    },
    experiment::{Factor, Protocol},
    report::{document::numbers::count, names},
    stimulus::ParameterValue,
    store::{
        definition::{self, BUILT_IN},
        draft::Draft,
        session::overview::SessionState,
    },
    system::found,
    work::simulate::ObserverKind,
};

/// In a page narrower than this, in points, all but beginning and resuming sessions is in a menu.
const ROOM_FOR_ALL: f32 = 816.0;
/// Number of simulated participants if none is planned.
const PARTICIPANTS: u32 = 8;
/// In a card at least this wide, in points, a session and its buttons need one line.
const ONE_LINE: f32 = 800.0;

impl Studies {
    /// Draws the title of the study, its extent, and what is rarely needed.
    pub(super) fn title(&mut self, ui: &mut Ui, now: &mut Now<'_>) {
        let Now { checked, settings, .. } = now;
        let experiment = self.form.experiment.trim().to_owned();
        let is_built_in = BUILT_IN.iter().any(|built_in| built_in.name == experiment);
        // The buttons are at the right edge, and Tab reaches them from left to right.
        let id = ui.scope_id().with("buttons");
        let width: f32 = ui.data(|data| data.get_temp(id)).unwrap_or_default();
        let needed = ui.horizontal_top(|ui| {
            let room = ui.available_width() - width - ui.spacing().item_spacing.x;
            ui.allocate_ui_with_layout(egui::vec2(room, 0.0), Layout::top_down(Align::Min), |ui| {
                ui.set_width(room);
                let file = Path::new(&experiment).file_name().unwrap_or_default().to_string_lossy().into_owned();
                let title = checked.protocol.as_ref().map_or(file.as_str(), |protocol| &protocol.title);
                ui::paragraph(ui, RichText::new(title).heading().color(ink(ui).ink));
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
                    let sessions = self.sessions.of(&name).count();
                    self.next = Some(Destination::Editor(experiment.clone(), Some(sessions)));
                }
                if quiet(ui, Icon::Plus, word("Duplicate as…"), "Duplicate as…").clicked() {
                    self.next = Some(Destination::Editor(experiment.clone(), None));
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
    }

    /// Draws what can be done with the study.
    pub(super) fn actions(&mut self, ui: &mut Ui, protocol: &Protocol, now: &mut Now<'_>) {
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
                    self.next = self.resume(ui, &session, now);
                }
            });
            if is_wide {
                self.rest(ui, protocol);
            } else {
                menu(&quiet(ui, Icon::More, "", "More actions"), |ui| self.rest(ui, protocol));
            }
        });
        // The room for the progress is there before and after.
        ui.allocate_ui(egui::vec2(ui.available_width(), theme::MESSAGE), |ui| {
            ui.set_min_height(theme::MESSAGE);
            if let Some(job) = &self.job {
                job.show(ui);
            }
        });
    }

    /// Draws what can be done besides beginning and resuming sessions.
    fn rest(&mut self, ui: &mut Ui, protocol: &Protocol) {
        let folder = self.folder();
        // The result of a job that another one replaced would be lost.
        let is_free = self.job.is_none();
        let has_sessions = self.sessions.of(&protocol.name).next().is_some();
        if ui.add_enabled_ui(is_free, |ui| action(ui, Icon::Pilot, "Simulate a pilot…").clicked()).inner {
            self.open = Some(Open::Request(Box::new(self.pilot(protocol))));
        }
        let clicked = |ui: &mut Ui, enabled: bool, icon: Icon, text: &str, name: &str| {
            ui.add_enabled_ui(enabled, |ui| quiet(ui, icon, text, name).clicked()).inner
        };
        if clicked(ui, is_free, Icon::People, "Plan…", "Plan…") {
            self.open = Some(Open::Request(Box::new(self.plan(protocol))));
        }
        if clicked(ui, has_sessions && is_free, Icon::Check, "Check", "Check") {
            self.job = Some(Job::check(ui.ctx(), folder.clone()));
        }
        if clicked(ui, has_sessions, Icon::Analyze, "Analyze", "Analyze this study") {
            self.next = Some(Destination::Analysis(folder.clone()));
        }
        if clicked(ui, has_sessions && is_free, Icon::Out, "Export…", "Export…") {
            self.open = Some(Open::Request(Box::new(export(&folder))));
        }
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
        let observer = ObserverKind::usual(protocol).to_possible_value();
        let observer = observer.map_or_else(String::new, |kind| kind.get_name().to_owned());
        let participants = protocol.plan.participants.unwrap_or(PARTICIPANTS).to_string();
        let about = format!(
            "Simulated observers do every trial, and their answers are analyzed as those of people would be. The files go \
                into the new folder {}.",
            free.display()
        );
        let shown = [("participants", "Participants", participants, ""), ("observer", "Observer", observer, "")];
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
    pub(super) fn enter(&mut self, ui: &Ui, cell: &Cell, now: &mut Now<'_>) {
        match self.recorded(cell) {
            None if self.form.cell == *cell => {
                self.next = self.begin_checked(ui, now);
                self.opening = self.next.is_none();
                self.open = self.opening.then_some(Open::Session);
            }
            None => self.open_session(cell.clone()),
            Some(session) if session.complete => open(ui, &session.csv),
            Some(session) => self.next = self.resume(ui, &session, now),
        }
    }

    /// Draws the card of the selected session at the lower edge.
    pub(super) fn detail(&mut self, ui: &mut Ui, cell: &Cell, now: &mut Now<'_>) {
        let session = self.recorded(cell);
        let panel = Panel::bottom("detail").resizable(false).show_separator_line(false).frame(Frame::NONE);
        panel.show(ui, |ui| {
            for error in self.sessions.errors() {
                ui::show_error(ui, error.lines().next().unwrap_or_default());
            }
            if let Some(error) = &self.error
                && self.open.is_none()
            {
                ui::show_error(ui, error);
            }
            let name = now.checked.protocol.as_ref().map_or("", |protocol| &protocol.name);
            if self.sessions.of(name).next().is_some() {
                grid::key(ui);
            } else if self.sessions.errors().is_empty() {
                ui::hint(ui, format!("No sessions yet. They are saved in {}.", self.folder().display()));
                ui.add_space(theme::SMALL_GAP);
            }
            theme::card(ui).show(ui, |ui| {
                ui.set_min_width(ui.available_width());
                // A session that needs a second line must not move what is above.
                let lines = if ui.available_width() < ONE_LINE { 2.0 } else { 1.0 };
                ui.set_min_height(lines * (theme::CONTROL + theme::SMALL_GAP) - theme::SMALL_GAP);
                ui.horizontal_wrapped(|ui| {
                    ui.label(RichText::new(cell.title()).strong().size(SECTION));
                    let Some(session) = &session else {
                        Icon::Play.show(ui, ink(ui).text);
                        ui::hint(ui, "Not begun.");
                        return;
                    };
                    let (icon, color, told) = grid::told(session, &self.found.1.wrong, ink(ui));
                    icon.show(ui, color);
                    // An unreadable session has no date.
                    let day = session.started_at.get(..10).map(|day| format!(" (last used on {day})"));
                    ui.label(RichText::new(told + &day.unwrap_or_default()).small().color(color));
                    if !session.complete && action(ui, Icon::Resume, "Resume").clicked() {
                        self.next = self.resume(ui, session, now);
                    }
                    if ui.button("Open the file").clicked() {
                        open(ui, &session.csv);
                    }
                    if session.is_empty() && ui.button("Remove…").clicked() {
                        self.open = Some(Open::Removal(Box::new(session.clone())));
                    }
                });
            });
        });
    }

    /// Draws what is planned against what is there, the last check, and the stimuli.
    pub(super) fn cards(&mut self, ui: &mut Ui, protocol: &Protocol) {
        let people = self.sessions.participants(&protocol.name);
        let sessions: Vec<_> = self.sessions.of(&protocol.name).collect();
        let number = |of: &dyn Fn(&SessionState) -> bool| sessions.iter().filter(|session| of(session)).count();
        let card = |ui: &mut Ui, add: &mut dyn FnMut(&mut Ui)| {
            theme::card(ui).show(ui, |ui| {
                ui.set_width(ui.available_width());
                add(ui);
            });
            ui.add_space(LARGE_GAP - ui.spacing().item_spacing.y);
        };
        card(ui, &mut |ui| {
            let planned = protocol.plan.participants;
            let whose = match planned {
                Some(planned) => format!("of {planned} participants planned"),
                None if people == 1 => "participant".to_owned(),
                None => "participants".to_owned(),
            };
            ui.horizontal_wrapped(|ui| {
                ui.label(RichText::new(people.to_string()).strong().size(KEY));
                ui.label(RichText::new(whose).weak());
            });
            let finished = number(&|session| session.complete && !session.is_damaged());
            let all = planned.map_or(sessions.len(), |planned| (planned * protocol.plan.sessions) as usize);
            if planned.is_some() {
                let share = finished as f32 / all.max(1) as f32;
                let fill = if finished > 0 { ink(ui).dim } else { Color32::TRANSPARENT };
                ui.add(egui::ProgressBar::new(share).desired_height(4.0).fill(fill));
            }
            if all > 0 {
                ui::hint(ui, format!("{finished} of {} finished.", count(all as u64, "session")));
            }
            let hash = definition::hash(protocol);
            let simulated = number(&|session| session.simulated);
            let others = number(&|session| session.is_readable && session.definition_sha256 != hash);
            for (n, what, note) in [
                (simulated, "Simulated (a program answered)", ""),
                (others, "Recorded with another definition of this name", " Only one is analyzed at a time."),
            ] {
                if n > 0 {
                    ui::note(ui, format!("{what}: {}.{note}", count(n as u64, "session")));
                }
            }
        });
        let found = Some(&self.found).filter(|(folder, _)| *folder == self.folder()).map(|(_, found)| found);
        card(ui, &mut |ui| {
            ui.horizontal(|ui| {
                ui.label(RichText::new("Check").strong().size(SECTION));
                let Some(found) = found else { return };
                ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                    let (text, color, icon) = match found.errors.len() as u64 {
                        0 => ("no errors".to_owned(), ink(ui).good, Icon::Check),
                        n => (count(n, "error"), ink(ui).bad, Icon::Warn),
                    };
                    ui.label(RichText::new(text).small().color(color));
                    icon.show(ui, color);
                });
            });
            match found {
                None => ui::hint(ui, "Check renders every picture again and compares every row with the seed."),
                Some(found) if found.errors.is_empty() => {
                    let sessions = count(found.files.len() as u64, "session");
                    ui::hint(ui, format!("{sessions}: every row follows from its seed, and no file was changed."));
                }
                Some(found) => {
                    found.errors.iter().take(3).for_each(|error| ui::show_error(ui, error.to_string()));
                    if found.errors.len() > 3 {
                        ui::hint(ui, format!("and {} more", found.errors.len() - 3));
                    }
                }
            }
        });
        card(ui, &mut |ui| {
            ui.label(RichText::new("Stimuli").strong().size(SECTION));
            self.thumbnails.strip(ui, protocol);
            let known = Some(protocol.stimulus.parameters());
            let levels = |factor: &Factor| {
                let level = |level: &ParameterValue| names::level(known, &factor.name, &level.to_string()).to_string();
                let levels = match factor.levels.as_slice() {
                    [first, _, .., last] => format!("{} to {}", level(first), level(last)),
                    few => few.iter().map(level).collect::<Vec<_>>().join(" and "),
                };
                format!("{} {levels}", names::factor(known, &factor.name))
            };
            let factors: Vec<String> = protocol.factors.iter().map(levels).collect();
            let conditions = count(protocol.conditions().len() as u64, "condition");
            ui::hint(ui, if factors.is_empty() { conditions } else { format!("{conditions}: {}", factors.join(", ")) });
        });
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
fn open(ui: &Ui, path: &Path) {
    if let Some(error) = ui::open(path) {
        ui::complain(ui.ctx(), error);
    }
}
