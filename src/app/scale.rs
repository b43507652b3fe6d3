//! The rating scale at the lower edge: the only thing on the screen beside field and stimulus, and it can be hidden.

use eframe::egui::{self, Align2, Area, Color32, Id, RichText};

use crate::experiment::ResponseScale;

/// Draws it; gives the rating that was clicked. `enabled` while there is something to rate.
pub fn show(ctx: &egui::Context, scale: &ResponseScale, enabled: bool) -> Option<u8> {
    let mut rated = None;
    Area::new(Id::unique("scale")).anchor(Align2::CENTER_BOTTOM, [0.0, -10.0]).show(ctx, |ui| {
        egui::Frame::NONE.fill(Color32::from_black_alpha(150)).corner_radius(6.0).inner_margin(6.0).show(ui, |ui| {
            ui.horizontal(|ui| {
                for (rating, category) in (0..).zip(&scale.categories) {
                    let text = RichText::new(format!("{}  {}", category.key, category.label));
                    let button = egui::Button::new(text).frame(enabled);
                    if ui.add_enabled(enabled, button).clicked() {
                        rated = Some(rating);
                    }
                }
            });
        });
    });
    rated
}
