//! Draws the creases: the color of each edge shows its jump.

use glam::{DVec2, DVec3};

use super::creases::{Creases, EdgeCrease};
use crate::light::{LinearImage, Transfer};
use crate::shading::frame::{Frame, coverage};

/// Half the width of a line in pixels.
const HALF_WIDTH: f64 = 1.0;

/// The background is dark, and the surface a little lighter.
const GROUND: [f64; 3] = [0.05, 0.05, 0.07];
const SURFACE: [f64; 3] = [0.11, 0.11, 0.14];

/// The scale from no jump to the largest, as encoded sRGB: from blue through gray to yellow, with increasing lightness,
/// so that all trichromats and dichromats see the same order.
const MAP: [[f64; 3]; 5] =
    [[0.13, 0.19, 0.42], [0.27, 0.36, 0.58], [0.55, 0.53, 0.52], [0.86, 0.72, 0.33], [1.0, 0.96, 0.62]];

/// Draws the `creases` of `frame` as a picture of the frame's size, in linear light. A jump of `full` (in linear light
/// per pixel) or more gets the last color of the scale; use the same value for pictures that are to be compared. Edges
/// behind a surface are not drawn.
pub fn picture(frame: &Frame, creases: &Creases, full: f64) -> LinearImage {
    let visible = coverage::visible(frame);
    let ground = |triangle: u32| linear(if triangle == coverage::NONE { GROUND } else { SURFACE });
    let mut image =
        LinearImage::from_fn(frame.width, frame.height, |x, y| ground(visible[(y * frame.width + x) as usize]));
    // Draw the strongest edge last, so that it is on top where edges meet.
    let mut order: Vec<&EdgeCrease> = creases.edges.iter().collect();
    order.sort_by(|a, b| a.jump.total_cmp(&b.jump));
    for edge in order {
        let share = if full > 0.0 { edge.jump / full } else { 0.0 };
        draw(&mut image, frame, &visible, edge, linear(color(share)));
    }
    image
}

fn linear(encoded: [f64; 3]) -> [f32; 3] {
    encoded.map(|value| Transfer::Srgb.linear_from_encoded(value) as f32)
}

/// Returns the color of a jump that is this share of the largest, as encoded sRGB.
pub fn color(share: f64) -> [f64; 3] {
    let at = share.clamp(0.0, 1.0) * (MAP.len() - 1) as f64;
    let low = (at as usize).min(MAP.len() - 2);
    let (a, b) = (DVec3::from_array(MAP[low]), DVec3::from_array(MAP[low + 1]));
    a.lerp(b, at - low as f64).to_array()
}

/// Draws the line of one edge, antialiased by the share of a pixel's width that it covers.
fn draw(image: &mut LinearImage, frame: &Frame, visible: &[u32], edge: &EdgeCrease, color: [f32; 3]) {
    let [a, b] = edge.ends.map(|v| frame.vertices[v as usize].screen);
    let reach = DVec2::splat(HALF_WIDTH + 1.0);
    let (low, high) = (a.min(b) - reach, a.max(b) + reach);
    // The cast saturates and turns NaN into 0.
    let pixels = |low: f64, high: f64, size: u32| (low.max(0.0) as u32).min(size)..(high.max(0.0) as u32).min(size);
    for y in pixels(low.y, high.y, frame.height) {
        for x in pixels(low.x, high.x, frame.width) {
            let center = DVec2::new(f64::from(x), f64::from(y)) + 0.5;
            let along = ((center - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
            let nearest = a + along * (b - a);
            let cover = (HALF_WIDTH + 0.5 - center.distance(nearest)).clamp(0.0, 1.0) as f32;
            // One of the triangles is visible within a pixel.
            let is_seen = || coverage::around(frame, nearest).any(|pixel| edge.triangles.contains(&visible[pixel]));
            if cover > 0.0 && is_seen() {
                let under = image.pixel(x, y);
                image.set_pixel(x, y, [0, 1, 2].map(|c| under[c] + cover * (color[c] - under[c])));
            }
        }
    }
}
