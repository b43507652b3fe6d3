//! The page *Studies*: a list of experiments, and the place of the chosen one, which has its sessions and what can be done
//! with them.

use std::{
    path::{Path, PathBuf},
    rc::Rc,
};

use eframe::egui::{self, Align, CentralPanel, Frame, Layout, Panel, Rect, RichText, ScrollArea, Ui, UiBuilder};

use super::{
    form::{self, Checked, SessionForm},
    grid::{Action, Cell, Grid, Sessions},
    jobs::{Job, Made, RequestForm},
    list::StudyList,
};
use crate::{
    app::{
        display::ScreenForm,
        editor::Thumbnails,
        session::Request,
        ui::{
            self, Field, FileKind, Monitor, ScreenFields, Step, quiet,
            theme::{self, GAP, Icon, LARGE_GAP, MARGIN, NARROW, SECTION, WIDE},
        },
    },
    report::document::numbers::count,
    store::{
        definition,
        session::overview::SessionState,
        settings::{Settings, remember},
    },
    work::{Found, RequestError},
};

/// Width of the list of studies, and of the column of cards, points: in a wide window, and in a narrower one.
pub(super) const LIST: [f32; 2] = [288.0, 240.0];
const CARDS: [f32; 2] = [336.0, 272.0];
/// In a page narrower than this, in points, there is no column of cards.
const ROOM_FOR_CARDS: f32 = 760.0;
/// Minimum height of the place of a study below its title, points. A page with less room for it scrolls.
const LEAST: f32 = 400.0;

/// Where the page leads.
pub enum Destination {
    Session(Box<Request>),
    /// The editor, with the name or path of the definition; with how many sessions were recorded if the definition itself
    /// is edited, and not a copy.
    Editor(String, Option<usize>),
    /// The analysis of a data set.
    Analysis(PathBuf),
}

/// A dialog of the page.
pub(super) enum Open {
    Session,
    /// Asks for the path of a definition.
    Definition(String),
    /// Asks for the options of a plan, a pilot or an export.
    Request(Box<RequestForm>),
    /// What a plan found, in sentences.
    Planned(Vec<String>),
    /// Asks whether to remove a session in which nothing was rated.
    Removal(Box<SessionState>),
}

/// What a frame of the page is drawn with.
pub(super) struct Now<'a> {
    /// What the check of the form found.
    pub checked: Rc<Checked>,
    /// The monitor that shows this window.
    pub monitor: &'a Monitor,
    /// The remembered values of the fields.
    pub settings: &'a mut Settings,
}

#[derive(Default)]
pub struct Studies {
    pub(super) form: SessionForm,
    /// The form and the monitor that were checked last, and the result. Updated if either has changed.
    pub(super) checked: Option<(SessionForm, Monitor, Rc<Checked>)>,
    /// The participant that the program suggested.
    pub(super) suggested: String,
    /// The distance that the definition plans, as text.
    pub(super) planned_cm: String,
    pub(super) screen: ScreenForm,
    pub(super) list: StudyList,
    pub(super) sessions: Sessions,
    pub(super) selected: Option<Cell>,
    pub(super) thumbnails: Thumbnails,
    pub(super) open: Option<Open>,
    pub(super) job: Option<Job>,
    /// The dialog that started the job.
    asked: Option<Box<RequestForm>>,
    /// What the last check found, and in which folder.
    pub(super) found: (PathBuf, Found),
    /// Why the last session that was chosen could not be resumed.
    pub(super) error: Option<String>,
    pub(super) started: bool,
    /// Where this frame leads.
    pub(super) next: Option<Destination>,
    /// Whether the dialog of a session or of a definition was just opened, so that its first field gets the focus.
    pub(super) opening: bool,
}

impl Studies {
    /// The fields of the screen, which the Display pages share.
    pub fn screen(&mut self) -> &mut ScreenFields {
        &mut self.form.screen
    }

    /// Returns what the last check found.
    pub fn checked(&self) -> Option<&Checked> {
        self.checked.as_ref().map(|(.., checked)| &**checked)
    }

    /// Returns the folder of the chosen study.
    pub fn folder(&self) -> PathBuf {
        let name = self.checked().and_then(|checked| checked.protocol.as_ref()).map(|protocol| &protocol.name);
        name.map_or_else(|| self.form.results(), |name| self.form.results().join(name))
    }

    /// Updates the page when the user returns to it. After a session that is complete, or in which nothing was rated,
    /// the next participant is entered; after an interrupted one, the fields stay.
    pub fn refresh(&mut self, completed: bool, settings: &Settings) {
        if completed {
            (self.form.cell, self.selected) = (Cell::first(""), None);
        }
        (self.checked, self.error) = (None, None);
        self.sessions.refresh();
        self.list.read(&settings.recent.experiments);
    }

    /// Draws the page. `settings` are the remembered values of its fields, which it updates.
    pub fn show(&mut self, ui: &mut Ui, monitor: &Monitor, settings: &mut Settings) -> Step<Destination> {
        if !self.started {
            self.started = true;
            self.recall(settings, monitor);
        }
        let dropped = ui.input(|input| input.raw.dropped_files.first().map(|file| file.path().to_owned()));
        if let Some(path) = dropped {
            self.choose_experiment(path.display().to_string());
        }
        // Another window may have used this one's results.
        if ui.input(|input| input.events.contains(&egui::Event::WindowFocused(true))) {
            self.refresh(false, settings);
        }
        let checked = self.check(monitor);
        self.remember(settings, monitor, &checked);
        self.list.update(ui.ctx(), &settings.recent.experiments);
        let results = self.form.results();
        self.sessions.update(ui, &results);
        self.next = self.take_made(ui.ctx());
        let wide = usize::from(ui.ctx().content_rect().width() < WIDE);
        if ui.ctx().content_rect().width() >= NARROW {
            let frame = Frame::NONE.inner_margin(egui::Margin::symmetric(12, LARGE_GAP as i8));
            let panel = Panel::left("studies").resizable(false).exact_size(LIST[wide]).frame(frame);
            panel.show(ui, |ui| self.studies(ui));
        }
        let height = ui.available_height() - 2.0 * MARGIN;
        let mut now = Now { checked, monitor, settings };
        CentralPanel::default().frame(Frame::NONE.inner_margin(MARGIN)).show(ui, |ui| {
            ScrollArea::vertical().id_salt("page").auto_shrink(false).show(ui, |ui| {
                ui.set_max_width(ui.available_width().min(theme::CONTENT));
                self.title(ui, &mut now);
                let below = height - (ui.cursor().top() - ui.max_rect().top());
                let size = egui::vec2(ui.available_width(), below.max(LEAST));
                let place = UiBuilder::new().max_rect(Rect::from_min_size(ui.cursor().min, size));
                ui.scope_builder(place, |ui| self.place(ui, CARDS[wide], &mut now));
            });
        });
        let next = self.next.take();
        let dialog = self.open.take().and_then(|open| self.dialog(ui, open, &mut now));
        self.screen.measure(ui.ctx(), &mut self.form.screen, monitor);
        dialog.or(next).map_or(Step::Stay, Step::Next)
    }

    /// Chooses a definition that was just saved, and lists it.
    pub fn choose_new(&mut self, path: &Path, settings: &mut Settings) {
        let path = path.display().to_string();
        remember(&mut settings.recent.experiments, &path);
        self.choose_experiment(path);
        self.refresh(false, settings);
    }

    /// Chooses an experiment, by its name or its path. A distance that the user typed stays.
    pub fn choose_experiment(&mut self, name_or_path: String) {
        // A file that is named in two ways would be two studies.
        let chosen = match definition::built_in(Path::new(&name_or_path)) {
            Some(_) => name_or_path,
            None => ui::full(Path::new(&name_or_path)).display().to_string(),
        };
        if chosen != self.form.experiment && self.form.screen.distance_cm == self.planned_cm {
            self.form.screen.distance_cm.clear();
        }
        self.form.experiment = chosen;
        // Who was entered belongs to the definition.
        self.form.cell = Cell::first(&self.suggested);
        (self.selected, self.error) = (None, None);
    }

    /// Draws the studies to choose from.
    pub(super) fn studies(&mut self, ui: &mut Ui) {
        ui.horizontal(|ui| {
            ui.add_space(GAP);
            ui.label(RichText::new("Studies").strong().size(SECTION));
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                if quiet(ui, Icon::Folder, "", "Open a definition…").clicked() {
                    (self.open, self.opening) = (Some(Open::Definition(String::new())), true);
                }
            });
        });
        let Self { list, sessions, form, .. } = self;
        let clicked = list.show(ui, &form.experiment, |experiment| match sessions.participants(experiment) {
            0 => String::new(),
            1 => "1 participant".to_owned(),
            n => format!("{n} participants"),
        });
        if let Some(name) = clicked.filter(|name| *name != self.form.experiment) {
            self.choose_experiment(name);
        }
    }

    /// Draws the place of the chosen study, below its title.
    fn place(&mut self, ui: &mut Ui, cards: f32, now: &mut Now<'_>) {
        let checked = now.checked.clone();
        let Some(protocol) = &checked.protocol else {
            ui.add_space(LARGE_GAP);
            ui::text::errors(ui, checked.error(form::EXPERIMENT));
            return;
        };
        ui.add_space(LARGE_GAP);
        self.actions(ui, protocol, now);
        ui.add_space(LARGE_GAP);
        if ui.available_width() >= ROOM_FOR_CARDS {
            let frame = Frame::NONE.inner_margin(egui::Margin { left: LARGE_GAP as i8, ..Default::default() });
            let panel = Panel::right("cards").resizable(false).show_separator_line(false).exact_size(cards);
            panel.frame(frame).show(ui, |ui| {
                ScrollArea::vertical()
                    .id_salt("cards")
                    .auto_shrink([false, true])
                    .show(ui, |ui| self.cards(ui, protocol));
            });
        }
        let new = Cell::first(&self.suggested);
        let selected = self.selected.clone().unwrap_or_else(|| new.clone());
        self.detail(ui, &selected, now);
        let grid = Grid::new(self.sessions.of(&protocol.name), protocol.plan, new, &self.found.1.wrong);
        let chosen = grid.show(ui, &selected, self.open.is_none());
        if let Some((cell, action)) = chosen {
            match action {
                Action::Select => {}
                Action::Enter => self.enter(ui, &cell, now),
                Action::Remove => {
                    let empty = self.recorded(&cell).filter(SessionState::is_empty);
                    self.open = empty.map(|session| Open::Removal(Box::new(session)));
                }
            }
            self.selected = Some(cell);
        }
    }
}

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
                    (self.job, self.asked) = (Some(job), Some(form));
                    None
                }
            },
            Open::Planned(planned) => {
                let is_open = ui::notice(ctx, "planned", theme::COLUMN, |ui| {
                    ui.heading("Plan");
                    planned.iter().for_each(|sentence| ui::paragraph(ui, sentence));
                });
                is_open.then_some(Open::Planned(planned))
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
            let (field, browsed) = field.path(ui, &mut path, browse);
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
            ui::say(ctx, format!("Opened {}", self.form.experiment));
        }
        (done.is_none() && !closed).then_some(path)
    }

    /// Takes the result of the job; a simulated study is analyzed.
    pub(super) fn take_made(&mut self, ctx: &egui::Context) -> Option<Destination> {
        let job = self.job.as_ref()?;
        let (made, warnings) = (job.poll()?, job.warnings());
        (self.job, self.error) = (None, None);
        let asked = self.asked.take();
        warnings.into_iter().for_each(|warning| ui::complain(ctx, warning));
        match made {
            Err(error) => {
                let (told, request) = (error.to_string(), error.downcast::<RequestError>().ok());
                let mut asked = asked.filter(|_| self.open.is_none());
                // The dialog opens again with what was entered.
                if asked.as_mut().zip(request).is_some_and(|(form, request)| form.refuse(request)) {
                    self.open = asked.map(Open::Request);
                } else {
                    ui::complain(ctx, told);
                }
            }
            Ok(Made::Checked(folder, found)) => {
                let sessions = count(found.files.len() as u64, "session");
                found.errors.iter().rev().for_each(|error| ui::complain(ctx, error.to_string()));
                match found.errors.len() as u64 {
                    0 => ui::say(ctx, format!("{sessions} checked; no errors")),
                    n => ui::complain(ctx, format!("{sessions} checked; {}", count(n, "error"))),
                }
                self.found = (folder, found);
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
