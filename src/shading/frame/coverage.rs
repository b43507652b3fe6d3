//! Which triangle is seen at which pixel.

use glam::DVec2;

use super::{outline::Outline, planes::Planes, projected::Frame};

/// No triangle.
pub const NONE: u32 = u32::MAX;

/// The triangle that each pixel shows, row by row from the top left; [`NONE`] where there is only background.
///
/// A pixel belongs to the triangles whose [`Outline`]s hold it. Of several the nearest is seen, of equally near ones the
/// first. Depth is affine on the screen.
#[must_use]
pub fn visible(frame: &Frame) -> Vec<u32> {
    let (width, height) = (frame.width as usize, frame.height as usize);
    let mut seen = vec![NONE; width * height];
    let mut nearest = vec![f64::INFINITY; width * height];
    for triangle in 0..frame.triangles.len() {
        let corners = frame.corners(triangle).map(|v| v.screen);
        let Some(outline) = Outline::new(corners, frame.width, frame.height) else { continue };
        let depths = depths(frame, triangle);
        outline.each_span(outline.first..outline.end, frame.width, |y, (left, right)| {
            for x in left..right {
                let (at, [depth]) = (y as usize * width + x as usize, depths.at(x, y).0);
                if depth < nearest[at] {
                    (nearest[at], seen[at]) = (depth, triangle as u32);
                }
            }
        });
    }
    seen
}

/// The depths of a triangle.
#[must_use]
pub fn depths(frame: &Frame, triangle: usize) -> Planes<1> {
    let corners = frame.corners(triangle);
    Planes::new(corners.map(|v| v.screen), corners.map(|v| [v.depth]))
}

/// Whether each pixel shows the surface and lies on none of its outlines: beside the background, or where a nearer part
/// of the surface hides a farther one.
#[must_use]
pub fn inside_outlines(frame: &Frame) -> Vec<bool> {
    let (width, height) = (frame.width as usize, frame.height as usize);
    let seen = visible(frame);
    let mut inside: Vec<bool> = seen.iter().map(|triangle| *triangle != NONE).collect();
    let mut split = |a: usize, b: usize| {
        let (one, other) = (seen[a], seen[b]);
        if one == other || one != NONE && other != NONE && is_joined(frame, one as usize, other as usize, a, b) {
            return;
        }
        (inside[a], inside[b]) = (false, false);
    };
    for y in 0..height {
        for x in 0..width {
            let here = y * width + x;
            if x + 1 < width {
                split(here, here + 1);
            }
            if y + 1 < height {
                split(here, here + width);
            }
        }
    }
    inside
}

/// Whether the surface continues from one triangle at one pixel to another at its neighbor: they share a corner, or their
/// depths agree with their own slopes.
fn is_joined(frame: &Frame, one: usize, other: usize, here: usize, there: usize) -> bool {
    let corners = [one, other].map(|t| frame.triangles[t].vertices);
    if corners[0].iter().any(|vertex| corners[1].contains(vertex)) {
        return true;
    }
    let center = |pixel: usize| {
        let (x, y) = (pixel % frame.width as usize, pixel / frame.width as usize);
        DVec2::new(x as f64 + 0.5, y as f64 + 0.5)
    };
    let depth = |t: usize, pixel: usize| {
        let weights = frame.weights(t, center(pixel));
        frame.corners(t).iter().zip(weights).map(|(vertex, weight)| weight * vertex.depth).sum::<f64>()
    };
    let [first, second] = [(one, here), (other, there)].map(|(t, pixel)| depth(t, pixel));
    let [ahead, behind] = [(one, there), (other, here)].map(|(t, pixel)| depth(t, pixel));
    (first - second).abs() <= 2.0 * (first - ahead).abs().max((second - behind).abs())
}
