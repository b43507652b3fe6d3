//! The page *Studies*: a list of experiments, and the place of the chosen one, which has its sessions and what can be done
//! with them.

use std::{
    collections::BTreeSet,
    path::{Path, PathBuf},
    rc::Rc,
};

use eframe::egui::{
    self, Align, CentralPanel, Frame, Key, Layout, Panel, Popup, RichText, ScrollArea, TextureHandle, Ui,
};

use super::{
    form::{Checked, SessionField, SessionForm},
    grid::{self, Cell, Chosen, Grid, Sessions},
    jobs::{Checked as FilesChecked, Job, Made},
    list::StudyList,
    pilot::{ExportForm, PilotForm},
};
use crate::{
    app::{
        display::CardHelper,
        editor::Thumbnails,
        session::Request,
        ui::{
            self, Dialog, Field, FileKind, Monitor, Place, ScreenFields, Step, action, main_action, pixels, quiet,
            theme::{self, GAP, Icon, KEY, LARGE_GAP, MARGIN, NARROW, SECTION, WIDE, ink},
        },
    },
    experiment::Protocol,
    light::{Bits, Quantizer, Transfer},
    report::document::numbers::count,
    stimulus::{MachBand, Stimulus},
    store::{
        definition::BUILT_IN,
        session::overview::SessionState,
        settings::{Settings, remember},
    },
};

/// Width of the list of studies, and of the column of cards, points: in a wide window, and in a narrower one.
const LIST: [f32; 2] = [288.0, 240.0];
const CARDS: [f32; 2] = [336.0, 272.0];
/// In a page narrower than this, in points, there is no column of cards.
const ROOM_FOR_CARDS: f32 = 760.0;
/// In a page narrower than this, in points, what is rarely needed is in a menu.
const ROOM_FOR_ACTIONS: f32 = 560.0;
/// Side of the example image, physical pixels.
const PICTURE_PX: u32 = 88;

/// Where the page leads.
pub enum Destination {
    Session(Box<Request>),
    /// The editor, with the name or path of the definition; with how many sessions were recorded if the definition itself
    /// is edited, and not a copy.
    Editor(String, Option<usize>),
    /// The analysis of a data set.
    Analysis(PathBuf),
    Place(Place),
}

/// A dialog of the page.
enum Open {
    Session,
    /// Asks for the path of a definition.
    Definition(String),
    Pilot(PilotForm),
    Export(ExportForm),
    /// Asks whether to remove a session in which nothing was rated.
    Removal(Box<SessionState>),
}

#[derive(Default)]
pub struct Studies {
    pub(super) form: SessionForm,
    /// The form and the monitor that were checked last, and the result. Updated if either has changed.
    checked: Option<(SessionForm, Monitor, Rc<Checked>)>,
    /// The participant that the program suggested.
    suggested: String,
    /// The distance that the definition plans, as text.
    planned_cm: String,
    /// The screen width that the program filled in, and its source.
    pub(super) width_origin: Option<(String, &'static str)>,
    pub(super) card: Option<CardHelper>,
    experiment: Dialog,
    pub(super) profile: Dialog,
    pub(super) results: Dialog,
    picture: Option<TextureHandle>,
    pub(super) monitor_choice: Option<usize>,
    list: StudyList,
    sessions: Sessions,
    selected: Option<Cell>,
    thumbnails: Thumbnails,
    open: Option<Open>,
    job: Option<Job>,
    /// What the last check found, and in which data set.
    found: Option<(PathBuf, FilesChecked)>,
    /// Why the last session that was chosen could not be resumed.
    pub(super) error: Option<String>,
    started: bool,
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

    /// Returns the results folder.
    pub fn results(&self) -> PathBuf {
        self.form.results()
    }

    /// Returns the folder of the chosen study.
    pub fn folder(&self) -> PathBuf {
        let name = self.checked().and_then(|checked| checked.protocol.as_ref()).map(|protocol| &protocol.name);
        name.map_or_else(|| self.results(), |name| self.results().join(name))
    }

    /// Updates the page when the user returns to it. After a session that is complete, or in which nothing was rated,
    /// the next participant is entered; after an interrupted one, the fields stay.
    pub fn refresh(&mut self, completed: bool, settings: &Settings) {
        if completed {
            self.form.participant.clear();
        }
        self.checked = None;
        self.sessions.refresh();
        self.list.read(&settings.recent.experiments);
    }

    pub(super) fn close(&mut self) {
        self.open = None;
        self.error = None;
    }

    /// Draws the page. `settings` are the remembered values of its fields, which it updates.
    pub fn show(
        &mut self,
        ui: &mut Ui,
        here: &Monitor,
        monitors: &[Monitor],
        settings: &mut Settings,
    ) -> Step<Destination> {
        // The form is for the monitor that the session will use, which may not be the monitor that shows this window.
        let chosen = self.monitor_choice.filter(|_| settings.full_screen).and_then(|index| monitors.get(index));
        let monitor = chosen.unwrap_or(here);
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
        self.list.update(&settings.recent.experiments);
        let results = self.results();
        self.sessions.update(ui, &results);
        let mut next = self.take_made(ui.ctx());
        let wide = usize::from(ui.ctx().content_rect().width() < WIDE);
        if ui.ctx().content_rect().width() >= NARROW {
            let frame = Frame::NONE.inner_margin(egui::Margin::symmetric(12, LARGE_GAP as i8));
            let panel = Panel::left("studies").resizable(false).exact_size(LIST[wide]).frame(frame);
            panel.show(ui, |ui| self.studies(ui));
        }
        let page = CentralPanel::default().frame(Frame::NONE.inner_margin(MARGIN));
        page.show(ui, |ui| {
            ui.set_max_width(ui.available_width().min(theme::CONTENT));
            if settings.greeting && ui.available_height() > 520.0 {
                next = self.greeting(ui, &mut settings.greeting).or(next.take());
            }
            next = self.place(ui, &checked, CARDS[wide], monitor, settings).or(next.take());
        });
        let dialog = match self.open.take() {
            None => None,
            Some(Open::Session) => {
                self.open = Some(Open::Session);
                self.session_dialog(ui, &checked, [monitor, here], monitors, settings)
            }
            Some(open) => {
                self.other_dialog(ui.ctx(), open, &checked);
                None
            }
        };
        self.measure_with_card(ui.ctx(), here);
        dialog.or(next).map_or(Step::Stay, Step::Next)
    }

    /// Fills the form with the remembered values.
    fn recall(&mut self, settings: &Settings, monitor: &Monitor) {
        let screen = &settings.screen;
        // A relative path would lead to other sessions when the program starts in another folder.
        self.form.results = ui::full(Path::new(settings.results.trim())).display().to_string();
        if !settings.study.is_empty() {
            self.form.experiment.clone_from(&settings.study);
        }
        self.form.screen.profile.clone_from(&screen.profile);
        self.form.screen.distance_cm.clone_from(&screen.distance_cm);
        if screen.monitor == monitor.title() && !screen.width_cm.is_empty() {
            self.form.screen.screen_width_cm.clone_from(&screen.width_cm);
            self.width_origin = Some((screen.width_cm.clone(), "Remembered for this screen"));
        }
        self.suggest(monitor);
    }

    /// Updates the remembered values. What the program suggests is not remembered.
    fn remember(&self, settings: &mut Settings, monitor: &Monitor, checked: &Checked) {
        let SessionForm { screen, results, experiment, .. } = &self.form;
        let absolute = |text: &str| {
            std::path::absolute(text.trim()).map_or_else(|_| text.to_owned(), |path| path.display().to_string())
        };
        if !checked.is_wrong(SessionField::Results) {
            settings.results = absolute(results);
        }
        if !checked.is_wrong(SessionField::Profile) {
            settings.screen.profile =
                if screen.profile.trim().is_empty() { String::new() } else { absolute(&screen.profile) };
        }
        if !checked.is_wrong(SessionField::ScreenWidth) && !screen.width_is_assumed(monitor) {
            settings.screen.monitor = monitor.title();
            settings.screen.width_cm.clone_from(&screen.screen_width_cm);
        }
        if !checked.is_wrong(SessionField::Distance) {
            let is_planned = screen.distance_cm == self.planned_cm;
            settings.screen.distance_cm = if is_planned { String::new() } else { screen.distance_cm.clone() };
        }
        let is_file = !BUILT_IN.iter().any(|built_in| built_in.name == experiment.trim());
        let path = absolute(experiment);
        if checked.protocol.is_some() {
            settings.study = if is_file { path.clone() } else { experiment.trim().to_owned() };
        }
        // The order of the cards stays while the user chooses among them.
        if is_file && checked.protocol.is_some() && !settings.recent.experiments.contains(&path) {
            remember(&mut settings.recent.experiments, &path);
        }
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
        self.form.experiment = name_or_path;
        // The choice of gray belongs to the definition.
        self.form.gray = false;
        if self.form.screen.distance_cm == self.planned_cm {
            self.form.screen.distance_cm.clear();
        }
    }

    /// Fills empty fields, and replaces a participant that the program suggested for other results.
    fn suggest(&mut self, monitor: &Monitor) {
        if self.form.participant == self.suggested {
            self.form.participant.clear();
        }
        let typed = self.form.participant.clone();
        self.form.suggest(monitor);
        if typed.is_empty() {
            self.suggested.clone_from(&self.form.participant);
        }
    }

    /// Checks the form if something in it has changed.
    fn check(&mut self, monitor: &Monitor) -> Rc<Checked> {
        if let Some((form, seen, checked)) = &self.checked
            && *form == self.form
            && seen == monitor
        {
            return checked.clone();
        }
        let before = self.checked.as_ref().map(|(form, ..)| form);
        let moved =
            before.is_none_or(|form| form.experiment != self.form.experiment || form.results != self.form.results);
        if moved || self.form.screen.distance_cm.is_empty() {
            self.suggest(monitor);
        }
        let mut checked = self.form.check(monitor);
        let known = checked.display.as_ref().and_then(|display| display.screen_width_cm);
        if let Some(width) = known
            && self.form.screen.width_is_assumed(monitor)
        {
            // A profile that knows the screen's width is better than an assumption.
            self.set_width(width, "From the display profile");
            checked = self.form.check(monitor);
        }
        if let Some(protocol) = &checked.protocol {
            self.planned_cm = protocol.viewing.distance_cm.to_string();
        }
        let checked = Rc::new(checked);
        self.checked = Some((self.form.clone(), monitor.clone(), checked.clone()));
        checked
    }

    pub(super) fn set_width(&mut self, width_cm: f64, origin: &'static str) {
        self.form.screen.screen_width_cm = width_cm.to_string();
        self.width_origin = Some((width_cm.to_string(), origin));
    }

    /// Shows a newcomer what a Mach band is.
    fn greeting(&mut self, ui: &mut Ui, shown: &mut bool) -> Option<Destination> {
        let mut next = None;
        let frame = theme::card(ui).outer_margin(egui::Margin { bottom: LARGE_GAP as i8, ..Default::default() });
        Panel::top("greeting").resizable(false).show_separator_line(false).frame(frame).show(ui, |ui| {
            ui.horizontal(|ui| {
                let texture = self.picture.get_or_insert_with(|| {
                    let stimulus = Stimulus::MachBand(MachBand::default());
                    let quantizer = Quantizer::new(&Transfer::Srgb, Bits::Eight);
                    pixels::texture(ui.ctx(), "example", &stimulus, PICTURE_PX, &quantizer)
                });
                pixels::picture(ui, texture, "A dark area and a bright area with a linear ramp between them");
                ui.vertical(|ui| {
                    ui.label(RichText::new("Do you see a bright line?").strong().size(SECTION));
                    ui::paragraph(
                        ui,
                        "It is where the ramp meets the bright area, but it is not in the image: it is a Mach band. \
                            In a session, participants rate how visible it is.",
                    );
                    ui.horizontal(|ui| {
                        if ui.button("See more stimuli").clicked() {
                            next = Some(Destination::Place(Place::Stimuli));
                        }
                        if ui.button("Hide").on_hover_text("Does not show this again.").clicked() {
                            *shown = false;
                        }
                    });
                });
            });
        });
        next
    }

    /// Draws the studies to choose from.
    fn studies(&mut self, ui: &mut Ui) {
        ui.horizontal(|ui| {
            ui.add_space(GAP);
            ui.label(RichText::new("Studies").strong().size(SECTION));
            ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                if quiet(ui, Icon::Folder, "", "Open a definition…").clicked() {
                    self.open = Some(Open::Definition(String::new()));
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

    /// Draws the place of the chosen study.
    fn place(
        &mut self,
        ui: &mut Ui,
        checked: &Checked,
        cards: f32,
        monitor: &Monitor,
        settings: &mut Settings,
    ) -> Option<Destination> {
        let mut next = self.title(ui, checked, settings);
        let Some(protocol) = &checked.protocol else {
            ui.add_space(LARGE_GAP);
            let error = checked.error(SessionField::Experiment);
            error.lines().for_each(|line| ui::show_error(ui, line));
            return next;
        };
        ui.add_space(LARGE_GAP);
        next = self.actions(ui, checked, protocol, monitor, settings).or(next);
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
        next = self.detail(ui, checked, monitor, settings).or(next);
        let sessions: Vec<_> = self.sessions.of(&protocol.name).collect();
        let nothing = BTreeSet::new();
        let wrong = self.found.as_ref().filter(|(folder, _)| *folder == self.folder());
        let wrong = wrong.map_or(&nothing, |(_, found)| &found.wrong);
        let new = Cell { subject: self.suggested.clone(), session: "1".to_owned() };
        let chosen = Grid::new(sessions, protocol.plan, new, wrong).show(ui, self.selected.as_ref());
        let results = self.results();
        for error in &self.sessions.all.errors {
            ui::show_error(ui, error.lines().next().unwrap_or_default());
        }
        let is_empty = self.sessions.of(&protocol.name).next().is_none();
        if is_empty && self.sessions.all.errors.is_empty() {
            ui::hint(ui, format!("No sessions yet. They are saved in {}.", results.join(&protocol.name).display()));
        }
        match chosen {
            Some(Chosen::Selected(cell)) => self.selected = Some(cell),
            Some(Chosen::Entered(cell)) => {
                next = self.enter(ui, &cell, checked, monitor, settings).or(next);
                self.selected = Some(cell);
            }
            Some(Chosen::Removed(cell)) => {
                self.open = self.recorded(&cell).filter(|found| found.rated == 0).map(|f| Open::Removal(Box::new(f)));
                self.selected = Some(cell);
            }
            None => {}
        }
        next
    }

    /// Draws the title of the study, its extent, and what is rarely needed.
    fn title(&mut self, ui: &mut Ui, checked: &Checked, settings: &mut Settings) -> Option<Destination> {
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
            if !is_built_in && quiet(ui, Icon::Edit, "Edit", "Edit").clicked() {
                let name = checked.protocol.as_ref().map_or("", |protocol| &protocol.name);
                next = Some(Destination::Editor(experiment.clone(), Some(self.sessions.of(name).count())));
            }
            if ui.ctx().content_rect().width() < NARROW {
                let menu = quiet(ui, Icon::Down, "Studies", "Choose another study");
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
                    let categories = protocol.response.categories.len();
                    let mut parts = vec![
                        file.clone(),
                        format!("rating, {categories} categories"),
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
    fn actions(
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
        let entered = self.open.is_none() && ui::shortcut(ui, Key::Enter);
        ui.horizontal_wrapped(|ui| {
            let hover = format!("Enter begins {} at once.", self.suggested);
            if main_action(ui, Icon::Play, "New session").on_hover_text(hover).clicked() {
                self.open_session(None);
            }
            if entered {
                next = self.begin_checked(ui, checked, monitor, settings);
                self.open = next.is_none().then_some(Open::Session);
            }
            if let Some(session) = unfinished {
                let text = format!("Resume {}", Cell::of(&session).title());
                if action(ui, Icon::Resume, &text).clicked() {
                    next = self.resume(ui, &session, monitor, checked, settings);
                }
            }
            if action(ui, Icon::Pilot, "Simulate a pilot…").clicked() {
                self.open = Some(Open::Pilot(PilotForm::new(protocol.plan.participants)));
            }
            let has_sessions = self.sessions.of(&protocol.name).next().is_some();
            ui.add_enabled_ui(has_sessions, |ui| {
                if quiet(ui, Icon::Check, "Check", "Check").clicked() {
                    self.job = Some(Job::check(ui.ctx(), folder.clone()));
                }
                if quiet(ui, Icon::Analyze, "Analyze", "Analyze this study").clicked() {
                    next = Some(Destination::Analysis(folder.clone()));
                }
                if quiet(ui, Icon::Out, "Export…", "Export…").clicked() {
                    self.open = Some(Open::Export(ExportForm::new(&folder)));
                }
            });
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

    /// Opens the dialog of a session; `None` for the next participant.
    fn open_session(&mut self, cell: Option<&Cell>) {
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
    fn recorded(&self, cell: &Cell) -> Option<SessionState> {
        let name = self.checked()?.protocol.as_ref()?.name.clone();
        self.sessions.of(&name).find(|session| Cell::of(session) == *cell).cloned()
    }

    /// Resumes, begins or opens the session of a cell.
    fn enter(
        &mut self,
        ui: &Ui,
        cell: &Cell,
        checked: &Checked,
        monitor: &Monitor,
        settings: &Settings,
    ) -> Option<Destination> {
        match self.recorded(cell) {
            None => self.open_session(Some(cell)),
            Some(session) if session.complete => open_file(ui, &session),
            Some(session) => return self.resume(ui, &session, monitor, checked, settings),
        }
        None
    }

    /// Draws the card of the selected session at the lower edge.
    fn detail(
        &mut self,
        ui: &mut Ui,
        checked: &Checked,
        monitor: &Monitor,
        settings: &Settings,
    ) -> Option<Destination> {
        let session = self.selected.as_ref().and_then(|cell| self.recorded(cell));
        let mut next = None;
        let panel = Panel::bottom("detail").resizable(false).show_separator_line(false).frame(Frame::NONE);
        panel.show(ui, |ui| {
            grid::key(ui);
            if let Some(error) = &self.error
                && self.open.is_none()
            {
                ui::show_error(ui, error);
            }
            theme::card(ui).show(ui, |ui| {
                ui.set_min_width(ui.available_width());
                ui.set_min_height(theme::CONTROL);
                ui.horizontal_wrapped(|ui| {
                    let Some(session) = &session else {
                        ui::hint(
                            ui,
                            "Choose a session with a click or the arrow keys; Enter resumes, begins or opens it.",
                        );
                        return;
                    };
                    ui.label(RichText::new(Cell::of(session).title()).strong().size(SECTION));
                    let SessionState { rated, planned, complete, .. } = session;
                    let (icon, color) = if *complete { (Icon::Done, ink(ui).text) } else { (Icon::Part, ink(ui).warn) };
                    icon.show(ui, color);
                    let text = format!("{rated} of {planned} trials, last used on {}", session.day());
                    ui.label(RichText::new(text).small().color(color));
                    if !complete && action(ui, Icon::Resume, "Resume").clicked() {
                        next = self.resume(ui, session, monitor, checked, settings);
                    }
                    if ui.button("Open the file").clicked() {
                        open_file(ui, session);
                    }
                    if *rated == 0 && ui.button("Remove…").clicked() {
                        self.open = Some(Open::Removal(Box::new(session.clone())));
                    }
                });
            });
        });
        next
    }

    /// Draws what is planned against what is there, the last check, and the stimuli.
    fn cards(&mut self, ui: &mut Ui, protocol: &Protocol) {
        let people = self.sessions.participants(&protocol.name);
        let finished = self.sessions.of(&protocol.name).filter(|session| session.complete).count();
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
            ui.horizontal(|ui| {
                ui.label(RichText::new(people.to_string()).strong().size(KEY));
                ui.label(RichText::new(whose).weak());
            });
            let begun = self.sessions.of(&protocol.name).count();
            let all = planned.map_or(begun, |planned| (planned * protocol.plan.sessions) as usize);
            if planned.is_some() {
                let share = finished as f32 / all.max(1) as f32;
                let bar = egui::ProgressBar::new(share).desired_height(4.0).fill(ink(ui).dim);
                ui.add(bar);
            }
            ui::hint(ui, format!("{finished} of {all} sessions finished."));
            let simulated = self.sessions.of(&protocol.name).filter(|session| session.simulated).count();
            if simulated > 0 {
                ui::note(ui, format!("{simulated} of these sessions are simulated: a program rated."));
            }
            if planned.is_none() {
                ui::hint(ui, "The definition plans no number of participants; machband plan finds one.");
            }
        });
        let found = self.found.as_ref().filter(|(folder, _)| *folder == self.folder()).map(|(_, found)| found.clone());
        card(ui, &mut |ui| {
            ui.horizontal(|ui| {
                ui.label(RichText::new("Check").strong().size(SECTION));
                let Some(found) = &found else { return };
                ui.with_layout(Layout::right_to_left(Align::Center), |ui| {
                    let (text, color, icon) = match found.errors.len() {
                        0 => ("no errors".to_owned(), ink(ui).good, Icon::Check),
                        1 => ("1 error".to_owned(), ink(ui).bad, Icon::Warn),
                        n => (format!("{n} errors"), ink(ui).bad, Icon::Warn),
                    };
                    ui.label(RichText::new(text).small().color(color));
                    icon.show(ui, color);
                });
            });
            match &found {
                None => ui::hint(ui, "Check renders every picture again and compares every row with the seed."),
                Some(found) if found.errors.is_empty() => {
                    let sessions = count(found.sessions as u64, "session");
                    ui::hint(ui, format!("{sessions}: every row follows from its seed, and no file was changed."));
                }
                Some(found) => {
                    found.errors.iter().take(3).for_each(|error| ui::show_error(ui, error));
                    if found.errors.len() > 3 {
                        ui::hint(ui, format!("and {} more", found.errors.len() - 3));
                    }
                }
            }
        });
        card(ui, &mut |ui| {
            ui.label(RichText::new("Stimuli").strong().size(SECTION));
            self.thumbnails.strip(ui, protocol);
            let levels = |factor: &crate::experiment::Factor| {
                let label = ui::parameter::label(&factor.name);
                let (name, unit) = label.strip_suffix(", °").map_or((label.as_str(), ""), |name| (name, "°"));
                let [first, last] = [factor.levels.first(), factor.levels.last()]
                    .map(|level| level.map(|level| level.to_string().replace("inf", "∞") + unit).unwrap_or_default());
                format!("{name} {first} to {last}")
            };
            let factors: Vec<String> = protocol.factors.iter().map(levels).collect();
            let n = protocol.conditions().len();
            let conditions = if n == 1 { "1 condition".to_owned() } else { format!("{n} conditions") };
            ui::hint(ui, if factors.is_empty() { conditions } else { format!("{conditions}: {}", factors.join(", ")) });
        });
    }

    /// Draws the dialogs other than that of a session.
    fn other_dialog(&mut self, ctx: &egui::Context, open: Open, checked: &Checked) {
        let folder = self.folder();
        if let Open::Definition(path) = open {
            self.open = self.definition_dialog(ctx, path).map(Open::Definition);
            return;
        }
        let Some(protocol) = &checked.protocol else { return };
        self.open = match open {
            Open::Session | Open::Definition(_) => None,
            Open::Pilot(mut form) => match form.show(ctx, &self.form.experiment, &self.results()) {
                Step::Stay => Some(Open::Pilot(form)),
                Step::Back => None,
                Step::Next(request) => {
                    self.job = Some(Job::pilot(ctx, *request, protocol.clone()));
                    None
                }
            },
            Open::Export(mut form) => match form.show(ctx, &folder) {
                Step::Stay => Some(Open::Export(form)),
                Step::Back => None,
                Step::Next(request) => {
                    self.job = Some(Job::export(ctx, request));
                    None
                }
            },
            Open::Removal(session) => {
                let title = Cell::of(&session).title();
                let text = format!("Nothing was rated in {title}, so no rating is lost.");
                match ui::ask(ctx, "Remove the empty session?", &text, ["Keep", "Remove"]) {
                    None => Some(Open::Removal(session)),
                    Some(false) => None,
                    Some(true) => {
                        match session.remove() {
                            Ok(()) => ui::say(ctx, format!("{title} was removed.")),
                            Err(error) => ui::complain(ctx, error.to_string()),
                        }
                        self.checked = None;
                        self.sessions.refresh();
                        None
                    }
                }
            }
        };
    }

    /// Draws the dialog that opens a definition; returns what was typed, unless it is closed.
    fn definition_dialog(&mut self, ctx: &egui::Context, mut path: String) -> Option<String> {
        let entered = ui::entered(ctx);
        let (done, closed) = ui::modal(ctx, "definition", 560.0, |ui, _| {
            ui.heading("Open a definition");
            ui::hint(ui, "A file in the format of docs/definitions.md. It can also be dropped on this window.");
            ui.add_space(GAP);
            let browsed = Field::new("Definition").column(96.0).show(ui, |ui, label| {
                ui.horizontal_wrapped(|ui| {
                    let field = egui::TextEdit::singleline(&mut path).hint_text("path of a .toml file");
                    ui.add(field.desired_width(300.0)).labelled_by(label);
                    self.experiment.browse(ui, FileKind::Toml, "Choose a definition…", &mut path)
                })
                .inner
            });
            self.experiment.missing_error(ui);
            ui.add_space(GAP);
            ui.horizontal(|ui| {
                let ready = !path.trim().is_empty();
                let opened = ui::primary(ui, "Open", ready, "") || ready && (entered || browsed);
                opened.then_some(true).or(ui.button("Cancel").clicked().then_some(false))
            })
            .inner
        });
        if done == Some(true) {
            self.experiment.forget();
            self.choose_experiment(path.trim().to_owned());
        }
        (done.is_none() && !closed).then_some(path)
    }

    /// Takes the result of the job; a simulated study is analyzed.
    fn take_made(&mut self, ctx: &egui::Context) -> Option<Destination> {
        let made = self.job.as_ref()?.poll()?;
        self.job = None;
        match made {
            Err(error) => ui::complain(ctx, error),
            Ok(Made::Checked(found)) => {
                let sessions = count(found.sessions as u64, "session");
                match found.errors.len() as u64 {
                    0 => ui::say(ctx, format!("{sessions} checked; no errors")),
                    n => ui::complain(ctx, format!("{sessions} checked; {}", count(n, "error"))),
                }
                self.found = Some((self.folder(), found));
            }
            Ok(Made::Exported(text)) => ui::say(ctx, text),
            Ok(Made::Pilot(folder)) => {
                ui::say(ctx, format!("Simulated in {}", folder.display()));
                return Some(Destination::Analysis(folder));
            }
        }
        None
    }
}

/// Opens the data file of a session with the desktop's program for tables.
fn open_file(ui: &Ui, session: &SessionState) {
    if let Some(error) = ui::open(&session.csv) {
        ui::complain(ui.ctx(), error);
    }
}
