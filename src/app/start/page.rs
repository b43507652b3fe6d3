//! The start page, on which the user chooses an experiment, a participant and the screen, or a session to resume.

use std::{
    path::{Path, PathBuf},
    rc::Rc,
};

use eframe::egui::{
    self, Button, CentralPanel, ComboBox, Frame, Key, Panel, RichText, ScrollArea, TextEdit, TextureHandle, Ui, Vec2,
    ViewportCommand,
};

use super::{
    cards::Cards,
    form::{Checked, SessionField, SessionForm, labels},
    sessions::SessionList,
};
use crate::{
    app::{
        display::CardHelper,
        session::Request,
        ui::{
            self, Dialog, Field, FileKind, Monitor, Place, ScreenFields, Step, number, pixels,
            theme::{self, GAP, LARGE_GAP},
            today,
        },
    },
    light::{Bits, Quantizer, Transfer},
    stimulus::{MachBand, Stimulus},
    store::{
        definition::BUILT_IN,
        session::{Changes, SessionStore, overview::SessionState},
        settings::{Settings, remember},
    },
};

/// Side of the example image, physical pixels.
const PICTURE_PX: u32 = 88;
/// In a page of less than this size, in points, text is smaller and the example has no image.
const SMALL: Vec2 = egui::vec2(760.0, 560.0);
/// In a page narrower than this, in points, the experiments and sessions are above the form.
const NARROW: f32 = 520.0;
/// Minimum width of a text field with buttons after it, points.
const MIN_FIELD: f32 = 120.0;
/// Padding of a text field, points.
const PADDING: f32 = 6.0;
/// Maximum width of the form, points.
const FORM: f32 = 760.0;
/// Share of the height of the page's left half for experiments; the rest is for sessions.
const CARDS: f32 = 0.6;

/// Where the start page leads.
pub enum Destination {
    Session(Box<Request>),
    /// The editor, with the name or path of the definition to duplicate.
    Editor(String),
    Place(Place),
}

#[derive(Default)]
pub struct Start {
    form: SessionForm,
    /// The form and the monitor that were checked last, and the result. Updated if either has changed.
    checked: Option<(SessionForm, Monitor, Rc<Checked>)>,
    /// The participant that the program suggested.
    suggested: String,
    /// The distance that the definition plans, as text.
    planned_cm: String,
    /// The screen width that the program filled in, and its source.
    width_origin: Option<(String, &'static str)>,
    card: Option<CardHelper>,
    experiment: Dialog,
    profile: Dialog,
    results: Dialog,
    picture: Option<TextureHandle>,
    monitor_choice: Option<usize>,
    cards: Cards,
    sessions: SessionList,
    /// Why the last session that was chosen could not be resumed.
    error: Option<String>,
    started: bool,
}

impl Start {
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

    /// Updates the page when the user returns to it. After a completed session, the next participant is entered. After
    /// an interrupted one, the fields stay.
    pub fn refresh(&mut self, completed: bool, settings: &Settings) {
        if completed {
            self.form.participant.clear();
        }
        self.checked = None;
        self.sessions.refresh();
        self.cards.read(&settings.recent.experiments);
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
        self.cards.update(&settings.recent.experiments);
        let small = ui.available_width() < SMALL.x || ui.available_height() < SMALL.y;
        if small {
            theme::compact(ui);
        }
        let margin = if small { GAP } else { LARGE_GAP };
        let page = CentralPanel::default().frame(Frame::NONE.inner_margin(margin));
        let next = page.show(ui, |ui| {
            let seen = if settings.greeting { self.greeting(ui, small, &mut settings.greeting) } else { None };
            let (panel, size) = if ui.available_width() < NARROW {
                (Panel::top("choices"), 0.4 * ui.available_height())
            } else {
                let width = ui.available_width();
                (Panel::left("choices"), (0.44 * width).max(width - FORM).floor())
            };
            let frame = Frame::NONE.inner_margin(egui::Margin { right: margin as i8, ..Default::default() });
            let panel = panel.resizable(false).exact_size(size).frame(frame).show_separator_line(false);
            let (resume, duplicate) = panel.show(ui, |ui| self.choices(ui, small)).inner;
            let resumed = resume.and_then(|session| self.resume(ui, &session, monitor, &checked, settings));
            let (start, measure) = self.session_form(ui, &checked, [monitor, here], monitors, settings);
            resumed.or(start).or(measure).or(seen).or(duplicate)
        });
        self.measure_with_card(ui.ctx(), here);
        next.inner.map_or(Step::Stay, Step::Next)
    }

    /// Fills the form with the remembered values.
    fn recall(&mut self, settings: &Settings, monitor: &Monitor) {
        let screen = &settings.screen;
        // A relative path would lead to other sessions when the program starts in another folder.
        self.form.results = ui::full(Path::new(settings.results.trim())).display().to_string();
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
        // The order of the cards stays while the user chooses among them.
        if is_file && checked.protocol.is_some() && !settings.recent.experiments.contains(&path) {
            remember(&mut settings.recent.experiments, &path);
        }
    }

    /// Chooses a definition that was just saved, and shows a card for it.
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

    fn set_width(&mut self, width_cm: f64, origin: &'static str) {
        self.form.screen.screen_width_cm = width_cm.to_string();
        self.width_origin = Some((width_cm.to_string(), origin));
    }

    /// Shows a newcomer what a Mach band is.
    fn greeting(&mut self, ui: &mut Ui, small: bool, shown: &mut bool) -> Option<Destination> {
        let mut next = None;
        let frame = theme::card(ui).inner_margin(GAP);
        let frame = frame.outer_margin(egui::Margin { bottom: GAP as i8, ..Default::default() });
        Panel::top("greeting").resizable(false).show_separator_line(false).frame(frame).show(ui, |ui| {
            let buttons = |ui: &mut Ui, next: &mut Option<Destination>, shown: &mut bool| {
                if ui.button("See more stimuli").clicked() {
                    *next = Some(Destination::Place(Place::Stimuli));
                }
                if ui.button("Hide").on_hover_text("Does not show this again.").clicked() {
                    *shown = false;
                }
            };
            if small {
                ui.horizontal(|ui| {
                    ui.label(RichText::new("Do you see a bright line?").strong());
                    buttons(ui, &mut next, shown);
                });
                return;
            }
            ui.horizontal(|ui| {
                let texture = self.picture.get_or_insert_with(|| {
                    let stimulus = Stimulus::MachBand(MachBand::default());
                    let quantizer = Quantizer::new(&Transfer::Srgb, Bits::Eight);
                    pixels::texture(ui.ctx(), "example", &stimulus, PICTURE_PX, &quantizer)
                });
                pixels::picture(ui, texture, "A dark area and a bright area with a linear ramp between them");
                ui.vertical(|ui| {
                    ui.label(RichText::new("Do you see a bright line?").strong().size(18.0));
                    ui::paragraph(
                        ui,
                        "It is where the ramp meets the bright area, but it is not in the image: it is a Mach band. \
                            In a session, participants rate how visible it is.",
                    );
                    ui.horizontal(|ui| buttons(ui, &mut next, shown));
                });
            });
        });
        next
    }

    /// Draws the experiments and the sessions to choose from; returns the session to resume, and the editor if the
    /// chosen definition is to be duplicated.
    fn choices(&mut self, ui: &mut Ui, small: bool) -> (Option<SessionState>, Option<Destination>) {
        let mut name = self.form.experiment.clone();
        let mut duplicate = None;
        ui.horizontal_wrapped(|ui| {
            ui.label(RichText::new("Experiments").strong().size(18.0));
            self.experiment.browse(ui, FileKind::Toml, "Open a definition…", &mut name);
            let button = ui.button("Duplicate as…").on_hover_text("Edits a copy of the chosen definition in a form.");
            duplicate = button.clicked().then(|| Destination::Editor(self.form.experiment.trim().to_owned()));
        });
        self.experiment.missing_error(ui);
        let height = CARDS * ui.available_height();
        let cards = ui.allocate_ui(egui::vec2(ui.available_width(), height), |ui| {
            ui.set_max_height(height);
            self.cards.show(ui, &self.form.experiment, small)
        });
        if let Some(clicked) = cards.inner {
            name = clicked;
        }
        if name != self.form.experiment {
            self.choose_experiment(name);
        }
        ui.add_space(GAP);
        let results = self.results();
        ui.horizontal(|ui| {
            ui.label(RichText::new("Sessions").strong().size(18.0));
            let (all, complete) = self.sessions.counts();
            if all > 0 {
                ui.label(ui::secondary(format!("{complete} of {all} done")));
            }
        });
        (self.sessions.show(ui, &results), duplicate)
    }

    /// Resumes a session from the list: with the definition and the distance of its last sitting, and the screen of the
    /// form.
    fn resume(
        &mut self,
        ui: &Ui,
        session: &SessionState,
        monitor: &Monitor,
        checked: &Checked,
        settings: &Settings,
    ) -> Option<Destination> {
        let identity = &session.identity;
        self.form.participant = identity.subject().to_owned();
        self.form.session = identity.session().to_owned();
        self.error = None;
        let Some(display) = &checked.display else {
            self.error = Some("The display profile cannot be read. Correct it, then resume the session.".to_owned());
            return None;
        };
        let found = session.to_resume().and_then(|(protocol, distance_cm)| {
            SessionStore::is_finished(&self.results(), &protocol, identity, None, Changes::Refuse)?;
            let request = self.form.request(monitor, &protocol, identity.clone(), display, true);
            Ok(Request { distance_cm: distance_cm.unwrap_or(request.distance_cm), ..request })
        });
        match found {
            Ok(request) => Some(self.begin(ui, request, settings)),
            Err(error) => {
                self.error = Some(error.to_string());
                None
            }
        }
    }

    fn session_form(
        &mut self,
        ui: &mut Ui,
        checked: &Checked,
        [monitor, here]: [&Monitor; 2],
        monitors: &[Monitor],
        settings: &mut Settings,
    ) -> (Option<Destination>, Option<Destination>) {
        let frame = theme::card(ui);
        CentralPanel::default()
            .frame(frame)
            .show(ui, |ui| {
                let start = Panel::bottom("start").resizable(false).show_separator_line(false).frame(Frame::NONE);
                let start = start.show(ui, |ui| self.start(ui, checked, monitor, settings)).inner;
                let measure = ScrollArea::vertical().id_salt("form").auto_shrink(false).show(ui, |ui| {
                    match &checked.protocol {
                        Some(protocol) => {
                            ui.add(egui::Label::new(RichText::new(&protocol.title).strong().size(18.0)).wrap());
                            ui::hint(ui, format!("{}.", ui::extent(protocol)));
                        }
                        None => _ = ui.label(RichText::new("Session").strong().size(18.0)),
                    }
                    self.fields(ui, checked, monitor, here, monitors, settings)
                });
                (start, measure.inner)
            })
            .inner
    }

    fn fields(
        &mut self,
        ui: &mut Ui,
        checked: &Checked,
        monitor: &Monitor,
        here: &Monitor,
        monitors: &[Monitor],
        settings: &mut Settings,
    ) -> Option<Destination> {
        let mut name = self.form.experiment.clone();
        // All fields of the form end at the same edge.
        ui.spacing_mut().text_edit_width = f32::INFINITY;
        checked.field(ui, SessionField::Experiment).hint("name, or path to a .toml file").text(ui, &mut name);
        if name != self.form.experiment {
            self.choose_experiment(name);
        }
        let SessionForm { participant, session, screen, .. } = &mut self.form;
        checked.field(ui, SessionField::Participant).hint("letters and digits").text(ui, participant);
        checked.field(ui, SessionField::Session).hint("1, 2, … for the same participant").text(ui, session);
        checked.field(ui, SessionField::Distance).hint("from eye to screen").text(ui, &mut screen.distance_cm);
        if let Some(coarse) = &checked.coarse {
            Field::new("").column(labels(ui)).show(ui, |ui, _| ui::note(ui, coarse));
        }
        self.width_field(ui, checked, monitor, here);
        let measure = self.profile_field(ui, checked);
        checked.field(ui, SessionField::Results).show(ui, |ui, label| {
            let line = ui.horizontal_wrapped(|ui| {
                let field = TextEdit::singleline(&mut self.form.results).desired_width(room(ui, 1)).show(ui);
                let is_clipped = field.galley.size().x > field.response.rect.width();
                egui::Response::clone(&field.response).labelled_by(label);
                self.results.browse(ui, FileKind::Folder, "Choose the results folder…", &mut self.form.results);
                is_clipped
            });
            if line.inner {
                ui::hint(ui, self.form.results.trim());
            }
        });
        self.monitor_field(ui, checked, monitor, monitors, settings);
        measure.then_some(Destination::Place(Place::Display))
    }

    fn width_field(&mut self, ui: &mut Ui, checked: &Checked, monitor: &Monitor, here: &Monitor) {
        checked.field(ui, SessionField::ScreenWidth).show(ui, |ui, label| {
            ui.horizontal_wrapped(|ui| {
                let width = &mut self.form.screen.screen_width_cm;
                ui.add(TextEdit::singleline(width).desired_width(90.0)).labelled_by(label);
                let measure = ui.add_enabled(monitor == here, Button::new("Measure with a card…"));
                if measure.on_disabled_hover_text("First move this window to that screen.").clicked() {
                    let width = number(width).unwrap_or_else(|| monitor.assumed_width_cm());
                    self.card = Some(CardHelper::new(width, monitor.width_px));
                }
            });
            let Some((side, per_degree)) = checked.stimulus_px.filter(|_| !checked.is_wrong(SessionField::ScreenWidth))
            else {
                return;
            };
            let screen = &self.form.screen;
            let origin = match &self.width_origin {
                Some((width, origin)) if *width == screen.screen_width_cm => (*origin).to_owned(),
                _ if screen.width_is_assumed(monitor) => monitor.assumption(),
                _ => "As typed".to_owned(),
            };
            let text = format!("{origin}. {per_degree:.1} pixels per degree; the stimulus is {side} pixels wide.");
            ui::hint(ui, text);
        });
    }

    /// Draws the field for the profile; returns whether the user wants to measure the screen.
    fn profile_field(&mut self, ui: &mut Ui, checked: &Checked) -> bool {
        checked.field(ui, SessionField::Profile).show(ui, |ui, label| {
            let path = &mut self.form.screen.profile;
            let mut measure = false;
            ui.horizontal_wrapped(|ui| {
                let field = TextEdit::singleline(path).desired_width(room(ui, 2)).hint_text("sRGB");
                ui.add(field).labelled_by(label);
                self.profile.browse(ui, FileKind::Toml, "Choose a display profile…", path);
                measure = ui.button("Measure…").on_hover_text("Luminance, size, and timing of the screen.").clicked();
            });
            if let Some(display) = &checked.display {
                ui::hint(ui, display.sentence());
                // If the profile is assumed, its description already says so.
                if let Some(warning) = display.warning(today()).filter(|_| display.measured.is_some()) {
                    ui::note(ui, warning);
                }
            }
            measure
        })
    }

    fn monitor_field(
        &mut self,
        ui: &mut Ui,
        checked: &Checked,
        monitor: &Monitor,
        monitors: &[Monitor],
        settings: &mut Settings,
    ) {
        let has_color = checked.protocol.as_ref().is_some_and(|protocol| protocol.in_gray().is_some());
        let mut line = |ui: &mut Ui, label| {
            if monitors.len() > 1 {
                let list = ComboBox::from_id_salt("monitor").selected_text(monitor.title()).width(260.0).truncate();
                let list = list.show_ui(ui, |ui| {
                    for (i, monitor) in monitors.iter().enumerate() {
                        ui.selectable_value(&mut self.monitor_choice, Some(i), monitor.title());
                    }
                });
                list.response.labelled_by(label);
            } else {
                ui.label(monitor.title());
            }
            ui.checkbox(&mut settings.full_screen, "Full screen");
            if self.form.gray || has_color {
                let gray = ui.checkbox(&mut self.form.gray, "In gray");
                gray.on_hover_text(
                    "For participants with a color vision deficiency. The experiment's name then ends in -gray.",
                );
            }
        };
        let field = Field::new("Screen").column(labels(ui));
        field.show(ui, |ui, label| ui.horizontal_wrapped(|ui| line(ui, label)));
    }

    fn start(&mut self, ui: &mut Ui, checked: &Checked, monitor: &Monitor, settings: &Settings) -> Option<Destination> {
        let text = if checked.resume { "Resume" } else { "Start" };
        let small = ui.available_width() < 380.0;
        let hint = match (&checked.request, checked.resume) {
            (None, _) => "Something above needs attention.",
            (Some(_), _) if small => "Or press Enter.",
            (Some(_), true) => "This session was interrupted. It resumes with the remaining trials.",
            (Some(_), false) => "Or press Enter. Esc pauses at any time; every answer is saved immediately.",
        };
        ui.add_space(GAP);
        for dialog in [&self.profile, &self.results] {
            dialog.missing_error(ui);
        }
        if let Some(error) = &self.error {
            error.lines().for_each(|line| ui::show_error(ui, line));
        }
        let clicked = ui::primary(ui, text, checked.request.is_some(), hint);
        let entered = self.card.is_none() && ui::shortcut(ui, Key::Enter);
        let request = checked.request.clone().filter(|_| clicked || entered)?;
        let now = self.form.check(monitor);
        if now.request.as_ref().is_none_or(|now| now.resume != request.resume) {
            let (subject, session) = (request.identity.subject(), request.identity.session());
            let is_taken = now.resume || now.is_wrong(SessionField::Session);
            self.error = is_taken
                .then(|| format!("Another window has just begun session {session} of {subject}. Check both fields."));
            self.refresh(false, settings);
            return None;
        }
        self.error = None;
        Some(self.begin(ui, request, settings))
    }

    fn begin(&self, ui: &Ui, mut request: Request, settings: &Settings) -> Destination {
        request.windowed = !settings.full_screen;
        if settings.full_screen {
            // Choosing a monitor makes the window full screen there.
            ui.ctx().send_viewport_cmd(match self.monitor_choice {
                Some(index) => ViewportCommand::SetMonitor(index),
                None => ViewportCommand::Fullscreen(true),
            });
        }
        Destination::Session(Box::new(request))
    }

    fn measure_with_card(&mut self, ctx: &egui::Context, monitor: &Monitor) {
        let Some(card) = &mut self.card else { return };
        match card.show(ctx, monitor.width_px) {
            Step::Stay => return,
            Step::Back => {}
            Step::Next(width) => self.set_width(width, "Measured with a card"),
        }
        self.card = None;
    }
}

/// Returns the width for a text field that a number of buttons follow, on the same line if there is room.
fn room(ui: &Ui, buttons: usize) -> f32 {
    let Vec2 { x: padding, .. } = ui.spacing().button_padding;
    let button = 76.0 + 2.0 * padding + ui.spacing().item_spacing.x;
    let room = ui.available_width() - buttons as f32 * button - 2.0 * PADDING;
    if room < MIN_FIELD { ui.available_width() - 2.0 * PADDING } else { room }
}
