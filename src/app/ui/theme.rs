//! Colors and sizes of all pages: neutral grays, so that pages between trials do not change the eye's adaptation.

use eframe::egui::{self, Color32, FontId, TextStyle, Vec2, style::HandleShape};
use egui_plot::MarkerShape;

use crate::report::figures::palette::{ON_DARK, Rgb};

/// Color of errors.
pub const ERROR: Color32 = Color32::from_rgb(0xff, 0xa0, 0x80);
/// Color of notes.
pub const NOTE: Color32 = Color32::from_rgb(0xe8, 0xc8, 0x60);
/// Color of success messages and of checks that passed.
pub const SUCCESS: Color32 = Color32::from_rgb(0x90, 0xd0, 0xa0);
/// Color of secondary text; its contrast with the page is 7:1.
pub const SECONDARY: Color32 = Color32::from_gray(0xb4);
pub const PAGE: Color32 = Color32::from_gray(0x22);
/// Maximum width of a line of running text, points.
pub const COLUMN: f32 = 680.0;

/// Colors of the series in a plot: the colors of the figures, adapted to a dark page.
pub const SERIES: [Color32; 7] = {
    let mut colors = [Color32::BLACK; 7];
    let mut index = 0;
    while index < colors.len() {
        let Rgb(r, g, b) = ON_DARK[index];
        colors[index] = Color32::from_rgb(r, g, b);
        index += 1;
    }
    colors
};
/// A different marker for each series, so that readers need not distinguish colors.
pub const MARKERS: [MarkerShape; 7] = [
    MarkerShape::Circle,
    MarkerShape::Square,
    MarkerShape::Diamond,
    MarkerShape::Up,
    MarkerShape::Down,
    MarkerShape::Cross,
    MarkerShape::Plus,
];
/// Colors of the left and right images in a comparison.
pub const SIDES: [Color32; 2] = [SERIES[1], NOTE];

/// Returns the color and marker of a series. Once all colors have been used, they repeat with other markers.
pub fn series(index: usize) -> (Color32, MarkerShape) {
    (SERIES[index % SERIES.len()], MARKERS[(index + index / SERIES.len()) % MARKERS.len()])
}

/// Sets the style of all pages; called once.
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
        // The control with keyboard focus stands out more than the control under the mouse.
        style.visuals.widgets.active.bg_stroke = egui::Stroke::new(2.5, Color32::WHITE);
        style.visuals.widgets.hovered.bg_stroke = egui::Stroke::new(1.0, Color32::from_gray(0xa0));
        style.visuals.selection.bg_fill = Color32::from_rgb(0x4a, 0x5a, 0x80);
        style.visuals.selection.stroke = egui::Stroke::new(2.0, Color32::from_rgb(0xc8, 0xd8, 0xff));
    });
}

/// Uses smaller text and spacing, for pages with many controls.
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
