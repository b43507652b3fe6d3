//! The session on the screen: turns input into events, effects into rows, and states into pictures.

use std::{
    collections::BTreeSet,
    io::Write as _,
    path::Path,
    time::{Duration, SystemTime, UNIX_EPOCH},
};

use eframe::egui::{self, CursorIcon, Key, TextureHandle, ViewportCommand};
use jiff::Timestamp;
use serde_json::json;

use super::{
    finish::Finish,
    frames,
    hasher::Hasher,
    instructions::{self, Answer, CategoryPictures, INSTRUCTION_PAGES},
    request::Request,
    scale,
    trouble::{Remedy, Trouble},
};
use crate::{
    app::{
        ui::{Monitor, Step, pixels, theme, window_px},
        window::{Input, InputReport, LEAST_SIZE, PressTime},
    },
    display::{Viewing, frames::Refresh},
    experiment::{
        Effect, Event, FrameCount, Identity, Phase, Resumed, RowContext, Schedule, Session, SessionOptions, State,
        TrialRecord, TrialResponse, session_seed,
    },
    light::{Bits, Quantizer},
    store::{
        StoreError,
        frames::FrameRow,
        profile,
        session::SessionStore,
        sidecar::{Pictures, PreflightNote, Sitting},
    },
};

/// Textures kept: the stimulus on the screen and the one that comes next.
const TEXTURES_KEPT: usize = 2;
/// How long the cursor stays after the mouse moved, where the scale can be clicked, seconds.
const CURSOR_S: f64 = 2.0;

/// What the preflight settled.
pub struct Prepared {
    /// Screen and distance.
    pub viewing: Viewing,
    /// Side of the stimulus in physical pixels.
    pub size_px: u32,
    /// Against what frames are counted.
    pub frames: FrameCount,
    /// Who knows the frame interval: `reported` by the system, `measured`, or `unknown`.
    pub refresh_source: &'static str,
    /// The window in physical pixels.
    pub window: (u32, u32),
}

/// The refresh of the screen, and where that is known from.
struct ScreenRefresh {
    /// Name and rate of the monitor at the start, to recognize another one.
    first: (Option<String>, Option<f64>),
    /// What the preflight found of it.
    found: (Option<Refresh>, &'static str),
    /// As it is now.
    refresh: Option<Refresh>,
    source: &'static str,
}

impl ScreenRefresh {
    fn new(monitor: &Monitor, prepared: &Prepared) -> Self {
        let refresh = match prepared.frames {
            FrameCount::Against(seconds) => Refresh::new(seconds),
            FrameCount::Off | FrameCount::Frames => None,
        };
        let source = prepared.refresh_source;
        Self { first: (monitor.name.clone(), monitor.refresh_hz), found: (refresh, source), refresh, source }
    }

    /// For the monitor that shows the window now; gives whether the refresh has changed.
    fn update(&mut self, monitor: &Monitor) -> bool {
        let before = self.refresh;
        let reported = monitor.refresh_hz.and_then(|hz| Refresh::from_hz(hz));
        (self.refresh, self.source) = match reported {
            _ if (&self.first.0, self.first.1) == (&monitor.name, monitor.refresh_hz) => self.found,
            Some(_) => (reported, "reported"),
            None => (None, "unknown"),
        };
        self.refresh != before
    }

    fn frames(&self) -> FrameCount {
        self.refresh.map_or(FrameCount::Frames, |refresh| FrameCount::Against(refresh.seconds()))
    }
}

/// A session that runs.
pub struct Trials {
    session: Session,
    store: SessionStore,
    identity: Identity,
    sitting: u32,
    /// Rows so far, earlier sittings included, for the plot at the end.
    rows: Vec<TrialRecord>,
    /// The window's time at which the session's time was `offset`.
    window_start_s: f64,
    /// Session time at the start of this sitting.
    offset: Duration,
    /// Wall-clock time at which the session's time was 0.
    origin: Timestamp,
    quantizer: Quantizer,
    /// The recovery field's color.
    field: egui::Color32,
    size_px: u32,
    /// Condition and picture, the latest last.
    textures: Vec<(usize, TextureHandle)>,
    categories: CategoryPictures,
    hasher: Option<Hasher>,
    screen: ScreenRefresh,
    input: InputReport,
    /// Clicked on the scale in the frame before, which still showed the stimulus.
    clicked: Option<(u8, PressTime)>,
    scale_shown: bool,
    trouble: Option<Trouble>,
    resumed: bool,
    closed: bool,
    mouse_moved_s: f64,
    /// Keys that are down, by their place: a key that is held repeats, and counts once. Its meaning can change while it
    /// is down (Shift, Num Lock), so the window system's own word for a repetition is not enough.
    held: BTreeSet<Key>,
}

impl Trials {
    /// Makes or finds the files and shows the first page.
    pub fn begin(
        ctx: &egui::Context,
        request: &Request,
        prepared: Prepared,
        notes: Vec<PreflightNote>,
        monitor: &Monitor,
    ) -> Result<Self, StoreError> {
        let protocol = &request.protocol;
        let sitting = Sitting {
            started_at: Timestamp::now().to_string(),
            display: Some(json!({
                "name": request.display.name,
                "transfer": request.display.transfers.to_string(),
                "sha256": profile::hash(&request.display),
                "profile": profile::value(&request.display),
            })),
            monitor: serde_json::to_value(monitor).ok(),
            viewing: Some(viewing(request, &prepared)),
            preflight: notes,
            pictures: Some(Pictures::new(
                protocol,
                prepared.size_px,
                &request.display.transfers,
                Some(profile::hash(&request.display)),
            )),
            ..Sitting::default()
        };
        let results = &request.results;
        let (store, schedule, resumed, elapsed_s, number, rows) = if request.resume {
            let (store, found) = SessionStore::resume(results, protocol, &request.identity, request.seed, sitting)?;
            (store, found.schedule, found.resumed, found.elapsed_s, found.sitting, found.rows)
        } else {
            let seed = request.seed.unwrap_or_else(fresh_seed);
            let store = SessionStore::create(results, protocol, &request.identity, seed, sitting)?;
            let schedule = Schedule::new(protocol, &request.identity, seed)
                .map_err(|error| StoreError::Mismatch { path: store.csv().to_owned(), what: error.to_string() })?;
            (store, schedule, Resumed::default(), 0.0, 1, Vec::new())
        };
        // A window that kept its least size on a smaller screen would show part of the stimulus, unnoticed.
        ctx.send_viewport_cmd(ViewportCommand::MinInnerSize(egui::Vec2::splat(1.0)));
        let offset = offset(elapsed_s, rows.first());
        let quantizer = Quantizer::new(&request.display.transfers, Bits::Eight);
        let screen = ScreenRefresh::new(monitor, &prepared);
        let options = SessionOptions { pages: INSTRUCTION_PAGES, frames: screen.frames() };
        let session = Session::new(protocol.clone(), schedule, &resumed, options);
        let practising =
            session.current().is_some_and(|trial| session.schedule().trials[trial].phase == Phase::Practice);
        Ok(Self {
            resumed: request.resume,
            session,
            store,
            identity: request.identity.clone(),
            sitting: number,
            rows,
            window_start_s: ctx.input(|input| input.time),
            offset,
            origin: Timestamp::now() - offset,
            field: pixels::field(&quantizer, protocol.stimulus.field_light(protocol.recovery.level)),
            quantizer,
            size_px: prepared.size_px,
            textures: Vec::new(),
            categories: CategoryPictures::default(),
            hasher: Hasher::start(),
            screen,
            input: InputReport::default(),
            clicked: None,
            scale_shown: practising,
            trouble: None,
            closed: false,
            mouse_moved_s: f64::NEG_INFINITY,
            held: BTreeSet::new(),
        })
    }

    /// Whether an answer is only in memory.
    pub fn is_unsaved(&self) -> bool {
        self.session.is_storing()
    }

    /// One frame: input, time, picture.
    pub fn show(&mut self, ui: &mut egui::Ui, monitor: &Monitor, input: &mut Input) -> Step<Box<Finish>> {
        let window_s = ui.input(|input| input.time);
        let now = self.session_time(window_s);
        if self.trouble.is_some() {
            self.session.interrupt_frames();
            // Keys mean nothing to the session now, but those that go up must not count as held later.
            self.fresh_keys(ui);
            self.remedy(ui, now);
            return Step::Stay;
        }
        let was_main = self.in_main();
        self.follow_screen(monitor);
        self.handle_input(ui, now, input);
        self.pause_if_too_small(ui.ctx(), now);
        self.step(Event::Frame, now);
        if self.in_main() && !was_main {
            // Practised: from here on nothing but field and stimulus, unless the participant asks for the scale.
            self.scale_shown = false;
        }
        if self.is_trial() {
            // Every refresh is a frame: timing is held to them, and dropped ones are seen.
            ui.ctx().request_repaint();
        }
        self.prepare(ui.ctx());
        self.draw(ui, now, window_s, input)
    }

    /// The session's time at a time of the window, seconds.
    fn session_time(&self, window_s: f64) -> Duration {
        self.offset + Duration::try_from_secs_f64(window_s - self.window_start_s).unwrap_or_default()
    }

    /// The window may be moved to another monitor, and a monitor set to another rate.
    fn follow_screen(&mut self, monitor: &Monitor) {
        if self.screen.update(monitor) {
            self.session.judge_against(self.screen.frames());
            let hz =
                self.screen.refresh.map_or_else(|| "unknown".to_owned(), |refresh| format!("{:.3} Hz", refresh.hz()));
            self.store.note(format!("the screen's refresh changed: {} {hz}, {}", monitor.title(), self.screen.source));
        }
    }

    fn in_main(&self) -> bool {
        let trial = self.session.current().map(|trial| self.session.schedule().trials[trial].phase);
        trial == Some(Phase::Main)
    }

    /// Keys that have just gone down, in the order in which they came: what each means, and its place.
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

    /// Keys and mouse.
    fn handle_input(&mut self, ui: &egui::Ui, now: Duration, input: &mut Input) {
        if let Some((rating, pressed_at)) = self.clicked.take() {
            self.rate(rating, Some(pressed_at), now);
        }
        if ui.input(|input| input.pointer.delta() != egui::Vec2::ZERO) {
            self.mouse_moved_s = ui.input(|input| input.time);
        }
        for (key, place) in self.fresh_keys(ui) {
            match key {
                Key::Escape => self.step(Event::Pause, now),
                Key::Backspace => self.step(Event::TakeBack, now),
                Key::S if self.is_trial() => self.scale_shown = !self.scale_shown,
                // Some keyboards give the digits of the top row only with Shift; the key itself is then what counts. A
                // letter counts by what it says: its place differs between keyboards.
                _ => {
                    let digit = place.name().starts_with(|c: char| c.is_ascii_digit()).then_some(place);
                    let pressed_at = input.key(place);
                    if let Some(rating) = self.rating(key).or_else(|| self.rating(digit?)) {
                        self.rate(rating, pressed_at, now);
                    }
                }
            }
        }
    }

    /// The stimulus is rated: as it was pressed_at, or, where nothing was stamped, now.
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
        let state = self.session.state();
        self.awaits_rating() || matches!(state, State::Recovery { .. } | State::Closing { .. })
    }

    fn awaits_rating(&self) -> bool {
        matches!(self.session.state(), State::Stimulus { .. } | State::Response { .. })
    }

    fn step(&mut self, event: Event, now: Duration) {
        if let Effect::Record(response) = self.session.step(event, now) {
            self.record(&response, now);
        }
    }

    /// Puts a row on disk before anything else happens; the field is on the screen meanwhile.
    fn record(&mut self, response: &TrialResponse, now: Duration) {
        self.input.rated(response.uncertainty);
        let context = RowContext {
            protocol: self.session.protocol(),
            schedule: self.session.schedule(),
            identity: &self.identity,
            sitting: self.sitting,
        };
        let row = TrialRecord::new(&context, response, self.origin + response.onset);
        match self.store.append(&row) {
            Ok(()) => _ = self.session.step(Event::Stored, now),
            Err(error) => self.trouble = Some(Trouble::new(error.to_string())),
        }
        self.rows.push(row);
        self.store_frames();
    }

    fn store_frames(&mut self) {
        let stretches = self.session.take_stretches();
        let schedule = self.session.schedule();
        let row = |stretch| FrameRow::new(stretch, schedule, self.sitting);
        let rows: Vec<_> = stretches.into_iter().filter_map(row).collect();
        self.store.append_frames(&rows);
    }

    fn remedy(&mut self, ui: &mut egui::Ui, now: Duration) {
        let Some(trouble) = &mut self.trouble else { return };
        let tried = match trouble.show(ui) {
            Remedy::None => return,
            Remedy::Retry => self.store.retry(),
            Remedy::MoveTo(folder) => self.store.move_to(&folder),
        };
        match tried {
            Ok(()) => {
                self.trouble = None;
                self.session.step(Event::Stored, now);
                // The eye has looked at this page and not at the field: the field starts anew.
                self.session.step(Event::Pause, now);
                self.session.step(Event::Resume, now);
            }
            Err(error) => trouble.again(error.to_string()),
        }
        ui.ctx().request_repaint();
    }

    fn too_small(&self, ctx: &egui::Context) -> Option<String> {
        let (width, height) = window_px(ctx);
        (width.min(height) < self.size_px).then(|| {
            format!(
                "The window has {width} × {height} pixels and the stimulus needs {}; make the window larger.",
                self.size_px
            )
        })
    }

    fn pause_if_too_small(&mut self, ctx: &egui::Context, now: Duration) {
        if self.is_trial() && self.too_small(ctx).is_some() {
            self.step(Event::Pause, now);
        }
    }

    /// The picture of the trial at hand, ready before it is due.
    fn prepare(&mut self, ctx: &egui::Context) {
        let Some(trial) = self.session.current() else { return };
        let schedule = self.session.schedule();
        let cell = schedule.trials[trial].condition;
        if self.textures.iter().any(|(made, _)| *made == cell) {
            return;
        }
        let stimulus = &schedule.conditions[cell].stimulus;
        let codes = stimulus.codes(self.size_px, &self.quantizer);
        let texture = pixels::texture_of(ctx, &format!("condition{cell}"), &codes);
        if let Some(hasher) = &self.hasher {
            hasher.take(cell, codes);
        }
        self.textures.push((cell, texture));
        if self.textures.len() > TEXTURES_KEPT {
            drop(self.textures.remove(0));
        }
    }

    fn draw(&mut self, ui: &mut egui::Ui, now: Duration, window_s: f64, input: &mut Input) -> Step<Box<Finish>> {
        let texts = &self.session.protocol().instructions;
        let answer = match self.session.state() {
            State::Recovery { .. } | State::Stimulus { .. } | State::Response { .. } | State::Closing { .. } => {
                self.draw_trial(ui, window_s, input);
                Answer::None
            }
            State::Instructions(page) => {
                let resumed = self.resumed.then(|| self.session.progress());
                instructions::instructions(
                    ui,
                    *page,
                    self.session.protocol(),
                    resumed,
                    &mut self.categories,
                    &self.quantizer,
                )
            }
            State::PhaseStart(phase) => instructions::phase_start(ui, *phase, texts),
            State::Break => instructions::rest(ui, &self.session.progress(), texts),
            State::Paused(_) => {
                let why = self.too_small(ui.ctx());
                match instructions::paused(ui, texts, why.as_deref()) {
                    Answer::Next if why.is_some() => Answer::None,
                    answer => answer,
                }
            }
            State::Done | State::Left => return self.finish(ui.ctx()),
        };
        let paused = matches!(self.session.state(), State::Paused(_));
        match answer {
            Answer::None => return Step::Stay,
            Answer::Next => self.step(if paused { Event::Resume } else { Event::Continue }, now),
            Answer::Leave => self.step(Event::Leave, now),
        }
        ui.ctx().request_repaint();
        Step::Stay
    }

    /// What stands behind everything else: the uniform field during trials.
    pub fn ground(&self) -> egui::Color32 {
        if self.is_trial() && self.trouble.is_none() { self.field } else { theme::PAGE }
    }

    fn draw_trial(&mut self, ui: &mut egui::Ui, window_s: f64, input: &mut Input) {
        let rating_now = self.awaits_rating();
        egui::CentralPanel::default().frame(egui::Frame::NONE).show(ui, |ui| {
            if !matches!(self.session.state(), State::Stimulus { .. }) {
                return;
            }
            let schedule = self.session.schedule();
            let cell = self.session.current().map(|trial| schedule.trials[trial].condition);
            if let Some((_, texture)) = self.textures.iter().find(|(made, _)| Some(*made) == cell) {
                pixels::draw_centered(ui, texture, ui.ctx().content_rect());
            }
        });
        let clicked =
            if self.scale_shown { scale::show(ui.ctx(), &self.session.protocol().response, rating_now) } else { None };
        if !self.scale_shown || window_s - self.mouse_moved_s > CURSOR_S {
            ui.ctx().set_cursor_icon(CursorIcon::None);
        }
        if let Some(rating) = clicked {
            // This frame shows the stimulus; the next one answers.
            let frame = PressTime { at_s: window_s, uncertainty: None };
            self.clicked = Some((rating, input.click().unwrap_or(frame)));
        }
    }

    fn finish(&mut self, ctx: &egui::Context) -> Step<Box<Finish>> {
        let fault = self.close();
        ctx.send_viewport_cmd(ViewportCommand::Fullscreen(false));
        ctx.send_viewport_cmd(ViewportCommand::MinInnerSize(LEAST_SIZE));
        let complete = *self.session.state() == State::Done;
        let frames = self.session.frame_times();
        let finish = Finish::new(
            self.session.protocol().clone(),
            std::mem::take(&mut self.rows),
            self.store.csv().to_owned(),
            complete,
            frames::sentence(frames, self.screen.refresh),
            fault,
        );
        Step::Next(Box::new(finish))
    }

    /// Where the rows are.
    pub fn csv(&self) -> &Path {
        self.store.csv()
    }

    /// Ends the sitting in the sidecar, once; gives what could not be written, which is said on stderr too. A sidecar
    /// that cannot be written now says less, and takes nothing with it.
    pub fn close(&mut self) -> Option<String> {
        if std::mem::replace(&mut self.closed, true) {
            return None;
        }
        // An answer that is in memory only has its last chance.
        let saved = if self.is_unsaved() { self.store.retry() } else { Ok(()) };
        self.store_frames();
        self.store.describe_input(self.input.summary());
        for (condition, sha256) in self.hasher.take().map(Hasher::finish).unwrap_or_default() {
            self.store.note_picture(condition, sha256);
        }
        let (times, file) = (self.session.frame_times(), self.store.frames_file());
        let summary = frames::summary(times, self.screen.refresh, self.screen.source, file);
        let complete = *self.session.state() == State::Done;
        let ended = self.store.finish(complete, Timestamp::now().to_string(), summary);
        let faults: Vec<String> = [saved, ended].into_iter().filter_map(Result::err).map(|e| e.to_string()).collect();
        for fault in &faults {
            // Where nobody listens, nothing is lost.
            let _ = writeln!(std::io::stderr(), "error: {fault}");
        }
        (!faults.is_empty()).then(|| faults.join("\n"))
    }
}

/// Physical pixels of the monitor; a system that does not know them limits nothing.
fn viewing(request: &Request, prepared: &Prepared) -> serde_json::Value {
    let screen = prepared.viewing.screen();
    json!({
        "distance_cm": request.distance_cm,
        "screen_width_cm": screen.width_cm(),
        "screen_width_measured": request.screen_width_cm.or(request.display.screen_width_cm).is_some(),
        "pixels_per_degree": prepared.viewing.px_per_degree(),
        "stimulus_px": prepared.size_px,
        "stimulus_deg": prepared.viewing.deg_from_px(f64::from(prepared.size_px)),
        "window_px": [prepared.window.0, prepared.window.1],
        "windowed": request.windowed,
    })
}

/// Session time at which a resumed sitting starts: by the wall clock, but never before what is recorded, since a clock
/// can be turned back.
fn offset(elapsed_s: f64, first: Option<&TrialRecord>) -> Duration {
    let recorded = Duration::from_secs_f64(elapsed_s);
    let Some(first) = first else { return recorded };
    let since_first = Timestamp::now().duration_since(first.started_at).as_secs_f64() + first.onset_s.0;
    recorded.max(Duration::from_secs_f64(since_first.max(0.0)))
}

/// A seed that differs from session to session.
fn fresh_seed() -> u64 {
    let nanoseconds = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |time| time.as_nanos() as u64);
    session_seed(nanoseconds ^ (u64::from(std::process::id()) << 32))
}
