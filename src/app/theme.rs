//! One look for all pages: neutral greys, so that pages between trials leave the eye's adaptation alone.

use eframe::egui::{self, Color32, FontId, RichText, TextStyle, Vec2, style::HandleShape};

/// What is wrong.
pub const FAULT: Color32 = Color32::from_rgb(0xff, 0xa0, 0x80);
/// What is worth knowing.
pub const NOTE: Color32 = Color32::from_rgb(0xe8, 0xc8, 0x60);
/// What is well.
pub const GOOD: Color32 = Color32::from_rgb(0x90, 0xd0, 0xa0);
/// Secondary text; 7:1 on the page.
pub const QUIET: Color32 = Color32::from_gray(0xb4);
/// The page.
pub const PAGE: Color32 = Color32::from_gray(0x22);
/// Widest line of running text, points.
pub const COLUMN: f32 = 680.0;

/// Sets the look once.
pub fn apply(ctx: &egui::Context) {
    ctx.set_theme(egui::Theme::Dark);
    ctx.all_styles_mut(|style| {
        style.text_styles = [
            (TextStyle::Heading, 28.0),
            (TextStyle::Body, 17.0),
            (TextStyle::Button, 17.0),
            (TextStyle::Small, 14.0),
            (TextStyle::Monospace, 15.0),
        ]
        .map(|(name, size)| {
            let family =
                if name == TextStyle::Monospace { egui::FontFamily::Monospace } else { egui::FontFamily::Proportional };
            (name, FontId::new(size, family))
        })
        .into();
        style.spacing.item_spacing = Vec2::new(10.0, 8.0);
        style.spacing.button_padding = Vec2::new(12.0, 6.0);
        style.spacing.interact_size.y = 32.0;
        style.spacing.text_edit_width = 300.0;
        style.visuals.panel_fill = Color32::TRANSPARENT;
        style.visuals.window_fill = Color32::from_gray(0x2c);
        style.visuals.extreme_bg_color = Color32::from_gray(0x14);
        style.visuals.override_text_color = Some(Color32::from_gray(0xec));
        style.visuals.handle_shape = HandleShape::Circle;
        style.visuals.widgets.inactive.bg_fill = Color32::from_gray(0x48);
        style.visuals.widgets.inactive.weak_bg_fill = Color32::from_gray(0x40);
        style.visuals.widgets.inactive.bg_stroke = egui::Stroke::new(1.0, Color32::from_gray(0x68));
        // What has the keyboard's focus stands out; what the mouse is over, less.
        style.visuals.widgets.active.bg_stroke = egui::Stroke::new(2.5, Color32::WHITE);
        style.visuals.widgets.hovered.bg_stroke = egui::Stroke::new(1.0, Color32::from_gray(0xa0));
        style.visuals.selection.bg_fill = Color32::from_rgb(0x4a, 0x5a, 0x80);
        style.visuals.selection.stroke = egui::Stroke::new(2.0, Color32::from_rgb(0xc8, 0xd8, 0xff));
    });
}

/// A page's name and the way back from it: gives whether that is taken.
pub fn heading(ui: &mut egui::Ui, name: &str) -> bool {
    ui.horizontal(|ui| {
        ui.heading(name);
        let back = ui.button("Back").clicked();
        ui.label(quiet("Esc"));
        back
    })
    .inner
}

/// Smaller than on other pages: there is much to set and to see.
pub fn compact(ui: &mut egui::Ui) {
    let style = ui.style_mut();
    for (name, size) in [(TextStyle::Body, 15.0), (TextStyle::Button, 15.0), (TextStyle::Small, 13.0)] {
        if let Some(font) = style.text_styles.get_mut(&name) {
            font.size = size;
        }
    }
    style.spacing.item_spacing = Vec2::new(8.0, 5.0);
    style.spacing.button_padding = Vec2::new(8.0, 3.0);
    style.spacing.interact_size.y = 26.0;
}

/// The button that a page leads to, and a word about its keys beside it.
pub fn primary(ui: &mut egui::Ui, text: &str, enabled: bool, hint: &str) -> bool {
    let button = egui::Button::new(RichText::new(text).size(19.0).strong().color(Color32::BLACK))
        .fill(Color32::from_rgb(0xe8, 0xd0, 0x70))
        .min_size(Vec2::new(180.0, 44.0));
    ui.horizontal(|ui| {
        let clicked = ui.add_enabled(enabled, button).clicked();
        if !hint.is_empty() {
            ui.add(egui::Label::new(quiet(hint)).wrap());
        }
        clicked
    })
    .inner
}

/// A mark before a finding: a tick, or an exclamation mark. Painted, since not every font has one.
pub fn mark(ui: &mut egui::Ui, good: bool) {
    let (rect, _) = ui.allocate_exact_size(Vec2::splat(18.0), egui::Sense::hover());
    let at = |x: f32, y: f32| rect.lerp_inside(Vec2::new(x, y));
    let stroke = egui::Stroke::new(2.5, if good { GOOD } else { NOTE });
    if good {
        ui.painter().line(vec![at(0.1, 0.55), at(0.4, 0.85), at(0.9, 0.2)], stroke);
    } else {
        ui.painter().line_segment([at(0.5, 0.1), at(0.5, 0.62)], stroke);
        ui.painter().circle_filled(at(0.5, 0.88), 2.0, NOTE);
    }
}

/// Secondary text.
pub fn quiet(text: impl Into<String>) -> RichText {
    RichText::new(text).small().color(QUIET)
}

/// A fault beside its field.
pub fn fault(ui: &mut egui::Ui, text: &str) {
    ui.add(egui::Label::new(RichText::new(text).small().color(FAULT)).wrap());
}

/// A page with a centred column, a little below the top, that scrolls where the window is small.
pub fn page<R>(ui: &mut egui::Ui, add: impl FnOnce(&mut egui::Ui) -> R) -> R {
    page_from(ui, 0.18, add)
}

/// A page that begins below this share of the window's height.
pub fn page_from<R>(ui: &mut egui::Ui, top: f32, add: impl FnOnce(&mut egui::Ui) -> R) -> R {
    egui::CentralPanel::default()
        .frame(egui::Frame::NONE.inner_margin(24.0))
        .show(ui, |ui| {
            egui::ScrollArea::vertical()
                .auto_shrink(false)
                .show(ui, |ui| {
                    let width = ui.available_width().min(COLUMN);
                    let margin = (ui.available_width() - width) / 2.0;
                    // A small window has no room to give away.
                    let spare = ui.available_height() - 560.0;
                    ui.add_space((ui.available_height() * top).min(spare.max(0.0)));
                    ui.horizontal(|ui| {
                        ui.add_space(margin);
                        ui.vertical(|ui| {
                            ui.set_width(width);
                            add(ui)
                        })
                        .inner
                    })
                    .inner
                })
                .inner
        })
        .inner
}
