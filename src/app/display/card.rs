//! Measures the screen with a bank card held against it.

use eframe::egui::{self, Id, Key, ScrollArea, Sense, Slider, SliderClamping, Stroke, Vec2};

use crate::{
    app::ui::{
        Step, modal, neutral_primary, secondary, show_error,
        theme::{COLUMN, focus_ring, ink},
    },
    display::geometry::{CARD_WIDTH_CM, width_cm_from_card},
};

/// Height divided by width of an ISO/IEC 7810 ID-1 card, 53.98 mm by 85.60 mm.
const CARD_ASPECT: f32 = 53.98 / 85.60;

/// Width reserved for the slider's number, points.
const NUMBER: f32 = 80.0;
/// Minimum width of the outline, physical pixels.
const MIN_PX: f32 = 100.0;

/// A dialog with an outline that the user adjusts to the size of a card.
pub struct CardHelper {
    card_px: f32,
    /// The slider, once it has been drawn and has keyboard focus.
    slider: Option<Id>,
}

impl CardHelper {
    /// Starts with the outline that matches the current width.
    pub fn new(screen_width_cm: f64, screen_width_px: u32) -> Self {
        let px_per_cm = f64::from(screen_width_px) / screen_width_cm.clamp(1.0, 1000.0);
        Self { card_px: (px_per_cm * CARD_WIDTH_CM) as f32, slider: None }
    }

    /// Draws the dialog if it is open; returns the screen's width in cm when the user accepts it.
    pub fn measured(open: &mut Option<Self>, ctx: &egui::Context, screen_width_px: u32) -> Option<f64> {
        let step = open.as_mut()?.show(ctx, screen_width_px);
        if step != Step::Stay {
            *open = None;
        }
        if let Step::Next(width) = step { Some(width) } else { None }
    }

    fn show(&mut self, ctx: &egui::Context, screen_width_px: u32) -> Step<f64> {
        // Enter accepts the width only if the slider or nothing has keyboard focus. In the number field, it ends
        // typing; on a button, it activates the button.
        let free = ctx.memory(|memory| memory.focused()).is_none_or(|focused| self.slider == Some(focused));
        let accepted = free && self.slider.is_some() && ctx.input(|input| input.key_pressed(Key::Enter));
        let width = COLUMN.max(self.outline(ctx).x);
        let (step, closed) = modal(ctx, "card", width, |ui, height| {
            let scrolling = ScrollArea::vertical().max_height(height).min_scrolled_height(height);
            scrolling.show(ui, |ui| self.content(ui, screen_width_px, accepted)).inner
        });
        if closed && step == Step::Stay { Step::Back } else { step }
    }

    /// Returns the size of the outline in points.
    fn outline(&self, ctx: &egui::Context) -> Vec2 {
        Vec2::new(self.card_px, self.card_px * CARD_ASPECT) / ctx.pixels_per_point()
    }

    fn content(&mut self, ui: &mut egui::Ui, screen_width_px: u32, accepted: bool) -> Step<f64> {
        ui.heading("Measure the screen with a card");
        ui.label(
            "Hold a bank card (8.56 cm wide) against the screen and adjust the outline to the same width with the \
            left and right arrow keys. Press Enter to accept.",
        );
        self.slider(ui, screen_width_px);
        self.draw(ui);
        match width_cm_from_card(f64::from(self.card_px), screen_width_px) {
            Ok(width) => buttons(ui, width, accepted),
            Err(error) => {
                show_error(ui, error);
                Step::Stay
            }
        }
    }

    /// Draws the slider. Its range extends to the width of the whole screen, so that a small window does not limit it.
    fn slider(&mut self, ui: &mut egui::Ui, screen_width_px: u32) {
        let label = ui.label("Width of the outline, pixels");
        ui.spacing_mut().slider_width = (ui.available_width() - NUMBER).clamp(MIN_PX, 360.0);
        let range = MIN_PX..=(screen_width_px as f32).max(2.0 * MIN_PX);
        let slider = Slider::new(&mut self.card_px, range).step_by(1.0).max_decimals(0).clamping(SliderClamping::Edits);
        let slider = ui.add(slider).labelled_by(label.id);
        focus_ring(ui, &slider);
        if self.slider.is_none() {
            slider.request_focus();
            self.slider = Some(slider.id);
        }
    }

    fn draw(&self, ui: &mut egui::Ui) {
        let size = self.outline(ui.ctx());
        if size.x > ui.available_width() {
            ui.label(secondary("The outline is wider than this window. Make the window larger to see all of it."));
        }
        ScrollArea::horizontal().id_salt("outline").show(ui, |ui| {
            let (rect, _) = ui.allocate_exact_size(size, Sense::hover());
            let stroke = Stroke::new(1.0, ink(ui).text);
            ui.painter().rect(rect, 10.0, ink(ui).line, stroke, egui::StrokeKind::Inside);
        });
    }
}

/// Draws the screen's width in cm and the buttons.
fn buttons(ui: &mut egui::Ui, width: f64, accepted: bool) -> Step<f64> {
    ui.label(format!("The screen is {width:.1} cm wide."));
    ui.horizontal_wrapped(|ui| {
        let used = neutral_primary(ui, "Use this width", true, "");
        if ui.button("Cancel").clicked() {
            return Step::Back;
        }
        if used || accepted { Step::Next((width * 10.0).round() / 10.0) } else { Step::Stay }
    })
    .inner
}
