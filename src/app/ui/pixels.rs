//! Sends codes to the screen. No other module creates textures.
//!
//! A texture that is drawn at physical pixels without filtering or tint reaches the screen byte for byte.

use std::sync::Arc;

use eframe::egui::{self, Color32, ColorImage, Pos2, Rect, Sense, TextureHandle, TextureId, TextureOptions, Vec2};
use rayon::prelude::*;

use super::{text::describe, work::Latest};
use crate::{
    experiment::task::Layout,
    light::{Bits, CodeImage, Quantizer, Transfer},
    stimulus::Stimulus,
};

/// Uploads an image. The screen takes 8 bits; a 16-bit image becomes black.
pub fn texture(ctx: &egui::Context, name: &str, image: &CodeImage) -> TextureHandle {
    let size = [image.width as usize, image.height as usize];
    let pixels = match image.bytes() {
        Some(bytes) => ColorImage::from_rgb(size, bytes),
        None => ColorImage::filled(size, Color32::BLACK),
    };
    load(ctx, name, Arc::new(pixels))
}

/// Uploads pixels that egui draws as they are.
pub fn load(ctx: &egui::Context, name: &str, pixels: Arc<ColorImage>) -> TextureHandle {
    ctx.load_texture(name, pixels, TextureOptions::NEAREST)
}

/// Small pictures of stimuli as on an sRGB display, which are drawn on another thread. They stay until those of another
/// key are ready.
pub struct Drawn<K> {
    work: Latest<K, Vec<CodeImage>>,
    made: Option<(K, Vec<TextureHandle>)>,
}

impl<K> Default for Drawn<K> {
    fn default() -> Self {
        Self { work: Latest::default(), made: None }
    }
}

impl<K: Clone + PartialEq> Drawn<K> {
    /// Returns the key of the pictures that are ready, and the pictures; begins to draw those of `key`, with sides of
    /// `px` physical pixels.
    pub fn get(
        &mut self,
        ctx: &egui::Context,
        key: K,
        px: u32,
        stimuli: impl FnOnce() -> Vec<Stimulus>,
    ) -> Option<&(K, Vec<TextureHandle>)> {
        self.work.want(ctx, key.clone(), || {
            let stimuli = stimuli();
            move || {
                let quantizer = Quantizer::new(&Transfer::Srgb, Bits::Eight);
                Ok(stimuli.par_iter().map(|stimulus| stimulus.codes(px, &quantizer)).collect())
            }
        });
        if let Some(Ok(images)) = self.work.get(&key)
            && self.made.as_ref().is_none_or(|(of, _)| *of != key)
        {
            let textures = images.iter().map(|image| texture(ctx, "drawn", image)).collect();
            self.made = Some((key, textures));
        }
        self.made.as_ref()
    }
}

/// Returns the color of a uniform field of linear light.
pub fn field(quantizer: &Quantizer, light: [f32; 3]) -> Color32 {
    let [r, g, b] = quantizer.codes(light).map(|code| code.min(255) as u8);
    Color32::from_rgb(r, g, b)
}

/// Reserves room for an image on a page and draws it there, pixel for pixel. `label` describes it for screen readers.
pub fn picture(ui: &mut egui::Ui, texture: &TextureHandle, label: &str) -> egui::Response {
    let (rect, response) = ui.allocate_exact_size(texture.size_vec2() / ui.ctx().pixels_per_point(), Sense::hover());
    describe(&response, label);
    draw_centered(ui, texture, rect);
    response
}

/// Returns the place of each stimulus of `side` physical pixels that is shown at the same time, at the center of `area`,
/// row by row.
pub fn places(area: Rect, scale: f32, layout: Layout, side: u32) -> Vec<Rect> {
    let [columns, rows] = layout.grid();
    let pitch = (side + Layout::gap_px(side)) as f32 / scale;
    let from_center = |index: usize, count: usize| pitch * (index as f32 - (count as f32 - 1.0) / 2.0);
    let at = |column, row| area.center() + Vec2::new(from_center(column, columns), from_center(row, rows));
    let place = |column, row| Rect::from_center_size(at(column, row), Vec2::splat(side as f32 / scale));
    (0..rows).flat_map(|row| (0..columns).map(move |column| place(column, row))).collect()
}

/// Draws a texture pixel for pixel, its corner on a whole pixel, centered in `area`.
pub fn draw_centered(ui: &egui::Ui, texture: &TextureHandle, area: Rect) {
    let scale = ui.ctx().pixels_per_point();
    let corner = ((area.min + area.max.to_vec2()).to_vec2() * scale - texture.size_vec2()) / 2.0;
    let place = Rect::from_min_size((corner.floor() / scale).to_pos2(), texture.size_vec2() / scale);
    paint(ui.painter(), texture.id(), place);
}

/// Draws a whole texture.
pub fn paint(painter: &egui::Painter, texture: TextureId, place: Rect) {
    let whole = Rect::from_min_max(Pos2::ZERO, Pos2::new(1.0, 1.0));
    painter.image(texture, place, whole, Color32::WHITE);
}
