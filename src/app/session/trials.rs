//! Runs the trials on the screen: converts input to events of the session, and its states to images.

use std::{collections::BTreeSet, time::Duration};

use eframe::egui::{self, CentralPanel, Color32, CursorIcon, Frame, Key, TextureHandle, Vec2, ViewportCommand};

use super::{
    answers::{Feedback, draw_scale, draw_slider, scale_height, write},
    finish::{Finish, SaveChoice, UnsavedAnswerPage},
    instructions::{self, CategoryPictures, INSTRUCTION_PAGES, PauseChoice},
    recording::{Recording, ScreenRefresh},
    request::{Prepared, Request, has_slider, room},
};
use crate::{
    app::{
        ui::{Monitor, Step, own_plot::OwnPlot, pixels, release_focus, theme, window_px},
        window::{Input, MIN_SIZE, PressTime},
    },
    experiment::{
        Answers, Effect, Event, Phase, Session, State,
        task::{Dial, Layout},
    },
    light::{Bits, Quantizer},
    stimulus::Stimulus,
    store::{StoreError, sidecar::PreflightNote},
};

/// Number of textures in memory: the stimuli of the current trial and of the next one.
const TEXTURES_KEPT: usize = 8;
/// How long the cursor stays visible after mouse movement if the scale can be clicked, seconds.
const CURSOR_S: f64 = 2.0;

/// Distance of a mark from the lower edge of the stimulus, points.
const MARK_BELOW: f32 = 28.0;
/// Height above the lower edge of the window that stays free for the scale and the text below a mark, points.
const SCALE_ABOVE: f32 = 116.0;

/// The keys that turn a dial, and by how many steps.
const DIAL_KEYS: [(Key, f64); 4] =
    [(Key::ArrowLeft, -1.0), (Key::ArrowDown, -1.0), (Key::ArrowRight, 1.0), (Key::ArrowUp, 1.0)];

/// A running session.
pub struct Trials {
    session: Session,
    pub recording: Recording,
    /// The window's time at which the session's time was `offset`, seconds.
    window_start_s: f64,
    /// Session time at the start of this sitting.
    offset: Duration,
    quantizer: Quantizer,
    /// Color of the uniform field.
    field: Color32,
    size_px: u32,
    /// Recent stimuli and their images, the latest last.
    textures: Vec<(Stimulus, TextureHandle)>,
    categories: CategoryPictures,
    screen: ScreenRefresh,
    /// The rating clicked in the previous frame, which still showed the stimulus.
    clicked: Option<(u8, PressTime)>,
    scale_shown: bool,
    unsaved_answer: Option<UnsavedAnswerPage>,
    resumed: bool,
    mouse_moved_s: f64,
    feedback: Feedback,
    /// The page of the instructions that is read again during a pause.
    reread: Option<usize>,
    /// The keys held down, by physical position. A held key repeats but must count once. The repeat flag of the window
    /// system is not sufficient, because a key's meaning can change while it is down (Shift, Num Lock).
    held: BTreeSet<Key>,
}

impl Trials {
    /// Creates or opens the files and shows the first page. `answers` is what the participant answered before, if they
    /// were asked.
    pub fn begin(
        ctx: &egui::Context,
        request: &Request,
        prepared: &Prepared,
        notes: Vec<PreflightNote>,
        monitor: &Monitor,
        answers: Option<Answers>,
    ) -> Result<Self, StoreError> {
        let screen = ScreenRefresh::new(monitor, prepared.refresh);
        let (recording, session, offset) = Recording::begin(request, prepared, notes, monitor, &screen, answers)?;
        // On a screen smaller than the minimum window size, part of the stimulus would be cut off unnoticed.
        ctx.send_viewport_cmd(ViewportCommand::MinInnerSize(Vec2::splat(1.0)));
        let quantizer = Quantizer::new(&request.display.transfers, Bits::Eight);
        let protocol = &request.protocol;
        let mut trials = Self {
            session,
            recording,
            window_start_s: ctx.input(|input| input.time),
            offset,
            field: pixels::field(&quantizer, protocol.stimulus.field_light(protocol.recovery.level)),
            quantizer,
            size_px: prepared.geometry.stimulus_px,
            textures: Vec::new(),
            categories: CategoryPictures::default(),
            screen,
            clicked: None,
            scale_shown: false,
            unsaved_answer: None,
            resumed: request.resume,
            mouse_moved_s: f64::NEG_INFINITY,
            feedback: Feedback::default(),
            reread: None,
            held: BTreeSet::new(),
        };
        trials.scale_shown = trials.phase() == Some(Phase::Practice);
        Ok(trials)
    }

    /// Returns whether an answer is only in memory.
    pub fn is_unsaved(&self) -> bool {
        self.session.is_storing()
    }

    /// Draws a frame: handles the input, advances the session, and shows its state.
    pub fn show(&mut self, ui: &mut egui::Ui, monitor: &Monitor, input: &mut Input) -> Step<Box<Finish>> {
        let window_s = ui.input(|input| input.time);
        let now = self.session_time(window_s);
        if self.unsaved_answer.is_some() {
            self.session.interrupt_frames();
            // The session ignores keys now, but keys that are released must not count as held later.
            self.fresh_keys(ui);
            self.show_unsaved_answer(ui, now);
            return Step::Stay;
        }
        let was_main = self.phase() == Some(Phase::Main);
        // The window may have moved to another monitor with another refresh rate.
        if let Some(note) = self.screen.update(monitor) {
            self.session.set_frame_count(self.screen.frames());
            self.recording.store.note(note);
        }
        self.handle_input(ui, now, input);
        if self.is_trial() && self.too_small(ui.ctx()).is_some() {
            self.step(Event::Pause, now);
        }
        self.step(Event::Frame, now);
        if self.phase() == Some(Phase::Main) && !was_main {
            // After practice, only the field and the stimulus are shown, unless the participant requests the scale.
            self.scale_shown = false;
        }
        if self.is_trial() {
            // Draws at every refresh, because timing and the detection of dropped frames depend on it.
            ui.ctx().request_repaint();
        }
        self.prepare(ui.ctx());
        self.draw(ui, now, window_s, input)
    }

    /// Converts the window's time in seconds to session time.
    fn session_time(&self, window_s: f64) -> Duration {
        self.offset + Duration::try_from_secs_f64(window_s - self.window_start_s).unwrap_or_default()
    }

    /// Pauses before the next trial, or repeats the current one after the pause.
    pub fn pause(&mut self, ctx: &egui::Context) {
        let now = self.session_time(ctx.input(|input| input.time));
        self.step(Event::Pause, now);
    }

    /// Returns the phase of the current trial.
    fn phase(&self) -> Option<Phase> {
        self.session.current().map(|trial| self.session.schedule().trials[trial].phase)
    }

    /// Returns the keys pressed since the last frame, in order: the logical and the physical key.
    fn fresh_keys(&mut self, ui: &egui::Ui) -> Vec<(Key, Key)> {
        let mut fresh = Vec::new();
        for event in ui.input(|input| input.events.clone()) {
            match event {
                egui::Event::WindowFocused(false) => self.held.clear(),
                egui::Event::Key { key, physical_key, pressed, modifiers, .. } => {
                    let place = physical_key.unwrap_or(key);
                    if !pressed {
                        self.held.remove(&place);
                    } else if self.held.insert(place) && !(modifiers.ctrl || modifiers.alt || modifiers.command) {
                        fresh.push((key, place));
                    }
                }
                _ => {}
            }
        }
        fresh
    }

    fn handle_input(&mut self, ui: &egui::Ui, now: Duration, input: &mut Input) {
        if let Some((rating, pressed_at)) = self.clicked.take() {
            self.rate(rating, Some(pressed_at), now);
        }
        if ui.input(|input| input.pointer.delta() != egui::Vec2::ZERO) {
            self.mouse_moved_s = ui.input(|input| input.time);
        }
        self.turn_dial(ui, now);
        for (key, place) in self.fresh_keys(ui) {
            match key {
                // Leads from the instructions back to the pause page.
                Key::Escape if self.reread.take().is_some() => {}
                Key::Escape => self.step(Event::Pause, now),
                Key::Backspace => self.step(Event::Undo, now),
                Key::S if self.is_trial() => self.scale_shown = !self.scale_shown,
                Key::Enter if self.dial().is_some() => self.rate(0, input.key(place), now),
                _ if self.dial().is_some() => {
                    let turns = DIAL_KEYS.iter().any(|(dial, _)| *dial == key);
                    if self.is_trial() && !turns {
                        self.feedback.wrong_key();
                    }
                }
                // On some keyboards, the top row produces digits only with Shift, so its physical keys count. Letters
                // count by meaning, because their positions differ between keyboards.
                _ => {
                    let digit = place.name().starts_with(|c: char| c.is_ascii_digit()).then_some(place);
                    let pressed_at = input.key(place);
                    let rating = self.rating(key).or_else(|| self.rating(digit?));
                    if let Some(rating) = rating {
                        self.rate(rating, pressed_at, now);
                    } else if self.is_trial() {
                        self.feedback.wrong_key();
                    }
                }
            }
        }
    }

    fn dial(&self) -> Option<Dial> {
        self.session.protocol().task.dial()
    }

    /// Changes the value that participants set: by the arrow keys, which may be held, or the wheel.
    fn turn_dial(&mut self, ui: &egui::Ui, now: Duration) {
        let Some(dial) = self.dial().filter(|_| self.session.can_answer()) else { return };
        for event in ui.input(|input| input.events.clone()) {
            let (steps, fine) = match event {
                egui::Event::Key { key, pressed: true, modifiers, .. } => {
                    (DIAL_KEYS.iter().find(|(dial, _)| *dial == key).map_or(0.0, |(_, step)| *step), modifiers.shift)
                }
                egui::Event::MouseWheel { delta, modifiers, .. } => {
                    // With Shift, some systems scroll sideways.
                    let delta = if delta.y == 0.0 { delta.x } else { delta.y };
                    (f64::from(if delta == 0.0 { 0.0 } else { delta.signum() }), modifiers.shift)
                }
                _ => continue,
            };
            if steps != 0.0 {
                let steps = if fine { steps / Dial::FINE } else { steps };
                let value = self.session.value().unwrap_or_else(|| dial.at(0.5));
                self.step(Event::Adjust(dial.turned(value, steps)), now);
            }
        }
    }

    /// Rates the stimulus at the time of the key or click or, if that is unknown, now.
    fn rate(&mut self, rating: u8, pressed_at: Option<PressTime>, now: Duration) {
        let event = match pressed_at {
            Some(PressTime { at_s, uncertainty }) => Event::RateAt { rating, at: self.session_time(at_s), uncertainty },
            None => Event::Rate(rating),
        };
        self.step(event, now);
    }

    fn rating(&self, key: Key) -> Option<u8> {
        let name = key.name();
        let categories = &self.session.protocol().response.categories;
        let index = categories.iter().position(|category| name.eq_ignore_ascii_case(&category.key.to_string()))?;
        u8::try_from(index).ok()
    }

    fn is_trial(&self) -> bool {
        matches!(
            self.session.state(),
            State::Recovery { .. }
                | State::Stimulus { .. }
                | State::Gap { .. }
                | State::Response { .. }
                | State::Closing { .. }
        )
    }

    fn step(&mut self, event: Event, now: Duration) {
        let undoes = event == Event::Undo && self.session.can_undo();
        let effect = self.session.step(event, now);
        if undoes {
            self.feedback.undone(now);
        }
        let Effect::Record(response) = effect else { return };
        let task = &self.session.protocol().task;
        let right = task.judge(&response.shown, &response.answer).filter(|_| task.feedback());
        self.feedback.answered(now, right);
        // The row is saved before anything else happens. In the meantime, the screen shows the field.
        match self.recording.record(&mut self.session, &response) {
            Ok(()) => _ = self.session.step(Event::Stored, now),
            Err(error) => self.unsaved_answer = Some(UnsavedAnswerPage::new(error.to_string())),
        }
    }

    fn show_unsaved_answer(&mut self, ui: &mut egui::Ui, now: Duration) {
        let Some(page) = &mut self.unsaved_answer else { return };
        let tried = match page.show(ui) {
            None => return,
            Some(SaveChoice::Retry) => self.recording.store.retry(),
            Some(SaveChoice::ContinueIn(folder)) => self.recording.store.continue_in(&folder),
        };
        match tried {
            Ok(()) => {
                self.unsaved_answer = None;
                self.session.step(Event::Stored, now);
                // The participant looked at this page rather than at the field, so the recovery starts over.
                self.session.step(Event::Pause, now);
                self.session.step(Event::Resume, now);
            }
            Err(error) => page.what = error.to_string(),
        }
        ui.ctx().request_repaint();
    }

    fn too_small(&self, ctx: &egui::Context) -> Option<String> {
        let scale = ctx.pixels_per_point().into();
        let room = room(self.session.protocol(), self.size_px, scale, "window", window_px(ctx).into());
        room.err().map(|error| error + " Make the window larger.")
    }

    /// Returns the stimuli of the current trial, in the order of their places or intervals.
    fn stimuli(&self) -> Vec<Stimulus> {
        let Some(shown) = self.session.shown() else { return Vec::new() };
        let mut stimuli = shown.stimuli.clone();
        if let (Some(Dial { parameter: Some(name), .. }), Some(value)) = (self.dial(), self.session.value())
            && self.session.can_answer()
        {
            // The definition was checked at both ends of the dial.
            stimuli.iter_mut().for_each(|stimulus| _ = stimulus.set(&name, &value.into()));
        }
        stimuli
    }

    /// Prepares the images of the current trial before they are shown.
    fn prepare(&mut self, ctx: &egui::Context) {
        for stimulus in self.stimuli() {
            if self.textures.iter().any(|(made, _)| *made == stimulus) {
                continue;
            }
            let codes = stimulus.codes(self.size_px, &self.quantizer);
            let texture = pixels::texture(ctx, "stimulus", &codes);
            // What participants set is recorded; of an adjustment, only its beginning is a picture of the trial.
            if self.session.shown().is_some_and(|shown| shown.stimuli.contains(&stimulus)) {
                self.recording.picture(stimulus.clone(), codes);
            }
            self.textures.push((stimulus, texture));
            if self.textures.len() > TEXTURES_KEPT {
                drop(self.textures.remove(0));
            }
        }
    }

    fn draw(&mut self, ui: &mut egui::Ui, now: Duration, window_s: f64, input: &mut Input) -> Step<Box<Finish>> {
        let back = self.session.can_go_back();
        let protocol = self.session.protocol();
        let answer = match self.session.state() {
            State::Instructions(page) => {
                let resumed = self.resumed.then(|| self.session.progress());
                let pictures = &mut self.categories;
                instructions::instructions(ui, (*page, back), protocol, resumed, pictures, &self.quantizer)
            }
            State::PhaseStart(phase) => instructions::phase_start(ui, *phase, protocol, &self.session.progress(), back),
            State::Break => instructions::rest(ui, &self.session.progress(), &protocol.instructions),
            State::Paused(_) => {
                self.draw_pause(ui, now);
                Step::Stay
            }
            State::Done | State::Left => return self.finish(ui.ctx()),
            // The field or a stimulus.
            _ => {
                self.draw_trial(ui, now, window_s, input);
                Step::Stay
            }
        };
        match answer {
            Step::Stay => return Step::Stay,
            Step::Next(()) => self.step(Event::Continue, now),
            Step::Back => self.step(Event::Back, now),
        }
        release_focus(ui.ctx());
        Step::Stay
    }

    /// Draws the pause page, or the instructions that are read again during the pause.
    fn draw_pause(&mut self, ui: &mut egui::Ui, now: Duration) {
        let protocol = self.session.protocol();
        if let Some(page) = self.reread {
            let step =
                instructions::instructions(ui, (page, true), protocol, None, &mut self.categories, &self.quantizer);
            self.reread = match step {
                Step::Stay => return,
                Step::Next(()) => Some(page + 1).filter(|page| *page < INSTRUCTION_PAGES),
                Step::Back => page.checked_sub(1),
            };
            return release_focus(ui.ctx());
        }
        let why = self.too_small(ui.ctx());
        match instructions::paused(ui, &self.session.progress(), protocol, why.as_deref()) {
            Some(PauseChoice::Resume) if why.is_none() => self.step(Event::Resume, now),
            Some(PauseChoice::Reread) => self.reread = Some(0),
            Some(PauseChoice::Leave) => self.step(Event::Leave, now),
            _ => return,
        }
        release_focus(ui.ctx());
    }

    /// Returns the background color: the color of the uniform field during trials.
    pub fn ground(&self) -> Color32 {
        if self.is_trial() && self.unsaved_answer.is_none() { self.field } else { theme::DARK_PAGE }
    }

    fn draw_trial(&mut self, ui: &mut egui::Ui, now: Duration, window_s: f64, input: &mut Input) {
        let rating_now = self.session.can_answer();
        CentralPanel::default().frame(Frame::NONE).show(ui, |ui| {
            let State::Stimulus { interval, .. } = *self.session.state() else {
                self.draw_feedback(ui, now);
                return;
            };
            let (area, layout) = (ui.ctx().content_rect(), self.session.protocol().task.layout());
            let stimuli = self.stimuli();
            let at_once =
                if let Layout::Intervals { .. } = layout { &stimuli[interval..=interval] } else { &stimuli[..] };
            let places = pixels::places(area, ui.ctx().pixels_per_point(), layout, self.size_px);
            for (stimulus, place) in at_once.iter().zip(places) {
                if let Some((_, texture)) = self.textures.iter().find(|(made, _)| made == stimulus) {
                    pixels::draw_centered(ui, texture, place);
                }
            }
        });
        let scale = &self.session.protocol().response;
        // Nothing is ever drawn on a stimulus.
        let lowest = ui.ctx().content_rect().center().y + self.half_height(ui.ctx());
        let covers = || lowest > ui.ctx().content_rect().bottom() - scale_height(ui.ctx(), scale);
        let is_shown = self.scale_shown && !(matches!(self.session.state(), State::Stimulus { .. }) && covers());
        let mut set = None;
        let clicked = match self.dial() {
            // A slider is always shown, because without it, nobody could answer.
            Some(dial) if dial.parameter.is_none() => {
                let value = self.session.value().map(|value| dial.share(value));
                set = draw_slider(ui.ctx(), scale, rating_now, value).map(|share| dial.at(share));
                None
            }
            Some(_) => None,
            None if is_shown => draw_scale(ui.ctx(), scale, rating_now),
            None => None,
        };
        if let Some(value) = set {
            self.step(Event::Adjust(value), now);
        }
        if !(self.scale_shown || has_slider(self.session.protocol())) || window_s - self.mouse_moved_s > CURSOR_S {
            ui.ctx().set_cursor_icon(CursorIcon::None);
        }
        if let Some(rating) = clicked {
            // This frame still shows the stimulus; the next frame responds to the click.
            let frame = PressTime { at_s: window_s, uncertainty: None };
            self.clicked = Some((rating, input.click().unwrap_or(frame)));
        }
    }

    /// Returns half the height of the stimuli, points.
    fn half_height(&self, ctx: &egui::Context) -> f32 {
        let [_, high] = self.session.protocol().task.layout().size_px(self.size_px);
        high as f32 / ctx.pixels_per_point() / 2.0
    }

    /// Draws feedback on the uniform field, below the place of the stimulus and above the scale.
    fn draw_feedback(&mut self, ui: &egui::Ui, now: Duration) {
        let protocol = self.session.protocol();
        let area = ui.ctx().content_rect();
        let below = area.center().y + self.half_height(ui.ctx()) + MARK_BELOW;
        let center = egui::pos2(area.center().x, below.min(area.bottom() - SCALE_ABOVE));
        let text = &protocol.instructions.answer_keys;
        let keys = match protocol.task.dial() {
            Some(_) => text.replace("{keys}", &protocol.instructions.dial_keys),
            None => protocol.response.fill_keys(text),
        };
        if let (Layout::Intervals { .. }, State::Response { .. }) = (protocol.task.layout(), self.session.state()) {
            write(ui, area.center(), self.field, 18.0, &format!("{}  {keys}", protocol.response.question));
        }
        let state = (self.session.state(), now);
        self.feedback.draw(ui, state, protocol.recovery_duration(), center, self.field, &keys);
    }

    fn finish(&mut self, ctx: &egui::Context) -> Step<Box<Finish>> {
        let error = self.close();
        ctx.send_viewport_cmd(ViewportCommand::Fullscreen(false));
        ctx.send_viewport_cmd(ViewportCommand::MinInnerSize(MIN_SIZE));
        let protocol = self.session.protocol();
        Step::Next(Box::new(Finish {
            plot: OwnPlot::new(protocol, &self.recording.rows),
            protocol: protocol.clone(),
            path: self.recording.store.csv().to_owned(),
            complete: *self.session.state() == State::Done,
            unopened: None,
            frames: self.screen.sentence(self.session.frame_times()),
            error,
        }))
    }

    /// Says how to resume the session after the window is closed.
    pub fn how_to_resume(&self) -> String {
        let identity = &self.recording.identity;
        let (subject, session) = (identity.subject(), identity.session());
        format!(
            "Every answer so far is saved. To resume, start machband again, choose {subject}, session {session}, on the \
                page Studies, and press Resume."
        )
    }

    /// Ends the sitting if it has not ended; returns the write error, if any.
    pub fn close(&mut self) -> Option<String> {
        self.recording.close(&mut self.session, &self.screen)
    }
}
