//! Light and its slope along a line over the picture, from the shaders themselves and not from pixels.

use eframe::egui::{self, Pos2};
use egui_plot::Line;
use glam::{DVec2, DVec3};

use super::{canvas::ViewSettings, pictures::Pictures};
use crate::app::ui::{describe, hint, still_plot, theme::SIDES};

/// Samples per pixel, and most samples.
const DENSITY: f64 = 4.0;
const MOST: f64 = 4096.0;

/// A curve in pieces, since there is none where there is no surface.
type Curve = Vec<Vec<[f64; 2]>>;

/// The curves of both sides, over pixels from the line's beginning.
pub struct Scan {
    edition: u64,
    line: [Pos2; 2],
    light: [Curve; 2],
    slope: [Curve; 2],
}

impl Scan {
    /// The curves along the scan line, or `before` where they are still right.
    pub fn updated(before: Option<Scan>, pictures: &Pictures, settings: &ViewSettings) -> Scan {
        let line = settings.line;
        if let Some(before) = before.filter(|before| before.edition == pictures.edition && before.line == line) {
            return before;
        }
        let (frame, compared) = (&pictures.frame, &pictures.compared);
        let size = DVec2::new(f64::from(frame.width), f64::from(frame.height));
        let ends = line.map(|end| DVec2::new(f64::from(end.x), f64::from(end.y)) * size);
        let length = ends[0].distance(ends[1]);
        let count = (length * DENSITY).clamp(0.0, MOST) as usize;
        let light = compared.sides.map(|side| {
            let lights = compared.shot(&side, frame).along(ends, count);
            let at = |i: usize, light: DVec3| [(i as f64 + 0.5) / count as f64 * length, luminance(light)];
            let points: Vec<_> = lights.into_iter().enumerate().map(|(i, light)| Some(at(i, light?))).collect();
            let pieces = points.split(Option::is_none).filter(|piece| !piece.is_empty());
            pieces.map(|piece| piece.iter().flatten().copied().collect()).collect::<Curve>()
        });
        let slope = light.each_ref().map(|curve| curve.iter().map(|piece| slopes(piece)).collect());
        Scan { edition: pictures.edition, line, light, slope }
    }

    /// Draws both plots side by side in what is left of the page.
    pub fn show(&self, ui: &mut egui::Ui, titles: &[String; 2]) {
        let spacing = ui.spacing().item_spacing.x;
        let size = egui::vec2((ui.available_width() - spacing) / 2.0, ui.available_height());
        ui.horizontal(|ui| {
            for (what, curves) in [("light", &self.light), ("slope, light per pixel", &self.slope)] {
                ui.allocate_ui(size, |ui| ui.vertical(|ui| plot(ui, what, titles, curves)));
            }
        });
    }
}

/// Relative luminance of linear sRGB.
fn luminance(light: DVec3) -> f64 {
    light.dot(DVec3::new(0.2126, 0.7152, 0.0722))
}

fn slopes(piece: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let slope = |pair: &[[f64; 2]]| (pair[1][1] - pair[0][1]) / (pair[1][0] - pair[0][0]);
    piece.windows(2).map(|pair| [(pair[0][0] + pair[1][0]) / 2.0, slope(pair)]).collect()
}

fn plot(ui: &mut egui::Ui, what: &str, titles: &[String; 2], curves: &[Curve; 2]) {
    hint(ui, format!("{what}, along the scan line from its ring"));
    let plot = still_plot(what).width(ui.available_width()).height(ui.available_height()).y_axis_min_width(44.0);
    let plot = plot.show(ui, |plot| {
        for ((pieces, color), title) in curves.iter().zip(SIDES).zip(titles) {
            for piece in pieces {
                plot.line(Line::new(title.clone(), piece.clone()).color(color).width(1.5));
            }
        }
    });
    describe(&plot.response, &format!("Plot: {what} along the scan line"));
}
