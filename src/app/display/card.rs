//! Measures the screen with a bank card held against it.

use eframe::egui::{self, Color32, Sense, Slider, Stroke, Vec2};

use crate::app::theme;
use crate::display::geometry::{CARD_WIDTH_CM, width_cm_from_card};

/// Height over width of an ISO/IEC 7810 ID-1 card, 53.98 mm by 85.60 mm.
const CARD_ASPECT: f32 = 53.98 / 85.60;

/// The card helper: an outline to be made as large as a card.
pub struct CardHelper {
    card_px: f32,
}

/// How the helper was left.
pub enum CardOutcome {
    /// Still open.
    Open,
    /// Closed without a measurement.
    Closed,
    /// The screen's width in cm.
    Measured(f64),
}

impl CardHelper {
    /// Starts from the outline that the present width would give.
    pub fn new(screen_width_cm: f64, screen_width_px: u32) -> Self {
        let px_per_cm = f64::from(screen_width_px) / screen_width_cm.clamp(1.0, 1000.0);
        Self { card_px: (px_per_cm * CARD_WIDTH_CM) as f32 }
    }

    /// Draws it; physical pixels on both sides of the conversion.
    pub fn show(&mut self, ctx: &egui::Context, screen_width_px: u32) -> CardOutcome {
        let scale = ctx.pixels_per_point();
        let mut outcome = CardOutcome::Open;
        let shown = egui::Modal::new(egui::Id::unique("card")).show(ctx, |ui| {
            ui.set_max_width((ctx.content_rect().width() - 80.0).max(300.0));
            ui.heading("Measure the screen with a card");
            ui.label("Hold a bank card (8.56 cm wide) against the screen and make the outline just as wide. Arrow keys move the slider.");
            let largest = (screen_width_px as f32).min((ctx.content_rect().width() - 120.0) * scale).max(200.0);
            self.card_px = self.card_px.min(largest);
            let label = ui.label("Width of the outline, pixels");
            ui.spacing_mut().slider_width = 360.0;
            ui.add(Slider::new(&mut self.card_px, 100.0..=largest).step_by(1.0)).labelled_by(label.id);
            let size = Vec2::new(self.card_px, self.card_px * CARD_ASPECT) / scale;
            let (rect, _) = ui.allocate_exact_size(size, Sense::hover());
            ui.painter().rect(rect, 10.0, Color32::from_gray(0x3a), Stroke::new(1.0, Color32::WHITE), egui::StrokeKind::Inside);
            match width_cm_from_card(f64::from(self.card_px), screen_width_px) {
                Ok(width) => {
                    ui.label(format!("The screen is {width:.1} cm wide."));
                    ui.horizontal(|ui| {
                        if theme::primary(ui, "Use this width", true, "") {
                            outcome = CardOutcome::Measured((width * 10.0).round() / 10.0);
                        }
                        if ui.button("Cancel").clicked() {
                            outcome = CardOutcome::Closed;
                        }
                    });
                }
                Err(error) => theme::fault(ui, &error.to_string()),
            }
        });
        if shown.should_close() && matches!(outcome, CardOutcome::Open) {
            outcome = CardOutcome::Closed;
        }
        outcome
    }
}
