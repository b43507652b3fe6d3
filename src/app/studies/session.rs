//! The dialog that begins a session: who takes part, and on which screen; and how sessions begin and are resumed.

use std::{path::Path, rc::Rc};

use eframe::egui::{Ui, ViewportCommand};

use super::{
    form::{self, Checked},
    grid::Cell,
    page::{Destination, Now, Studies},
};
use crate::{
    app::{
        display::CardHelper,
        session::Request,
        ui::{self, Dialog, Field, FileKind, Monitor, Step, today},
    },
    display::DisplayProfile,
    store::{
        dataset::free_participant,
        definition::{self, built_in},
        session::{Changes, SessionStore, overview::SessionState},
        settings::{Settings, remember},
    },
};

/// Width of the dialog, points.
const WIDTH: f32 = 680.0;

impl Studies {
    /// Enters the next free participant, unless another was typed, and the distance that the definition plans.
    fn suggest(&mut self, settings: &mut Settings) {
        let before = std::mem::take(&mut self.suggested);
        if let Ok(protocol) = definition::open(&settings.study) {
            settings.screen.planned_cm = protocol.viewing.distance_cm;
            // If the folder cannot be read, the check says so.
            self.suggested = free_participant(&form::results_of(settings), &protocol).unwrap_or_default();
        }
        if self.cell.subject.is_empty() || self.cell.subject == before {
            self.cell.subject.clone_from(&self.suggested);
        }
    }

    /// Checks the study and the fields if something has changed.
    pub fn check(&mut self, settings: &mut Settings, monitor: &Monitor) -> Rc<Checked> {
        if let Some((before, cell, seen, checked)) = &self.checked
            && *before == *settings
            && *cell == self.cell
            && seen == monitor
        {
            return checked.clone();
        }
        let is_same = |before: &Settings| before.study == settings.study && before.results == settings.results;
        if !self.checked.as_ref().is_some_and(|(before, ..)| is_same(before)) {
            self.suggest(settings);
        }
        let mut checked = Checked::new(settings, &self.cell, monitor);
        let known = checked.display.as_ref().and_then(|display| display.screen_width_cm);
        if let Some(width) = known.filter(|_| settings.screen.width_is_assumed()) {
            // A profile that knows the screen's width is better than an assumption.
            settings.screen.screen_width_cm = width.to_string();
            checked = Checked::new(settings, &self.cell, monitor);
        }
        let Settings { study, recent, .. } = &mut *settings;
        let is_file = built_in(Path::new(&*study)).is_none();
        // The order of the studies stays while the user chooses among them.
        if is_file && checked.protocol.is_some() && !recent.experiments.contains(study) {
            remember(&mut recent.experiments, study);
        }
        let checked = Rc::new(checked);
        self.checked = Some((settings.clone(), self.cell.clone(), monitor.clone(), checked.clone()));
        checked
    }

    /// Draws the dialog; returns where it leads.
    pub(super) fn session_dialog(&mut self, ui: &mut Ui, now: &mut Now<'_>) -> Option<Destination> {
        let checked = now.checked.clone();
        let about = checked.protocol.as_ref();
        let about = about.map(|protocol| format!("{} · {}", protocol.title, ui::extent(protocol)));
        let hint = match (&checked.request, checked.resume) {
            (None, _) => "Something above needs attention.",
            (Some(_), true) => "Enter resumes this session with its remaining trials.",
            (Some(_), false) => "Enter starts. In the session, Esc pauses; every answer is saved immediately.",
        };
        let error = self.error.clone().unwrap_or_default();
        let dialog = Dialog {
            title: "New session",
            about: &about.unwrap_or_default(),
            width: WIDTH,
            error: &error,
            hint,
            action: if checked.resume { "Resume" } else { "Start" },
            close: "Close",
            is_ready: checked.request.is_some(),
        };
        let (step, ()) = dialog.show(&ui.ctx().clone(), |ui| self.fields(ui, now));
        // Keys are meant for the dialog above.
        let step = if self.card.is_some() { Step::Stay } else { step };
        let next = if step == Step::Next(()) { self.begin_checked(ui, now) } else { None };
        if step == Step::Back || next.is_some() {
            (self.open, self.error) = (None, None);
        }
        next
    }

    fn fields(&mut self, ui: &mut Ui, now: &mut Now<'_>) {
        let Now { checked, monitor, settings } = now;
        ui::text::errors(ui, checked.error(form::EXPERIMENT));
        let Cell { subject, session } = &mut self.cell;
        let first = checked.field(form::PARTICIPANT).slot().hint("letters and digits").text(ui, subject);
        if std::mem::take(&mut self.opening) {
            first.request_focus();
        }
        checked.field(form::SESSION).slot().hint("1, 2, … for the same participant").text(ui, session);
        let screen = &mut settings.screen;
        let coarse = checked.coarse.as_deref().unwrap_or_default();
        let planned = format!("{}, as planned", screen.planned_cm);
        let field = checked.field(form::DISTANCE).slot().note(coarse, true);
        field.hint(&planned).text(ui, &mut screen.distance_cm);
        let origin = if screen.width_is_assumed() { monitor.assumption() + ". " } else { String::new() };
        let size = checked.stimulus_px.map_or_else(String::new, |(side, per_degree)| {
            format!("{origin}{per_degree:.1} pixels per degree; the stimulus is {side} pixels wide.")
        });
        checked.field(form::SCREEN_WIDTH).slot().note(&size, false).show(ui, |ui, label| {
            ui.horizontal_wrapped(|ui| CardHelper::field(&mut self.card, ui, label, screen, monitor));
        });
        let browse = (FileKind::Toml, "Choose a display profile…");
        let warning = checked.display.as_ref().and_then(|display| display.warning(today()));
        let mut told = checked.display.as_ref().map_or_else(String::new, DisplayProfile::sentence);
        warning.iter().for_each(|warning| told = format!("{told}. {warning}"));
        let field = checked.field(form::PROFILE).slot().note(&told, warning.is_some()).hint("sRGB");
        field.path(ui, &mut screen.profile, browse);
        let browse = (FileKind::Folder, "Choose the results folder…");
        let (field, _) = checked.field(form::RESULTS).slot().path(ui, &mut settings.results, browse);
        field.on_hover_text(settings.results.as_str());
        Field::new("Screen").column(form::LABELS).show(ui, |ui, _| {
            ui.horizontal_wrapped(|ui| {
                let title = ui.label(monitor.title());
                title.on_hover_text("To use another screen, move this window there.");
                ui.checkbox(&mut settings.full_screen, "Full screen");
            });
        });
    }

    /// Begins the session of the dialog, if nothing in it is wrong.
    fn begin_checked(&mut self, ui: &Ui, now: &mut Now<'_>) -> Option<Destination> {
        // What was typed in this frame was not checked before the fields were drawn.
        let request = self.check(now.settings, now.monitor).request.clone()?;
        let again = Checked::new(now.settings, &self.cell, now.monitor).request;
        if again.is_none_or(|again| again.resume != request.resume || again.protocol != request.protocol) {
            self.refresh(false, now.settings);
            self.error = Some("Another window or program has just changed this study. Check the fields.".to_owned());
            return None;
        }
        self.begin(ui, request)
    }

    /// Resumes a session from the list: with the definition and the distance of its last sitting, and the screen of the
    /// settings.
    pub(super) fn resume(&mut self, ui: &Ui, session: &SessionState, now: &mut Now<'_>) -> Option<Destination> {
        let identity = &session.identity;
        let Some(display) = &now.checked.display else {
            self.error = Some("The display profile cannot be read. Correct it, then resume the session.".to_owned());
            return None;
        };
        let found = session.to_resume().and_then(|(protocol, distance_cm)| {
            SessionStore::is_finished(&now.checked.results, &protocol, identity, None, Changes::Refuse)?;
            let request = form::request(now.settings, &protocol, identity.clone(), display, true);
            Ok(Request { distance_cm: distance_cm.unwrap_or(request.distance_cm), ..request })
        });
        match found {
            Ok(request) => self.begin(ui, request),
            Err(error) => {
                self.error = Some(error.to_string());
                None
            }
        }
    }

    fn begin(&mut self, ui: &Ui, request: Request) -> Option<Destination> {
        // Nothing else may use the processor while times are measured.
        self.error =
            self.job.as_ref().map(|job| format!("{} is still running. Stop it, or wait until it ends.", job.what));
        if self.error.is_some() {
            return None;
        }
        self.selected = Some(Cell::of(&request.identity));
        if !request.windowed {
            ui.ctx().send_viewport_cmd(ViewportCommand::Fullscreen(true));
        }
        Some(Destination::Session(Box::new(request)))
    }
}
