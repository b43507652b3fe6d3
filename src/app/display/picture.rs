//! Pictures of any shape within a page, pixel for pixel.

use eframe::egui::{self, TextureHandle};

use crate::app::pixels;

/// As [`pixels::picture`].
pub fn wide_picture(ui: &mut egui::Ui, texture: &TextureHandle, _: [u32; 2], label: &str) -> egui::Response {
    pixels::picture(ui, texture, label)
}
