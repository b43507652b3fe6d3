//! Draws what participants can answer with the mouse, the categories of a scale or a slider, and what the uniform field says
//! between trials: that an answer was received or taken back, and which keys count. That is never drawn on a stimulus, it is
//! the same for every answer, and it is gone by the middle of the recovery.

use std::time::Duration;

use eframe::egui::{
    self, Align2, Area, Button, Color32, FontId, Frame, Id, Pos2, RichText, Stroke, TextStyle, Ui, Vec2,
};

use crate::{
    app::ui::theme,
    experiment::{Category, ResponseScale, State},
};

/// Maximum width of a button of the scale, points.
const MAX_WIDTH: f32 = 250.0;
/// Gap between two buttons, points.
const GAP: f32 = 6.0;
/// Minimum width of a button with a label, points. A narrower button shows only its key, because the label would be cut
/// off.
const MIN_LABELED_WIDTH: f32 = 100.0;
/// Maximum length of the slider, points.
const SLIDER_LENGTH: f32 = 600.0;

/// Padding of a button of the scale, its margin, and its distance from the lower edge of the window, points.
const PADDING: Vec2 = Vec2::new(6.0, 4.0);
const MARGIN: f32 = 6.0;
const BELOW: f32 = 8.0;

/// Returns the text of each button of the scale, and the size of all of them: the highest needs it.
fn buttons(ctx: &egui::Context, scale: &ResponseScale) -> (Vec<String>, Vec2) {
    let count = scale.categories.len().max(1) as f32;
    let width = ((ctx.content_rect().width() - 40.0) / count - GAP).min(MAX_WIDTH);
    let text = |category: &Category| match width < MIN_LABELED_WIDTH {
        true => category.key_name(),
        false => format!("{}  {}", category.key_name(), category.label),
    };
    let texts: Vec<String> = scale.categories.iter().map(text).collect();
    let style = ctx.global_style();
    let font = TextStyle::Small.resolve(&style);
    let high = |text: &String| {
        let room = width - 2.0 * PADDING.x;
        let text = ctx.fonts_mut(|fonts| fonts.layout(text.clone(), font.clone(), Color32::WHITE, room));
        text.size().y + 2.0 * PADDING.y
    };
    let height = texts.iter().map(high).fold(style.spacing.interact_size.y, f32::max).ceil();
    (texts, Vec2::new(width.max(height), height))
}

/// Returns the height of the scale with its distance from the lower edge of the window, points.
pub fn scale_height(ctx: &egui::Context, scale: &ResponseScale) -> f32 {
    buttons(ctx, scale).1.y + 2.0 * MARGIN + BELOW
}

/// Draws the rating scale at the lower edge; returns the clicked rating. The scale is the only element besides the
/// field and the stimulus, and it can be hidden. `enabled` is true while there is something to rate.
pub fn draw_scale(ctx: &egui::Context, scale: &ResponseScale, enabled: bool) -> Option<u8> {
    let mut rated = None;
    let (texts, size) = buttons(ctx, scale);
    at_lower_edge(ctx, MARGIN, |ui| {
        ui.spacing_mut().item_spacing.x = GAP;
        ui.spacing_mut().button_padding = PADDING;
        ui.horizontal(|ui| {
            for ((rating, category), text) in (0..).zip(&scale.categories).zip(texts) {
                let button = Button::new(RichText::new(text).small()).frame(enabled).wrap();
                let response = ui.add_enabled_ui(enabled, |ui| ui.add_sized(size, button)).inner;
                response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, enabled, &category.label));
                if response.clicked() {
                    rated = Some(rating);
                }
            }
        });
    });
    rated
}

/// Draws a panel in the middle of the lower edge.
fn at_lower_edge(ctx: &egui::Context, margin: f32, add: impl FnOnce(&mut Ui)) {
    Area::new(Id::unique("scale")).anchor(Align2::CENTER_BOTTOM, [0.0, -BELOW]).show(ctx, |ui| {
        Frame::NONE.fill(theme::SHADE).corner_radius(6.0).inner_margin(margin).show(ui, add);
    });
}

/// Draws the slider with the labels of its ends. Returns the share of its length at which it was clicked or dragged.
pub fn draw_slider(ctx: &egui::Context, scale: &ResponseScale, enabled: bool, share: Option<f64>) -> Option<f64> {
    let mut set = None;
    let length = (ctx.content_rect().width() - 40.0).min(SLIDER_LENGTH);
    at_lower_edge(ctx, 10.0, |ui| {
        ui.set_width(length);
        let sense = if enabled { egui::Sense::click_and_drag() } else { egui::Sense::hover() };
        let (rect, response) = ui.allocate_exact_size(Vec2::new(length, 24.0), sense);
        response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Slider, enabled, &scale.question));
        let color = ui.visuals().text_color().gamma_multiply(if enabled { 1.0 } else { 0.4 });
        let line = rect.shrink2(Vec2::new(8.0, 0.0));
        let stroke = egui::Stroke::new(2.0, color);
        ui.painter().line_segment([line.left_center(), line.right_center()], stroke);
        if let Some(share) = share {
            let x = egui::lerp(line.x_range(), share as f32);
            ui.painter().circle_filled(egui::pos2(x, line.center().y), 8.0, color);
        }
        if let Some(at) = response.interact_pointer_pos().filter(|_| enabled) {
            set = Some(f64::from(((at.x - line.left()) / line.width()).clamp(0.0, 1.0)));
        }
        ui.horizontal(|ui| {
            let end = |category: Option<&Category>| RichText::new(category.map_or("", |end| &*end.label)).small();
            ui.label(end(scale.categories.first()));
            ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                ui.label(end(scale.categories.last()));
            });
        });
    });
    set
}

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
            write(ui, center + Vec2::new(0.0, 26.0), field, 16.0, keys);
        } else if self.keys_since.take().is_some() {
            self.wrong_key = false;
        }
    }
}

/// Writes text on the field.
pub fn write(ui: &Ui, center: Pos2, field: Color32, size: f32, text: &str) {
    let (font, color) = (FontId::proportional(size), shade(field, TEXT_SHADE));
    ui.painter().text(center, Align2::CENTER_CENTER, text, font, color);
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
