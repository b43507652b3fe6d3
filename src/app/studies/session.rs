//! The dialog that begins a session: who takes part, and on which screen; what its fields remember and suggest.

use std::{path::Path, rc::Rc};

use eframe::egui::{self, ScrollArea, Ui, Vec2, ViewportCommand};

use super::{
    form::{self, Checked, SessionForm},
    grid::Cell,
    page::{Destination, Now, Studies},
};
use crate::{
    app::{
        session::Request,
        ui::{
            self, Field, FileKind, Monitor, ScreenFields,
            theme::{GAP, LARGE_GAP, ink},
        },
    },
    store::{
        dataset::free_participant,
        definition::{BUILT_IN, built_in},
        session::{Changes, SessionStore, overview::SessionState},
        settings::{Settings, remember},
    },
};

/// Width of the dialog, points.
const WIDTH: f32 = 880.0;
/// Width of the plan of the screen, points.
const PLAN: f32 = 184.0;

impl Studies {
    /// Fills the form with the remembered values.
    pub(super) fn recall(&mut self, settings: &Settings, monitor: &Monitor) {
        // A relative path would lead to other sessions when the program starts in another folder.
        self.form.results = ui::full(Path::new(settings.results.trim())).display().to_string();
        let study = if settings.study.is_empty() { BUILT_IN[0].name } else { &settings.study };
        self.choose_experiment(study.to_owned());
        self.form.screen = settings.screen.clone();
        if settings.screen.monitor != monitor.title() {
            self.form.screen.screen_width_cm.clear();
        }
        self.suggest();
    }

    /// Updates the remembered values. What the program suggests is not remembered.
    pub fn remember(&self, settings: &mut Settings, monitor: &Monitor, checked: &Checked) {
        if !self.started {
            return;
        }
        let SessionForm { screen, results, experiment, .. } = &self.form;
        let absolute = |text: &str| ui::full(Path::new(text.trim())).display().to_string();
        settings.results = absolute(results);
        settings.screen =
            ScreenFields { monitor: monitor.title(), profile: absolute(&screen.profile), ..screen.clone() };
        if screen.distance_cm == self.planned_cm {
            settings.screen.distance_cm.clear();
        }
        if checked.protocol.is_none() {
            return;
        }
        let is_file = built_in(Path::new(experiment)).is_none();
        settings.study.clone_from(experiment);
        // The order of the studies stays while the user chooses among them.
        if is_file && !settings.recent.experiments.contains(&settings.study) {
            remember(&mut settings.recent.experiments, &settings.study);
        }
    }

    /// Fills empty fields with values from the definition, and replaces a participant that the program suggested for
    /// other results.
    fn suggest(&mut self) {
        if self.form.cell.subject == self.suggested {
            self.form.cell.subject.clear();
        }
        self.suggested.clear();
        let Ok(protocol) = self.form.protocol() else { return };
        self.planned_cm = protocol.viewing.distance_cm.to_string();
        // If the folder cannot be read, the check says so.
        self.suggested = free_participant(&self.form.results(), &protocol).unwrap_or_default();
        let fields =
            [(&mut self.form.screen.distance_cm, &self.planned_cm), (&mut self.form.cell.subject, &self.suggested)];
        for (field, value) in fields.into_iter().filter(|(field, _)| field.is_empty()) {
            field.clone_from(value);
        }
    }

    /// Checks the form if something in it has changed.
    pub fn check(&mut self, monitor: &Monitor) -> Rc<Checked> {
        if let Some((form, seen, checked)) = &self.checked
            && *form == self.form
            && seen == monitor
        {
            return checked.clone();
        }
        let before = self.checked.as_ref().map(|(form, ..)| form);
        let moved =
            before.is_none_or(|form| form.experiment != self.form.experiment || form.results != self.form.results);
        if moved {
            self.suggest();
        }
        let mut checked = self.form.check(monitor);
        let known = checked.screen.profile.as_ref().ok().and_then(|display| display.screen_width_cm);
        if let Some(width) = known.filter(|_| self.form.screen.width_is_assumed()) {
            // A profile that knows the screen's width is better than an assumption.
            self.form.screen.screen_width_cm = width.to_string();
            checked = self.form.check(monitor);
        }
        let checked = Rc::new(checked);
        self.checked = Some((self.form.clone(), monitor.clone(), checked.clone()));
        checked
    }

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
            let room = height - 168.0;
            ScrollArea::vertical().id_salt("form").max_height(room).auto_shrink([false, true]).show(ui, |ui| {
                let beside = ui.available_width() >= WIDTH - 2.0 * GAP;
                ui.horizontal_top(|ui| {
                    ui.vertical(|ui| {
                        ui.set_width(ui.available_width() - if beside { PLAN + LARGE_GAP } else { 0.0 });
                        self.fields(ui, now);
                    });
                    if let Some(side_px) = checked.screen.stimulus_px.filter(|_| beside) {
                        plan(ui, now.monitor, side_px);
                    }
                });
            });
            self.start(ui, now, entered && !self.screen.measures())
        });
        let (next, cancelled) = next;
        if cancelled || closed && !self.screen.measures() || next.is_some() {
            (self.open, self.error) = (None, None);
        }
        next
    }

    fn fields(&mut self, ui: &mut Ui, now: &mut Now<'_>) {
        let checked = &now.checked;
        ui::text::errors(ui, checked.error(form::EXPERIMENT));
        let SessionForm { cell: Cell { subject, session }, screen, .. } = &mut self.form;
        let first = checked.field(form::PARTICIPANT).slot().hint("letters and digits").text(ui, subject);
        if std::mem::take(&mut self.opening) {
            first.request_focus();
        }
        checked.field(form::SESSION).slot().hint("1, 2, … for the same participant").text(ui, session);
        self.screen.show(ui, form::LABELS, screen, now.monitor, &checked.screen);
        let browse = (FileKind::Folder, "Choose the results folder…");
        let field = checked.field(form::RESULTS).slot();
        let (field, _) = field.path(ui, &mut self.form.results, browse);
        field.on_hover_text(self.form.results.as_str());
        Field::new("Screen").column(form::LABELS).show(ui, |ui, _| {
            ui.horizontal_wrapped(|ui| {
                let title = ui.label(now.monitor.title());
                title.on_hover_text("To use another screen, move this window there.");
                ui.checkbox(&mut now.settings.full_screen, "Full screen");
            });
        });
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
        ui::text::errors(ui, self.error.as_deref().unwrap_or_default());
        let (clicked, cancelled) = ui
            .horizontal_wrapped(|ui| {
                let clicked = ui::primary(ui, text, checked.request.is_some(), "");
                let cancelled = ui.button("Close").clicked();
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
        let again = self.form.check(now.monitor).request;
        if again.is_none_or(|again| again.resume != request.resume || again.protocol != request.protocol) {
            self.refresh(false, now.settings);
            self.error = Some("Another window or program has just changed this study. Check the fields.".to_owned());
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
        let Ok(display) = &now.checked.screen.profile else {
            self.error = Some("The display profile cannot be read. Correct it, then resume the session.".to_owned());
            return None;
        };
        let found = session.to_resume().and_then(|(protocol, distance_cm)| {
            SessionStore::is_finished(&self.form.results(), &protocol, identity, None, Changes::Refuse)?;
            let request = self.form.request(&protocol, identity.clone(), display, true);
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
            ui.ctx().send_viewport_cmd(ViewportCommand::Fullscreen(true));
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
