//! Sends codes to the screen. No other module creates textures.
//!
//! A texture that is drawn at physical pixels without filtering or tint reaches the screen byte for byte.

use std::sync::Arc;

use eframe::egui::{
    self, Color32, ColorImage, IconData, Pos2, Rect, Sense, TextureHandle, TextureId, TextureOptions, Ui, Vec2,
};
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
                let quantizer = Quantizer::new(&Transfer::Srgb.into(), Bits::Eight);
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

/// The ends of the ramp of the logo, as shares of the width.
const LOGO_RAMP: [f64; 2] = [0.36, 0.64];
/// Codes of the dark area, the bright area, the dark line and the bright line.
const LOGO_CODES: [f64; 4] = [70.0, 190.0, 18.0, 255.0];
/// Standard deviation of a line, as a share of the width.
const LOGO_LINE: f64 = 0.045;

/// Draws the logo, a Mach band as people see it, with the dark and the bright line that are not in the light. It has `side`
/// pixels per side, and is gray beside a stimulus.
fn logo_image(side: usize, gray: bool) -> ColorImage {
    let tint = if gray { [1.0; 3] } else { [1.0, 0.86, 0.22] };
    let color = |x: usize, y: usize| {
        let at = |pixel: usize| (pixel as f64 + 0.5) / side as f64;
        let [from, to] = LOGO_RAMP;
        let [dark, bright, dark_line, bright_line] = LOGO_CODES;
        let line = |place: f64| (-((at(x) - place) / LOGO_LINE).powi(2) / 2.0).exp();
        let ramp = dark + (bright - dark) * ((at(x) - from) / (to - from)).clamp(0.0, 1.0);
        let seen = ramp + (dark_line - dark) * line(from) + (bright_line - bright) * line(to);
        let [r, g, b] = tint.map(|share| (share * seen.clamp(0.0, 255.0)) as u8);
        // A square with round corners, whose edge is smooth.
        let corner = Vec2::new((at(x) - 0.5).abs() as f32, (at(y) - 0.5).abs() as f32) - Vec2::splat(0.3);
        let outside = corner.max(Vec2::ZERO).length() - 0.2;
        let alpha = (0.5 - outside * side as f32).clamp(0.0, 1.0);
        Color32::from_rgba_unmultiplied(r, g, b, (255.0 * alpha) as u8)
    };
    let pixels = (0..side * side).map(|index| color(index % side, index / side)).collect();
    ColorImage::new([side, side], pixels)
}

/// Returns the icon of the window.
pub fn icon() -> IconData {
    let side = 128;
    let rgba = logo_image(side, false).pixels.iter().flat_map(Color32::to_srgba_unmultiplied).collect();
    IconData { rgba, width: side as u32, height: side as u32 }
}

/// Draws the logo with a side of `points`; in gray beside a stimulus.
pub fn logo(ui: &mut Ui, points: f32, gray: bool) {
    let side = (points * ui.ctx().pixels_per_point()).round().max(1.0) as usize;
    let id = egui::Id::unique(("logo", side, gray));
    let texture = ui.data(|data| data.get_temp::<egui::TextureHandle>(id)).unwrap_or_else(|| {
        let texture = ui.ctx().load_texture("logo", logo_image(side, gray), TextureOptions::LINEAR);
        ui.data_mut(|data| data.insert_temp(id, texture.clone()));
        texture
    });
    let (rect, response) = ui.allocate_exact_size(Vec2::splat(points), Sense::hover());
    describe(&response, "machband");
    paint(ui.painter(), texture.id(), rect);
}
