//! The preflight: describes the actual screen in plain sentences before the session.

use std::time::Duration;

use eframe::egui::{self, Key, RichText, ViewportCommand};

use super::{
    findings::{self, Question},
    participant::ParticipantPage,
    request::{Prepared, Request},
    trials::Trials,
};
use crate::{
    app::ui::{self, Monitor, Step, fonts::TextFonts, platform::Platform, theme, window_px},
    display::frames::FrameTimes,
    experiment::Answers,
    store::{
        dataset::SessionPaths,
        sidecar::{PreflightNote, Sidecar, Sitting},
    },
};

/// Duration of the frame measurement after the window has settled, seconds.
const MEASURE_S: f64 = 1.0;
/// Minimum number of measured frames.
const MEASURE_FRAMES: usize = 30;
/// Share of the window's height above the page.
const TOP: f32 = 0.02;
/// Longest wait for the window to become full screen, seconds.
const SETTLE_S: f64 = 0.7;

pub struct Preflight {
    request: Request,
    /// The previous sitting, if the session is resumed.
    before: Option<Sitting>,
    since: Option<f64>,
    frames: FrameTimes,
    /// The system's report about the screen and the remaining questions, once the window has settled.
    platform: Option<(Platform, Vec<Question>)>,
    /// The fonts for the participant's texts.
    fonts: TextFonts,
    /// The finding about the change in light between field and stimulus.
    light_steps: PreflightNote,
    /// The page that asks about the participant, if the definition has questions that are not answered yet. A resumed
    /// session asks only what it did not record.
    participant: Option<ParticipantPage>,
    /// What the preflight found, once the user has continued from it.
    ready: Option<(Prepared, Vec<PreflightNote>)>,
    /// Why the session could not begin, if it could not.
    refused: Option<String>,
}

impl Preflight {
    /// Starts the preflight of a session while the window becomes full screen.
    pub fn new(request: Request) -> Self {
        let light_steps = findings::light_steps(&request.protocol);
        let Request { protocol, results, identity, resume, .. } = &request;
        let paths = SessionPaths::new(results, protocol, identity);
        // A sidecar that cannot be read is reported when the session begins.
        let recorded = if *resume { Sidecar::read(&paths.sidecar).ok().flatten() } else { None };
        let is_answered = recorded.as_ref().is_some_and(|recorded| recorded.participant.is_some());
        let before = recorded.and_then(|mut recorded| recorded.sittings.pop());
        let asks = !protocol.participant.is_empty() && !is_answered;
        let participant = asks.then(|| ParticipantPage::new(&protocol.participant, &protocol.instructions));
        Self {
            request,
            before,
            since: None,
            frames: FrameTimes::default(),
            platform: None,
            fonts: TextFonts::default(),
            light_steps,
            participant,
            ready: None,
            refused: None,
        }
    }

    pub fn show(&mut self, ui: &mut egui::Ui, monitor: &Monitor) -> Step<Box<Trials>> {
        if let (Some(page), true) = (&mut self.participant, self.ready.is_some()) {
            match page.show(ui, self.refused.as_deref()) {
                Step::Stay => {}
                Step::Back => self.ready = None,
                Step::Next(answers) => return self.begin(ui.ctx(), monitor, Some(answers)),
            }
            return Step::Stay;
        }
        let now = ui.input(|input| input.time);
        let elapsed = now - *self.since.get_or_insert(now);
        let texts = self.request.protocol.participant_texts().map(|(_, text)| text);
        let missing = self.fonts.find(ui.ctx(), texts).map(|missing| findings::fonts(&missing));
        if missing.is_none()
            || elapsed < SETTLE_S + MEASURE_S
            || (self.frames.intervals_us().len() < MEASURE_FRAMES && elapsed < SETTLE_S + 5.0 * MEASURE_S)
        {
            if elapsed > SETTLE_S {
                self.frames.frame(Duration::try_from_secs_f64(now).unwrap_or_default(), None);
            }
            ui.ctx().request_repaint();
            ui::page_from(ui, TOP, |ui| {
                ui.heading("Before the session");
                ui.label("Measuring the screen…");
                ui.spinner();
            });
            return if ui::escaped(ui) { self.back(ui.ctx()) } else { Step::Stay };
        }
        let missing = missing.flatten();
        let (platform, mut questions) =
            self.platform.take().unwrap_or_else(|| (Platform::of(monitor), findings::questions(&self.request.display)));
        let window = window_px(ui.ctx());
        let scale = f64::from(ui.ctx().pixels_per_point());
        let (mut notes, prepared) =
            findings::all(&self.request, self.before.as_ref(), monitor, &platform, &self.frames, window, scale);
        notes.push(self.light_steps.clone());
        let prepared = missing.as_ref().map_or(prepared, |missing| Err(missing.sentence.clone()));
        notes.extend(missing);
        let blocked = prepared.as_ref().err().or(self.refused.as_ref());
        let (begin, back) = self.draw(ui, &notes, &mut questions, prepared.is_ok(), blocked);
        notes.extend(questions.iter().map(findings::answer));
        self.platform = Some((platform, questions));
        if back {
            return self.back(ui.ctx());
        }
        let Some(prepared) = prepared.ok().filter(|_| begin) else { return Step::Stay };
        (self.refused, self.ready) = (None, Some((prepared, notes)));
        if self.participant.is_some() {
            ui.ctx().request_repaint();
            return Step::Stay;
        }
        self.begin(ui.ctx(), monitor, None)
    }

    /// Begins the session; stays on the page and says why if that is not possible.
    fn begin(&mut self, ctx: &egui::Context, monitor: &Monitor, answers: Option<Answers>) -> Step<Box<Trials>> {
        let Some((prepared, notes)) = &self.ready else { return Step::Stay };
        match Trials::begin(ctx, &self.request, prepared, notes.clone(), monitor, answers) {
            Ok(trials) => Step::Next(Box::new(trials)),
            Err(error) => {
                self.refused = Some(error.to_string());
                Step::Stay
            }
        }
    }

    fn back(&self, ctx: &egui::Context) -> Step<Box<Trials>> {
        if !self.request.windowed {
            ctx.send_viewport_cmd(ViewportCommand::Fullscreen(false));
        }
        Step::Back
    }

    /// Draws the findings; returns whether the session begins, and whether the user leaves the page. `blocked` says why it
    /// cannot begin, or could not.
    fn draw(
        &self,
        ui: &mut egui::Ui,
        notes: &[PreflightNote],
        questions: &mut [Question],
        ready: bool,
        blocked: Option<&String>,
    ) -> (bool, bool) {
        let escaped = ui::escaped(ui);
        let proceed = ui::shortcut(ui, Key::Space) || ui::shortcut(ui, Key::Enter);
        let Request { protocol, identity, .. } = &self.request;
        let (begin, back) = ui::footer(ui, |ui| {
            if let Some(blocked) = blocked {
                ui::show_error(ui, blocked);
            }
            // In one line, so that a low window shows more of what is to be read.
            let buttons = ui.horizontal_wrapped(|ui| {
                let begin =
                    ui::neutral_primary(ui, "Continue", ready, "Space. These findings are saved with the data.");
                (begin, ui::keyed(ui, "Back", "Esc"))
            });
            buttons.inner
        });
        ui::page_from(ui, TOP, |ui| {
            ui.heading("Before the session");
            let (subject, session) = (identity.subject(), identity.session());
            ui::hint(ui, format!("{} · participant {subject} · session {session}", protocol.title));
            ui.add_space(8.0);
            theme::compact(ui);
            for note in notes {
                ui.horizontal(|ui| {
                    ui::tick(ui, note.ok);
                    ui::paragraph(ui, &note.sentence);
                });
            }
            ui.add_space(8.0);
            ui.label(RichText::new("Please check these yourself").strong());
            ui::hint(ui, "The program cannot detect these. Items that you do not check are recorded as not confirmed.");
            for (_, statement, confirmed) in questions {
                ui.checkbox(confirmed, *statement);
            }
        });
        (begin || proceed, back || escaped)
    }
}
