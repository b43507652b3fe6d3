//! The dialog that begins a session: who takes part, and on which screen.

use eframe::egui::{self, Button, ComboBox, ScrollArea, TextEdit, Ui, Vec2, ViewportCommand};

use super::{
    form::{Checked, SessionField, SessionForm, labels},
    grid::Cell,
    page::{Destination, Now, Studies},
};
use crate::{
    app::{
        display::CardHelper,
        session::Request,
        ui::{
            self, Field, FileKind, Monitor, Place, number,
            theme::{GAP, LARGE_GAP, ink},
            today,
        },
    },
    store::{
        session::{Changes, SessionStore, overview::SessionState},
        settings::Settings,
    },
};

/// Width of the dialog, points.
const WIDTH: f32 = 880.0;
/// Width of the plan of the screen, points.
const PLAN: f32 = 184.0;
/// Minimum width of a text field with buttons after it, points.
const MIN_FIELD: f32 = 120.0;
/// Padding of a text field, points.
const PADDING: f32 = 12.0;

impl Studies {
    /// Draws the dialog; returns where it leads.
    pub(super) fn session_dialog(&mut self, ui: &mut Ui, now: &mut Now<'_>) -> Option<Destination> {
        let checked = now.checked.clone();
        let ctx = ui.ctx().clone();
        let entered = ui::entered(&ctx);
        let (next, closed) = ui::modal(&ctx, "session", WIDTH, |ui, height| {
            ui.heading("New session");
            if let Some(protocol) = &checked.protocol {
                ui::hint(ui, format!("{} · {}", protocol.title, ui::extent(protocol)));
            }
            ui.add_space(GAP);
            let mut measure = false;
            let room = height - 168.0;
            ScrollArea::vertical().id_salt("form").max_height(room).auto_shrink([false, true]).show(ui, |ui| {
                let beside = ui.available_width() >= WIDTH - 2.0 * GAP;
                ui.horizontal_top(|ui| {
                    ui.vertical(|ui| {
                        ui.set_width(ui.available_width() - if beside { PLAN + LARGE_GAP } else { 0.0 });
                        measure = self.fields(ui, now);
                    });
                    if let Some((side_px, _)) = checked.stimulus_px.filter(|_| beside) {
                        plan(ui, now.monitor, side_px);
                    }
                });
            });
            let (start, cancel) = self.start(ui, now, entered && self.card.is_none());
            (start.or(measure.then_some(Destination::Place(Place::Display))), cancel)
        });
        let (next, cancelled) = next;
        if cancelled || closed && self.card.is_none() || next.is_some() {
            (self.open, self.error) = (None, None);
        }
        next
    }

    /// Draws the fields; returns whether the user wants to measure the screen.
    fn fields(&mut self, ui: &mut Ui, now: &mut Now<'_>) -> bool {
        let checked = &now.checked;
        if checked.is_wrong(SessionField::Experiment) {
            checked.field(ui, SessionField::Experiment).show(ui, |_, _| ());
        }
        let SessionForm { cell: Cell { subject, session }, screen, .. } = &mut self.form;
        let first = checked.field(ui, SessionField::Participant).slot().hint("letters and digits").text(ui, subject);
        if std::mem::take(&mut self.opening) {
            first.request_focus();
        }
        checked.field(ui, SessionField::Session).slot().hint("1, 2, … for the same participant").text(ui, session);
        checked.field(ui, SessionField::Distance).slot().hint("from eye to screen").text(ui, &mut screen.distance_cm);
        if let Some(coarse) = &checked.coarse {
            Field::new("").column(labels(ui)).show(ui, |ui, _| ui::note(ui, coarse));
        }
        self.width_field(ui, now);
        let measure = self.profile_field(ui, checked);
        checked.field(ui, SessionField::Results).show(ui, |ui, label| {
            ui.horizontal_wrapped(|ui| {
                let results = &mut self.form.results;
                let field = ui.add(TextEdit::singleline(results).desired_width(room(ui, 1))).labelled_by(label);
                field.on_hover_text(results.as_str());
                self.results.browse(ui, FileKind::Folder, "Choose the results folder…", results);
            });
        });
        self.monitor_field(ui, now);
        measure
    }

    fn width_field(&mut self, ui: &mut Ui, now: &Now<'_>) {
        let Now { checked, monitor, here, .. } = now;
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

    fn monitor_field(&mut self, ui: &mut Ui, now: &mut Now<'_>) {
        let Now { monitor, monitors, settings, .. } = now;
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
        };
        let field = Field::new("Screen").column(labels(ui));
        field.show(ui, |ui, label| ui.horizontal_wrapped(|ui| line(ui, label)));
    }

    /// Draws the buttons of the dialog; returns the session to begin, and whether the dialog is closed without one.
    fn start(&mut self, ui: &mut Ui, now: &mut Now<'_>, entered: bool) -> (Option<Destination>, bool) {
        let checked = &now.checked;
        let text = if checked.resume { "Resume" } else { "Start" };
        let hint = match (&checked.request, checked.resume) {
            (None, _) => "Something above needs attention.",
            (Some(_), true) => "Enter resumes this session with its remaining trials.",
            (Some(_), false) => "Enter starts. In the session, Esc pauses; every answer is saved immediately.",
        };
        ui.add_space(GAP);
        ui.separator();
        ui.add_space(GAP);
        if let Some(error) = &self.error {
            error.lines().for_each(|line| ui::show_error(ui, line));
        }
        let (clicked, cancelled) = ui
            .horizontal_wrapped(|ui| {
                let clicked = ui::primary(ui, text, checked.request.is_some(), "");
                let cancelled = ui.button("Cancel").clicked();
                ui::hint(ui, hint);
                (clicked, cancelled)
            })
            .inner;
        let begun = (clicked || entered).then(|| self.begin_checked(ui, now)).flatten();
        (begun, cancelled)
    }

    /// Begins the session of the form, if nothing in it is wrong.
    pub(super) fn begin_checked(&mut self, ui: &Ui, now: &mut Now<'_>) -> Option<Destination> {
        // What was typed in this frame was not checked before the fields were drawn.
        let request = self.check(now.monitor).request.clone()?;
        let again = self.form.check(now.monitor);
        let is_changed = again.request.as_ref().is_some_and(|again| again.protocol != request.protocol);
        if is_changed || again.request.as_ref().is_none_or(|again| again.resume != request.resume) {
            let (subject, session) = (request.identity.subject(), request.identity.session());
            let is_taken =
                (again.resume || again.is_wrong(SessionField::Session)) && !again.is_wrong(SessionField::Results);
            self.refresh(false, now.settings);
            self.error = match (is_changed, is_taken) {
                (true, _) => {
                    Some("Another program changed the definition. Look at the study before it begins.".to_owned())
                }
                (_, true) => {
                    Some(format!("Another window has just begun session {session} of {subject}. Check both fields."))
                }
                _ => None,
            };
            return None;
        }
        self.begin(ui, request, now.settings)
    }

    /// Resumes a session from the list: with the definition and the distance of its last sitting, and the screen of the
    /// form.
    pub(super) fn resume(&mut self, ui: &Ui, session: &SessionState, now: &mut Now<'_>) -> Option<Destination> {
        let identity = &session.identity;
        self.form.cell = Cell::of(identity);
        self.error = None;
        let Some(display) = &now.checked.display else {
            self.error = Some("The display profile cannot be read. Correct it, then resume the session.".to_owned());
            return None;
        };
        let found = session.to_resume().and_then(|(protocol, distance_cm)| {
            SessionStore::is_finished(&self.results(), &protocol, identity, None, Changes::Refuse)?;
            let request = self.form.request(now.monitor, &protocol, identity.clone(), display, true);
            Ok(Request { distance_cm: distance_cm.unwrap_or(request.distance_cm), ..request })
        });
        match found {
            Ok(request) => self.begin(ui, request, now.settings),
            Err(error) => {
                self.error = Some(error.to_string());
                None
            }
        }
    }

    fn begin(&mut self, ui: &Ui, mut request: Request, settings: &Settings) -> Option<Destination> {
        // Nothing else may use the processor while times are measured.
        self.error =
            self.job.as_ref().map(|job| format!("{} is still running. Stop it, or wait until it ends.", job.what));
        if self.error.is_some() {
            return None;
        }
        request.windowed = !settings.full_screen;
        self.selected = Some(Cell::of(&request.identity));
        if settings.full_screen {
            // Choosing a monitor makes the window full screen there.
            ui.ctx().send_viewport_cmd(match self.monitor_choice {
                Some(index) => ViewportCommand::SetMonitor(index),
                None => ViewportCommand::Fullscreen(true),
            });
        }
        Some(Destination::Session(Box::new(request)))
    }
}

/// Draws the screen and the stimulus on it, to scale.
fn plan(ui: &mut Ui, monitor: &Monitor, side_px: u32) {
    ui.vertical(|ui| {
        ui.set_width(PLAN);
        let scale = PLAN / monitor.width_px.max(1) as f32;
        let size = Vec2::new(PLAN, scale * monitor.height_px as f32);
        let (rect, response) = ui.allocate_exact_size(size, egui::Sense::hover());
        let (width, height) = (monitor.width_px, monitor.height_px);
        let caption = format!("To scale: {width} × {height} pixels, and the stimulus, {side_px} pixels wide.");
        ui::describe(&response, &caption);
        let ink = ink(ui);
        ui.painter().rect_filled(rect, 4.0, ink.active);
        let side = Vec2::splat(scale * side_px as f32);
        ui.painter().rect_filled(egui::Rect::from_center_size(rect.center(), side).intersect(rect), 0.0, ink.dim);
        ui::hint(ui, caption);
    });
}

/// Returns the width for a text field that a number of buttons follow, on the same line if there is room.
fn room(ui: &Ui, buttons: usize) -> f32 {
    let Vec2 { x: padding, .. } = ui.spacing().button_padding;
    let button = 76.0 + 2.0 * padding + ui.spacing().item_spacing.x;
    let room = ui.available_width() - buttons as f32 * button - 2.0 * PADDING;
    if room < MIN_FIELD { ui.available_width() - 2.0 * PADDING } else { room }
}
