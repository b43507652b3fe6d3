//! Keys to the colors of the layers.

use eframe::egui::{self, Color32, Label, Rect, Sense, Vec2};

use crate::{
    app::ui::{describe, secondary},
    shading::crease,
};

/// Size of a scale of colors, points.
const SCALE: Vec2 = Vec2::new(120.0, 12.0);
const STEPS: usize = 40;

/// Draws the key to the differences between codes, which are amplified by `factor`.
pub fn difference(ui: &mut egui::Ui, factor: u8) {
    let most = 255_u8.div_ceil(factor.max(1));
    key(ui, "the same code", gray, &format!("{most} codes apart or more"));
}

/// Draws the key to the visible difference from the smooth surface. `full_scale` is the difference with the last color,
/// once it is known.
pub fn visible(ui: &mut egui::Ui, full_scale: Option<f64>) {
    let most = full_scale.map_or_else(String::new, |most| format!("{most:.1} "));
    key(ui, "as the smooth surface", heat, &format!("{most}times the threshold"));
}

fn heat(share: f64) -> Color32 {
    let [r, g, b] = crease::color(share).map(|encoded| (encoded * 255.0).round() as u8);
    Color32::from_rgb(r, g, b)
}

fn gray(share: f64) -> Color32 {
    Color32::from_gray((share * 255.0).round() as u8)
}

/// Draws a scale of colors between the names of its ends.
fn key(ui: &mut egui::Ui, least: &str, color: impl Fn(f64) -> Color32, most: &str) {
    ui.label(secondary(least));
    let (rect, response) = ui.allocate_exact_size(SCALE, Sense::hover());
    describe(&response, &format!("Key: from {least} to {most}"));
    let step = rect.width() / STEPS as f32;
    for i in 0..STEPS {
        let left = rect.left() + step * i as f32;
        let part = Rect::from_x_y_ranges(left..=left + step, rect.y_range());
        ui.painter().rect_filled(part, 0.0, color(i as f64 / (STEPS - 1) as f64));
    }
    // A wider page would change the size of the picture, and thus what is measured.
    ui.add(Label::new(secondary(most)).truncate());
}
