//! Light and its slope along a line over the picture, taken from the shaders themselves and not from pixels.

use eframe::egui::{self, Pos2};
use egui_plot::{Line, Plot};
use glam::{DVec2, DVec3};

use super::{canvas::COLORS, look::Look, render::Pictures};
use crate::{
    app::theme,
    shading::{Frame, Reference, coverage::Inside},
};

/// Samples a pixel.
const DENSITY: f64 = 4.0;
/// Most samples.
const MOST: f64 = 4096.0;

/// The curves of both sides; each in pieces, since there is none where no surface is.
pub struct Scan {
    edition: u64,
    line: [Pos2; 2],
    light: [Vec<Vec<[f64; 2]>>; 2],
    slope: [Vec<Vec<[f64; 2]>>; 2],
}

impl Scan {
    /// The curves along the look's line; `before` where they are still the same.
    pub fn refreshed(before: Option<Scan>, pictures: &Pictures, look: &Look) -> Scan {
        if let Some(before) = before.filter(|before| before.edition == pictures.edition && before.line == look.line) {
            return before;
        }
        let (frame, compared) = (&pictures.frame, pictures.compared());
        let samples = samples(frame, look.line);
        let light: [Vec<Vec<[f64; 2]>>; 2] = compared.sides.map(|side| {
            let shaded = side.frame(frame, &compared.transfer);
            let reference = Reference::new(&shaded, &side.shade);
            let at = |triangle, w| luminance(side.light(reference.light(triangle, w), &compared.transfer));
            samples.iter().map(|piece| piece.iter().map(|s| [s.px, at(s.triangle, s.weights)]).collect()).collect()
        });
        let slope = light.each_ref().map(|light| light.iter().map(|piece| slopes(piece)).collect());
        Scan { edition: pictures.edition, line: look.line, light, slope }
    }

    /// Draws both plots beside each other in what is left of the page.
    pub fn show(&self, ui: &mut egui::Ui, titles: &[String; 2]) {
        let spacing = ui.spacing().item_spacing.x;
        let size = egui::vec2((ui.available_width() - spacing) / 2.0, ui.available_height());
        ui.horizontal(|ui| {
            for (what, curves) in [("light", &self.light), ("slope, light per pixel", &self.slope)] {
                ui.allocate_ui(size, |ui| plot(ui, what, titles, curves));
            }
        });
    }
}

/// A place of a line on the surface.
struct Sample {
    /// Distance from the line's beginning, pixels.
    px: f64,
    triangle: usize,
    weights: [f64; 3],
}

/// The places of a line where there is surface, in pieces.
fn samples(frame: &Frame, line: [Pos2; 2]) -> Vec<Vec<Sample>> {
    let size = DVec2::new(f64::from(frame.width), f64::from(frame.height));
    let [from, to] = line.map(|end| DVec2::new(f64::from(end.x), f64::from(end.y)) * size);
    let length = from.distance(to);
    let count = (length * DENSITY).clamp(0.0, MOST) as usize;
    let place = |i: usize| from.lerp(to, (i as f64 + 0.5) / count as f64);
    let mut nearest: Vec<Option<(f64, usize, [f64; 3])>> = vec![None; count];
    for triangle in 0..frame.triangles.len() {
        let corners = frame.corners(triangle);
        // Only the samples that the triangle can hold.
        let along = corners.map(|v| (v.screen - from).dot(to - from) / (length * length));
        let across = corners.map(|v| (v.screen - from).perp_dot(to - from));
        if across.iter().all(|a| *a > 0.0) || across.iter().all(|a| *a < 0.0) {
            continue;
        }
        let Some(inside) = Inside::new(corners.map(|v| v.screen)) else { continue };
        let share = |of: f64| (of * count as f64).clamp(0.0, count as f64) as usize;
        let (low, high) = along.iter().fold((f64::INFINITY, 0.0_f64), |(l, h), a| (l.min(*a), h.max(*a)));
        for (i, found) in nearest.iter_mut().enumerate().take((share(high) + 1).min(count)).skip(share(low)) {
            let Some(w) = inside.weights(place(i)) else { continue };
            let depth = w[0] * corners[0].depth + w[1] * corners[1].depth + w[2] * corners[2].depth;
            if found.is_none_or(|(other, ..)| depth < other) {
                *found = Some((depth, triangle, w));
            }
        }
    }
    let mut pieces = vec![Vec::new()];
    for (i, found) in nearest.into_iter().enumerate() {
        match found {
            Some((_, triangle, weights)) => {
                let px = (i as f64 + 0.5) / count as f64 * length;
                if let Some(piece) = pieces.last_mut() {
                    piece.push(Sample { px, triangle, weights });
                }
            }
            None if pieces.last().is_some_and(|piece| !piece.is_empty()) => pieces.push(Vec::new()),
            None => {}
        }
    }
    pieces
}

/// Relative luminance of linear sRGB.
fn luminance(light: DVec3) -> f64 {
    light.dot(DVec3::new(0.2126, 0.7152, 0.0722))
}

fn slopes(piece: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let slope = |pair: &[[f64; 2]]| (pair[1][1] - pair[0][1]) / (pair[1][0] - pair[0][0]);
    piece.windows(2).map(|pair| [(pair[0][0] + pair[1][0]) / 2.0, slope(pair)]).collect()
}

fn plot(ui: &mut egui::Ui, what: &str, titles: &[String; 2], curves: &[Vec<Vec<[f64; 2]>>; 2]) {
    ui.vertical(|ui| {
        ui.label(theme::quiet(format!("{what}, along the scan line from its ring")));
        let plot = Plot::new(what)
            .width(ui.available_width())
            .height(ui.available_height())
            .allow_drag(false)
            .allow_zoom(false)
            .allow_scroll(false)
            .allow_boxed_zoom(false)
            .allow_double_click_reset(false)
            .y_axis_min_width(44.0)
            .show(ui, |plot| {
                for ((pieces, color), title) in curves.iter().zip(COLORS).zip(titles) {
                    for piece in pieces {
                        plot.line(Line::new(title.clone(), piece.clone()).color(color).width(1.5));
                    }
                }
            });
        plot.response.widget_info(|| {
            egui::WidgetInfo::labeled(egui::Role::Image, true, format!("Plot: {what} along the scan line"))
        });
    });
}
