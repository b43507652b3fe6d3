//! The pictures one by one, and the keys.

use std::path::Path;

use eframe::egui::{self, CursorIcon, Event, Key, TextureHandle};

use crate::{
    app::{monitor::window_px, pixels, theme},
    display::matching::{
        Judgement, Method, Nulling, NullingStimulus, Observation, picture,
        plan::{GAP_S, Plan},
    },
    store::{StoreError, matches::NullingFile},
};

/// Room for the line of text below the field, points.
const TEXT_ROOM: f32 = 34.0;
/// Smallest field, physical pixels.
const LEAST_PX: u32 = 64;
/// The patch's side, as a part of the field's.
const PATCH: u32 = 3;

/// A run and its file.
pub struct Trials {
    nulling: Nulling,
    file: NullingFile,
    /// When the present picture may be seen: the window's time.
    due_s: f64,
    /// The window's time at the first picture.
    start_s: Option<f64>,
    shown: Option<(NullingStimulus, u32, TextureHandle)>,
    trouble: Option<String>,
}

/// Where a trial leads.
pub enum Go {
    Stay,
    Pause,
    Done,
}

impl Trials {
    /// A run that has not begun.
    pub fn new(nulling: Nulling, file: NullingFile) -> Self {
        Self { nulling, file, due_s: 0.0, start_s: None, shown: None, trouble: None }
    }

    /// The picture comes after the gap.
    pub fn begin(&mut self, now: f64) {
        self.due_s = now + GAP_S;
        self.start_s.get_or_insert(self.due_s);
    }

    /// Where the answers are.
    pub fn file(&self) -> &Path {
        self.file.path()
    }

    /// How it is answered.
    pub fn method(&self) -> Method {
        self.nulling.plan().method
    }

    /// The longest period of rows.
    pub fn period_px(&self) -> u32 {
        self.nulling.plan().longest_period_px()
    }

    /// What is matched.
    pub fn plan(&self) -> &Plan {
        self.nulling.plan()
    }

    /// The answers that count.
    pub fn observations(&self) -> &[Observation] {
        self.nulling.observations()
    }

    /// How far it is.
    pub fn progress_sentence(&self) -> String {
        let progress = self.nulling.progress();
        let minutes = (progress.left_s / 60.0).ceil();
        format!("{} of {} done, about {minutes:.0} min left.", progress.done, progress.total)
    }

    /// One frame: keys, then the picture.
    pub fn show(&mut self, ui: &mut egui::Ui) -> Go {
        let now = ui.input(|input| input.time);
        for (key, repeated) in keys(ui) {
            if key == Key::Escape {
                return Go::Pause;
            }
            self.hear(key, repeated, now);
        }
        let Some(stimulus) = self.nulling.stimulus() else { return Go::Done };
        ui.ctx().set_cursor_icon(CursorIcon::None);
        egui::CentralPanel::default().frame(egui::Frame::NONE).show(ui, |ui| {
            if now < self.due_s {
                ui.ctx().request_repaint();
            } else {
                self.draw(ui, stimulus);
            }
            self.below(ui);
        });
        Go::Stay
    }

    fn hear(&mut self, key: Key, repeated: bool, now: f64) {
        if key == Key::Backspace && !repeated {
            if let Some(observation) = self.nulling.undo() {
                let kept = self.file.take_back(&observation, self.since_start(now));
                self.next(kept, now);
            }
            return;
        }
        if now < self.due_s {
            return;
        }
        let answered = match self.nulling.plan().method {
            Method::Staircase if repeated => None,
            Method::Staircase => judgement(key).and_then(|judgement| self.nulling.answer(judgement)),
            Method::Adjustment if key == Key::Enter && !repeated => self.nulling.accept(),
            Method::Adjustment => {
                self.adjust(key);
                None
            }
        };
        if let Some(observation) = answered {
            let kept = self.file.answer(&observation, self.since_start(now));
            self.next(kept, now);
        }
    }

    fn adjust(&mut self, key: Key) {
        let by = match key {
            Key::ArrowUp | Key::ArrowRight => 1,
            Key::ArrowDown | Key::ArrowLeft => -1,
            Key::PageUp => 10,
            Key::PageDown => -10,
            _ => return,
        };
        if let Some(stimulus) = self.nulling.stimulus() {
            self.nulling.adjust(stimulus.patch.saturating_add_signed(by));
        }
    }

    fn since_start(&self, now: f64) -> f64 {
        now - self.start_s.unwrap_or(now)
    }

    /// After an answer: the gap. An answer that is not on disk is tried again with the next.
    fn next(&mut self, kept: Result<(), StoreError>, now: f64) {
        self.trouble = kept.err().map(|error| error.to_string());
        self.due_s = now + GAP_S;
    }

    fn draw(&mut self, ui: &mut egui::Ui, stimulus: NullingStimulus) {
        let (width, height) = window_px(ui.ctx());
        let below = (TEXT_ROOM * ui.ctx().pixels_per_point()).ceil() as u32;
        let size = width.min(height.saturating_sub(2 * below)).max(LEAST_PX);
        if self.shown.as_ref().is_none_or(|(made, at, _)| *made != stimulus || *at != size) {
            let image = picture(&stimulus, size, size, size / PATCH);
            self.shown = Some((stimulus, size, pixels::texture_of(ui.ctx(), "nulling", &image)));
        }
        let Some((_, _, texture)) = &self.shown else { return };
        let area = ui.ctx().content_rect();
        pixels::draw_centered(ui, texture, area);
        let response = ui.interact(area, ui.scope_id().with("field"), egui::Sense::hover());
        let label = describe(&stimulus);
        response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, &label));
    }

    /// Keys and progress, or what went wrong.
    fn below(&self, ui: &mut egui::Ui) {
        let keys = match self.nulling.plan().method {
            Method::Staircase => "The square is brighter: arrow up · darker: arrow down · the same: S",
            Method::Adjustment => "Make the square vanish: arrows left and right, then Enter",
        };
        let progress = self.nulling.progress();
        let text = format!("{keys} · {} of {} · Esc pauses", progress.done + 1, progress.total);
        let area = ui.ctx().content_rect();
        let line = egui::Rect::from_min_max(egui::pos2(area.min.x + 12.0, area.max.y - TEXT_ROOM), area.max);
        ui.scope_builder(egui::UiBuilder::new().max_rect(line), |ui| {
            match &self.trouble {
                Some(trouble) => theme::fault(ui, &format!("Not saved yet, will be tried again: {trouble}")),
                None => _ = ui.add(egui::Label::new(theme::quiet(text)).truncate()),
            };
        });
    }
}

/// What the picture shows, for someone who cannot see it.
fn describe(stimulus: &NullingStimulus) -> String {
    let rows = stimulus.rows;
    format!(
        "Rows in {}: {} of {} with code {}, the others {}; square of code {}",
        stimulus.channel, rows.lit, rows.period, rows.hi, rows.lo, stimulus.patch
    )
}

fn judgement(key: Key) -> Option<Judgement> {
    Some(match key {
        Key::ArrowUp | Key::B => Judgement::Brighter,
        Key::ArrowDown | Key::D => Judgement::Darker,
        Key::S => Judgement::Same,
        _ => return None,
    })
}

/// Keys that went down, in order, and whether each only repeats.
fn keys(ui: &egui::Ui) -> Vec<(Key, bool)> {
    ui.input(|input| {
        let of = |event: &Event| match event {
            Event::Key { key, pressed: true, repeat, modifiers, .. } if !(modifiers.command || modifiers.alt) => {
                Some((*key, *repeat))
            }
            _ => None,
        };
        input.events.iter().filter_map(of).collect()
    })
}
