//! Pictures of any shape within a page, pixel for pixel.

use eframe::egui::{self, Pos2, TextureHandle, Vec2};

use crate::app::pixels;

/// Reserves room for a picture of `size` physical pixels, and draws it there byte for byte. `label` tells what it shows
/// to someone who does not see it.
pub fn wide_picture(ui: &mut egui::Ui, texture: &TextureHandle, size: [u32; 2], label: &str) -> egui::Response {
    let scale = ui.ctx().pixels_per_point();
    let points = Vec2::new(size[0] as f32, size[1] as f32) / scale;
    let (rect, response) = ui.allocate_exact_size(points, egui::Sense::hover());
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, label));
    let whole = |at: f32| (at * scale).floor() / scale;
    let min = Pos2::new(whole(rect.min.x), whole(rect.min.y));
    pixels::draw_columns(ui, texture.id(), size, 0..size[0], min);
    response
}
