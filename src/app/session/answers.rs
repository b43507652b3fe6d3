//! Draws what participants can answer with the mouse: the categories of a scale, or a slider.

use eframe::egui::{self, Align2, Area, Button, Color32, Frame, Id, RichText, TextStyle, Vec2};

use crate::{
    app::ui::theme,
    experiment::{Category, ResponseScale},
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
    Area::new(Id::unique("scale")).anchor(Align2::CENTER_BOTTOM, [0.0, -BELOW]).show(ctx, |ui| {
        Frame::NONE.fill(theme::SHADE).corner_radius(6.0).inner_margin(MARGIN).show(ui, |ui| {
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
    });
    rated
}

/// Draws the slider with the labels of its ends. Returns the share of its length at which it was clicked or dragged.
pub fn draw_slider(ctx: &egui::Context, scale: &ResponseScale, enabled: bool, share: Option<f64>) -> Option<f64> {
    let mut set = None;
    let length = (ctx.content_rect().width() - 40.0).min(SLIDER_LENGTH);
    Area::new(Id::unique("slider")).anchor(Align2::CENTER_BOTTOM, [0.0, -BELOW]).show(ctx, |ui| {
        Frame::NONE.fill(theme::SHADE).corner_radius(6.0).inner_margin(10.0).show(ui, |ui| {
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
                let labels: Vec<&str> = scale.categories.iter().map(|category| category.label.as_str()).collect();
                ui.label(RichText::new(labels.first().copied().unwrap_or_default()).small());
                ui.with_layout(egui::Layout::right_to_left(egui::Align::Center), |ui| {
                    ui.label(RichText::new(labels.last().copied().unwrap_or_default()).small());
                });
            });
        });
    });
    set
}
