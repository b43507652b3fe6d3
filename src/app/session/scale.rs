//! The rating scale at the lower edge: the only thing on the screen beside field and stimulus, and it can be hidden.

use eframe::egui::{self, Align2, Area, Button, Color32, Id, RichText, Vec2};

use crate::experiment::ResponseScale;

/// Widest button, points.
const WIDEST: f32 = 250.0;
/// Between two buttons, points.
const GAP: f32 = 6.0;
/// Below this width a label would be cut: the key alone says more.
const NARROWEST: f32 = 100.0;

/// Draws it; gives the rating that was clicked. `enabled` while there is something to rate.
pub fn show(ctx: &egui::Context, scale: &ResponseScale, enabled: bool) -> Option<u8> {
    let mut rated = None;
    let count = scale.categories.len().max(1) as f32;
    let width = ((ctx.content_rect().width() - 40.0) / count - GAP).min(WIDEST);
    Area::new(Id::unique("scale")).anchor(Align2::CENTER_BOTTOM, [0.0, -8.0]).show(ctx, |ui| {
        egui::Frame::NONE.fill(Color32::from_black_alpha(150)).corner_radius(6.0).inner_margin(6.0).show(ui, |ui| {
            ui.spacing_mut().item_spacing.x = GAP;
            ui.spacing_mut().button_padding = Vec2::new(6.0, 4.0);
            ui.horizontal(|ui| {
                for (rating, category) in (0..).zip(&scale.categories) {
                    let text = match width < NARROWEST {
                        true => category.key.to_string(),
                        false => format!("{}  {}", category.key, category.label),
                    };
                    let button = Button::new(RichText::new(text).small()).frame(enabled).wrap();
                    // Two lines where a label may need them, the same for all.
                    let height = if (NARROWEST..WIDEST).contains(&width) { 46.0 } else { ui.spacing().interact_size.y };
                    let size = Vec2::new(width.max(height), height);
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
