//! The logo: a Mach band as people see it, with the dark and the bright line that are not in the light.

use eframe::egui::{self, Color32, ColorImage, IconData, Sense, TextureOptions, Ui, Vec2};

use super::{pixels::paint, text::describe};

/// The ends of the ramp, as shares of the width.
const RAMP: [f64; 2] = [0.36, 0.64];
/// Codes of the dark area, the bright area, the dark line and the bright line.
const CODES: [f64; 4] = [70.0, 190.0, 18.0, 255.0];
/// Standard deviation of a line, as a share of the width.
const LINE: f64 = 0.045;

/// Draws the logo with `side` pixels per side; in gray beside a stimulus.
fn image(side: usize, gray: bool) -> ColorImage {
    let tint = if gray { [1.0; 3] } else { [1.0, 0.86, 0.22] };
    let color = |x: usize, y: usize| {
        let at = |pixel: usize| (pixel as f64 + 0.5) / side as f64;
        let [from, to] = RAMP;
        let [dark, bright, dark_line, bright_line] = CODES;
        let line = |place: f64| (-((at(x) - place) / LINE).powi(2) / 2.0).exp();
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
    let rgba = image(side, false).pixels.iter().flat_map(Color32::to_srgba_unmultiplied).collect();
    IconData { rgba, width: side as u32, height: side as u32 }
}

/// Draws the logo with a side of `points`; in gray beside a stimulus.
pub fn logo(ui: &mut Ui, points: f32, gray: bool) {
    let side = (points * ui.ctx().pixels_per_point()).round().max(1.0) as usize;
    let id = egui::Id::unique(("logo", side, gray));
    let texture = ui.data(|data| data.get_temp::<egui::TextureHandle>(id)).unwrap_or_else(|| {
        let texture = ui.ctx().load_texture("logo", image(side, gray), TextureOptions::LINEAR);
        ui.data_mut(|data| data.insert_temp(id, texture.clone()));
        texture
    });
    let (rect, response) = ui.allocate_exact_size(Vec2::splat(points), Sense::hover());
    describe(&response, "machband");
    paint(ui.painter(), texture.id(), rect);
}
