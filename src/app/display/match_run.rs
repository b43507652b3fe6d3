//! Shows the matches one at a time and handles the keys.

use eframe::egui::{self, CursorIcon, Event, Key, TextureHandle};

use crate::{
    app::{
        display::calibrate::{Findings, Run},
        ui::{Monitor, Step, describe, pixels, secondary, show_error, window_px, work::Kept},
    },
    display::matching::{GAP_S, Match, Matching},
    store::{StoreError, matches::MatchFile},
};

/// Height reserved for the line of text below the field, points.
const TEXT_ROOM: f32 = 34.0;
/// Minimum side of the field, physical pixels.
const MIN_PX: u32 = 64;
/// Ratio of the side of the field to the side of the patch.
const FIELD_PER_PATCH: u32 = 3;

/// A run of matches and the file that they are saved to.
pub struct MatchRun {
    matching: Matching,
    file: MatchFile,
    /// The window's time at which the next match appears, seconds.
    due_s: f64,
    /// The window's time at which the first match appears, seconds; `None` until the first frame.
    start_s: Option<f64>,
    shown: Kept<(Match, u32), TextureHandle>,
    /// Why the last match could not be saved; `None` if it is in the file.
    unsaved: Option<String>,
}

impl MatchRun {
    pub fn new(matching: Matching, file: MatchFile) -> Self {
        Self { matching, file, due_s: 0.0, start_s: None, shown: Kept::default(), unsaved: None }
    }

    fn press(&mut self, key: Key, repeated: bool, now: f64, start_s: f64) {
        let since_start = now - start_s;
        match key {
            Key::Backspace if !repeated => {
                if let Some(undone) = self.matching.undo() {
                    let number = self.matching.done().len() + 1;
                    let saved = self.file.record(number, &undone, since_start, true);
                    self.next(saved, now);
                }
            }
            _ if now < self.due_s => {}
            Key::Enter if !repeated => {
                if let Some(accepted) = self.matching.accept() {
                    let saved = self.file.record(self.matching.done().len(), &accepted, since_start, false);
                    self.next(saved, now);
                }
            }
            Key::ArrowUp | Key::ArrowRight => self.adjust(1),
            Key::ArrowDown | Key::ArrowLeft => self.adjust(-1),
            Key::PageUp => self.adjust(10),
            Key::PageDown => self.adjust(-10),
            _ => {}
        }
    }

    fn adjust(&mut self, by: i8) {
        if let Some(shown) = self.matching.shown() {
            self.matching.adjust(shown.code.saturating_add_signed(by));
        }
    }

    /// Begins the blank interval after a match. A match that could not be written is written with the next one.
    fn next(&mut self, saved: Result<(), StoreError>, now: f64) {
        self.unsaved = saved.err().map(|error| error.to_string());
        self.due_s = now + GAP_S;
    }

    /// Returns whether every match is in the file, after another attempt if one is not.
    fn is_saved(&mut self) -> bool {
        if self.unsaved.is_some() {
            self.unsaved = self.file.save().err().map(|error| error.to_string());
        }
        self.unsaved.is_none()
    }

    fn draw(&mut self, ui: &mut egui::Ui, shown: Match) {
        let (width, height) = window_px(ui.ctx());
        let below = (TEXT_ROOM * ui.ctx().pixels_per_point()).ceil() as u32;
        let side = width.min(height.saturating_sub(2 * below)).max(MIN_PX);
        let texture = self.shown.get((shown, side), || {
            let patch = shown.channel.rgb(shown.code);
            let image = shown.rows.picture(shown.channel, patch, [side; 2], side / FIELD_PER_PATCH);
            pixels::texture(ui.ctx(), "matching", &image)
        });
        let area = ui.ctx().content_rect();
        pixels::draw_centered(ui, texture, area);
        let response = ui.interact(area, ui.scope_id().with("field"), egui::Sense::hover());
        let (channel, rows) = (shown.channel, shown.rows);
        describe(
            &response,
            &format!("{} of {} rows lit in {channel}; square with code {}", rows.lit, rows.period, shown.code),
        );
    }

    /// Draws the line with the keys and the progress, or the error.
    fn line(&self, ui: &mut egui::Ui) {
        let (done, all) = (self.matching.done().len(), self.matching.total());
        let text = format!(
            "Make the square vanish with the left and right arrow keys, then press Enter · {} of {all}, about {:.0} min left · Esc to pause",
            done + 1,
            (self.matching.remaining_s() / 60.0).ceil()
        );
        let area = ui.ctx().content_rect();
        let line = egui::Rect::from_min_max(egui::pos2(area.min.x + 12.0, area.max.y - TEXT_ROOM), area.max);
        ui.scope_builder(egui::UiBuilder::new().max_rect(line), |ui| match &self.unsaved {
            Some(error) => show_error(ui, format!("The last match is not saved yet; the program tries again: {error}")),
            None => _ = ui.add(egui::Label::new(secondary(text)).truncate()),
        });
    }
}

impl Drop for MatchRun {
    /// Tries once more to write a match that could not be written.
    fn drop(&mut self) {
        self.is_saved();
    }
}

impl Run for MatchRun {
    /// Handles the keys, then draws the field.
    fn show(&mut self, ui: &mut egui::Ui, _: &Monitor) -> Step<Option<Findings>> {
        let now = ui.input(|input| input.time);
        let start_s = *self.start_s.get_or_insert(now + GAP_S);
        self.due_s = self.due_s.max(start_s);
        for event in ui.input(|input| input.events.clone()) {
            let Event::Key { key, pressed: true, repeat, modifiers, .. } = event else { continue };
            if modifiers.command || modifiers.alt {
                continue;
            }
            if key == Key::Escape {
                return Step::Back;
            }
            self.press(key, repeat, now, start_s);
        }
        let shown = self.matching.shown();
        if shown.is_none() && self.is_saved() {
            return Step::Next(None);
        }
        ui.ctx().set_cursor_icon(CursorIcon::None);
        egui::CentralPanel::default().frame(egui::Frame::NONE).show(ui, |ui| {
            match shown {
                Some(shown) if now >= self.due_s => self.draw(ui, shown),
                _ => ui.ctx().request_repaint(),
            }
            self.line(ui);
        });
        Step::Stay
    }
}
