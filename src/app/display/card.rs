//! Measures the screen with a bank card held against it.

use eframe::egui::{self, Id, ScrollArea, Sense, Stroke, TextEdit, Vec2};

use crate::{
    app::ui::{
        Field, Monitor, ScreenFields, Step, modal, neutral_primary, number, secondary, show_error,
        theme::{COLUMN, ink},
    },
    display::geometry::{CARD_WIDTH_CM, width_cm_from_card},
};

/// Height divided by width of an ISO/IEC 7810 ID-1 card, 53.98 mm by 85.60 mm.
const CARD_ASPECT: f32 = 53.98 / 85.60;

/// Width of the label of the slider, and of the slider with its number, points.
const LABEL: f32 = 210.0;
const SLIDER: f32 = 420.0;
/// Minimum width of the outline, physical pixels.
const MIN_PX: f32 = 100.0;

/// A dialog with an outline that the user adjusts to the size of a card.
pub struct CardHelper {
    card_px: f32,
    /// Whether the slider has been drawn, and had the keyboard focus.
    is_shown: bool,
}

impl CardHelper {
    /// Starts with the outline that matches the current width.
    fn new(screen_width_cm: f64, screen_width_px: u32) -> Self {
        let px_per_cm = f64::from(screen_width_px) / screen_width_cm.clamp(1.0, 1000.0);
        Self { card_px: (px_per_cm * CARD_WIDTH_CM) as f32, is_shown: false }
    }

    /// Draws the field for the width of the screen, and the button that opens the dialog.
    pub fn field(open: &mut Option<Self>, ui: &mut egui::Ui, label: Id, fields: &mut ScreenFields, monitor: &Monitor) {
        let assumed = monitor.assumed_width_cm();
        let edit = TextEdit::singleline(&mut fields.screen_width_cm).desired_width(90.0);
        ui.add(edit.hint_text(format!("{assumed:.1}"))).labelled_by(label);
        if ui.button("Measure with a card…").clicked() {
            *open = Some(Self::new(number(&fields.screen_width_cm).unwrap_or(assumed), monitor.width_px));
        }
    }

    /// Draws the dialog if it is open; the width that the user accepts is that of the screen.
    pub fn measure(open: &mut Option<Self>, ctx: &egui::Context, fields: &mut ScreenFields, monitor: &Monitor) {
        let Some(step) = open.as_mut().map(|card| card.show(ctx, monitor.width_px)) else { return };
        if let Step::Next(width) = step {
            fields.screen_width_cm = width.to_string();
        }
        if step != Step::Stay {
            *open = None;
        }
    }

    fn show(&mut self, ctx: &egui::Context, screen_width_px: u32) -> Step<f64> {
        let outline = Vec2::new(self.card_px, self.card_px * CARD_ASPECT) / ctx.pixels_per_point();
        let (step, closed) = modal(ctx, "card", COLUMN.max(outline.x), |ui, height| {
            let scrolling = ScrollArea::vertical().max_height(height).min_scrolled_height(height);
            scrolling.show(ui, |ui| self.content(ui, screen_width_px, outline)).inner
        });
        if closed && step == Step::Stay { Step::Back } else { step }
    }

    fn content(&mut self, ui: &mut egui::Ui, screen_width_px: u32, outline: Vec2) -> Step<f64> {
        ui.heading("Measure the screen with a card");
        ui.label(
            "Hold a bank card (8.56 cm wide) against the screen and adjust the outline to the same width with the \
            left and right arrow keys.",
        );
        // A small window does not limit the outline.
        let range = MIN_PX..=(screen_width_px as f32).max(2.0 * MIN_PX);
        let field = Field::new("Width of the outline, pixels").column(LABEL).width(SLIDER);
        let slider = field.slider(ui, &mut self.card_px, range, 1.0);
        if !std::mem::replace(&mut self.is_shown, true) {
            slider.request_focus();
        }
        if outline.x > ui.available_width() {
            ui.label(secondary("The outline is wider than this window. Make the window larger to see all of it."));
        }
        ScrollArea::horizontal().id_salt("outline").show(ui, |ui| {
            let (rect, _) = ui.allocate_exact_size(outline, Sense::hover());
            let stroke = Stroke::new(1.0, ink(ui).text);
            ui.painter().rect(rect, 10.0, ink(ui).line, stroke, egui::StrokeKind::Inside);
        });
        let found = width_cm_from_card(f64::from(self.card_px), screen_width_px);
        match &found {
            Ok(width) => _ = ui.label(format!("The screen is {width:.1} cm wide.")),
            Err(error) => show_error(ui, error),
        }
        ui.horizontal_wrapped(|ui| {
            let used = neutral_primary(ui, "Use this width", found.is_ok(), "");
            if ui.button("Cancel").clicked() {
                return Step::Back;
            }
            let width = found.ok().filter(|_| used);
            width.map_or(Step::Stay, |width| Step::Next((width * 10.0).round() / 10.0))
        })
        .inner
    }
}
