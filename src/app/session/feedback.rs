//! What the uniform field says between trials: that an answer was received or taken back, and which keys count. It is
//! never drawn on a stimulus, it is the same for every answer, and it is gone by the middle of the recovery.

use std::time::Duration;

use eframe::egui::{self, Align2, Color32, FontId, Pos2, Stroke, Ui, Vec2};

use crate::experiment::State;

/// How long a mark is shown, unless half of the recovery is shorter.
const MARK: Duration = Duration::from_millis(400);
/// How long the keys are shown, unless half of the recovery is shorter.
const KEYS: Duration = Duration::from_millis(2000);
/// Half the length of a mark, points.
const HALF: f32 = 14.0;
/// Factors from the code of the field to the codes of a mark and of a text, so that they have the field's hue.
const MARK_SHADE: f32 = 0.86;
const TEXT_SHADE: f32 = 0.55;
/// Below this code, a field is too dark for something darker.
const DARK: u8 = 48;

/// What a mark says.
#[derive(Clone, Copy, PartialEq)]
enum Mark {
    Answered,
    Right,
    Wrong,
    Undone,
}

/// What is to be said.
#[derive(Default)]
pub struct Feedback {
    /// The last mark and the session time of its event, at which the recovery began.
    mark: Option<(Mark, Duration)>,
    wrong_key: bool,
    /// When the keys that count were first drawn.
    keys_since: Option<Duration>,
}

impl Feedback {
    /// An answer was received; `right` if participants are told whether it was right.
    pub fn answered(&mut self, now: Duration, right: Option<bool>) {
        let mark = right.map_or(Mark::Answered, |right| if right { Mark::Right } else { Mark::Wrong });
        self.mark = Some((mark, now));
    }

    /// Asks for the answer after the last interval.
    pub fn ask(&self, ui: &Ui, center: Pos2, field: Color32, question: &str) {
        let (font, color) = (FontId::proportional(18.0), shade(field, TEXT_SHADE));
        ui.painter().text(center, Align2::CENTER_CENTER, question, font, color);
    }

    /// An answer was taken back.
    pub fn undone(&mut self, now: Duration) {
        self.mark = Some((Mark::Undone, now));
    }

    /// A key without meaning was pressed. If a stimulus is shown, the next field answers it.
    pub fn wrong_key(&mut self) {
        (self.wrong_key, self.keys_since) = (true, None);
    }

    /// Draws what is to be said in this state of a trial, around `center`. `recovery` is its planned duration, `keys`
    /// the text about the keys.
    pub fn draw(
        &mut self,
        ui: &Ui,
        (state, now): (&State, Duration),
        recovery: Duration,
        center: Pos2,
        field: Color32,
        keys: &str,
    ) {
        let since = match state {
            State::Recovery { since } | State::Closing { since } => Some(*since),
            _ => None,
        };
        let elapsed = since.map(|since| now.saturating_sub(since));
        let is_early = elapsed.is_some_and(|elapsed| elapsed < recovery / 2);
        // After a page or a pause, the recovery does not begin with the event.
        let mark = self.mark.filter(|(_, at)| Some(*at) == since && is_early && elapsed < Some(MARK));
        if let Some((mark, _)) = mark {
            draw_mark(ui, mark, center, shade(field, MARK_SHADE));
        }
        if !self.wrong_key {
            return;
        }
        let may_show = is_early || matches!(state, State::Response { .. });
        if may_show && now.saturating_sub(*self.keys_since.get_or_insert(now)) < KEYS {
            let color = shade(field, TEXT_SHADE);
            ui.painter().text(
                center + Vec2::new(0.0, 26.0),
                Align2::CENTER_CENTER,
                keys,
                FontId::proportional(16.0),
                color,
            );
        } else if self.keys_since.take().is_some() {
            self.wrong_key = false;
        }
    }
}

/// Draws a short line for an answer, a check mark if it was right, a cross if it was wrong, and an arrow back for one
/// that was taken back.
fn draw_mark(ui: &Ui, mark: Mark, center: Pos2, color: Color32) {
    let at = |x: f32, y: f32| center + Vec2::new(x, y) * HALF;
    let lines = match mark {
        Mark::Answered => vec![vec![at(-1.0, 0.0), at(1.0, 0.0)]],
        Mark::Right => vec![vec![at(-0.8, 0.0), at(-0.2, 0.6), at(0.9, -0.7)]],
        Mark::Wrong => vec![vec![at(-0.7, -0.7), at(0.7, 0.7)], vec![at(-0.7, 0.7), at(0.7, -0.7)]],
        Mark::Undone => {
            vec![vec![at(-1.0, 0.0), at(1.0, 0.0)], vec![at(-0.4, -0.6), at(-1.0, 0.0), at(-0.4, 0.6)]]
        }
    };
    ui.painter().extend(lines.into_iter().map(|line| egui::Shape::line(line, Stroke::new(4.0, color))));
}

/// Returns a color of the field's hue that differs from it: darker, or lighter on a dark field.
fn shade(field: Color32, factor: f32) -> Color32 {
    let [r, g, b, _] = field.to_array();
    if r.max(g).max(b) < DARK {
        let lift = (255.0 * (1.0 - factor) * 0.6) as u8;
        return Color32::from_rgb(r.saturating_add(lift), g.saturating_add(lift), b.saturating_add(lift));
    }
    let [r, g, b] = [r, g, b].map(|code| (f32::from(code) * factor).round() as u8);
    Color32::from_rgb(r, g, b)
}
