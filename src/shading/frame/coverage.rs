//! Which triangle is seen at which pixel.

use glam::DVec2;

use super::frame::Frame;

/// No triangle.
pub const NONE: u32 = u32::MAX;

/// The triangle that each pixel shows, row by row from the top left; [`NONE`] where there is only background.
///
/// A pixel belongs to the triangles that hold its centre; one on an edge, to the triangle whose top or left edge it is,
/// as graphics cards have it. Exact: places are multiples of 1/256 pixel, so f64 holds the areas without rounding. Of
/// several the nearest is seen, of equally near ones the first. Depth is affine on the screen.
#[must_use]
pub fn visible(frame: &Frame) -> Vec<u32> {
    let (width, height) = (frame.width as usize, frame.height as usize);
    let mut seen = vec![NONE; width * height];
    let mut nearest = vec![f64::INFINITY; width * height];
    for triangle in 0..frame.triangles.len() {
        let corners = frame.corners(triangle);
        let places = corners.map(|v| v.screen);
        let Some(inside) = Inside::new(places) else { continue };
        let (low, high) = (places[0].min(places[1]).min(places[2]), places[0].max(places[1]).max(places[2]));
        for y in pixels(low.y, high.y, height) {
            for x in pixels(low.x, high.x, width) {
                let Some(w) = inside.weights(DVec2::new(x as f64 + 0.5, y as f64 + 0.5)) else { continue };
                let depth = w[0] * corners[0].depth + w[1] * corners[1].depth + w[2] * corners[2].depth;
                if depth < nearest[y * width + x] {
                    nearest[y * width + x] = depth;
                    seen[y * width + x] = triangle as u32;
                }
            }
        }
    }
    seen
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

/// Whether the surface goes on from one triangle at one pixel to another at its neighbour: they share a corner, or are as
/// far away as their own slopes would have them.
fn is_joined(frame: &Frame, one: usize, other: usize, here: usize, there: usize) -> bool {
    let corners = [one, other].map(|t| frame.triangles[t].vertices);
    if corners[0].iter().any(|vertex| corners[1].contains(vertex)) {
        return true;
    }
    let centre = |pixel: usize| {
        let (x, y) = (pixel % frame.width as usize, pixel / frame.width as usize);
        DVec2::new(x as f64 + 0.5, y as f64 + 0.5)
    };
    let depth = |t: usize, pixel: usize| {
        let weights = frame.weights(t, centre(pixel));
        frame.corners(t).iter().zip(weights).map(|(vertex, weight)| weight * vertex.depth).sum::<f64>()
    };
    let [first, second] = [(one, here), (other, there)].map(|(t, pixel)| depth(t, pixel));
    let [ahead, behind] = [(one, there), (other, here)].map(|(t, pixel)| depth(t, pixel));
    (first - second).abs() <= 2.0 * (first - ahead).abs().max((second - behind).abs())
}

/// The pixels of a row or column of `count` whose centres may lie in `low`…`high`.
fn pixels(low: f64, high: f64, count: usize) -> std::ops::Range<usize> {
    // Casts from f64 saturate, and take NaN for 0.
    (low - 0.5).ceil().max(0.0) as usize..((high + 0.5).floor().max(0.0) as usize).min(count)
}

/// Tells which places a triangle covers.
#[derive(Clone, Copy, Debug)]
pub struct Inside {
    corners: [DVec2; 3],
    area: f64,
    /// Whether each edge is a top or a left one.
    owns: [bool; 3],
}

impl Inside {
    /// Of the triangle with these corners on the screen; `None` if it has no area or looks away.
    #[must_use]
    pub fn new(corners: [DVec2; 3]) -> Option<Inside> {
        let [a, b, c] = corners;
        let area = Frame::area2(a, b, c);
        // Counter-clockwise to the eye and y down: left edges go down, top ones left.
        let owns = [(b, c), (c, a), (a, b)].map(|(from, to)| to.y > from.y || (to.y == from.y && to.x < from.x));
        (area > 0.0).then_some(Inside { corners, area, owns })
    }

    /// The weights of `p`, or `None` if the triangle does not cover it.
    #[must_use]
    pub fn weights(&self, p: DVec2) -> Option<[f64; 3]> {
        let [a, b, c] = self.corners;
        let areas = [Frame::area2(p, b, c), Frame::area2(p, c, a), Frame::area2(p, a, b)];
        let covers = areas.iter().zip(self.owns).all(|(area, owns)| *area > 0.0 || (*area == 0.0 && owns));
        covers.then(|| areas.map(|area| area / self.area))
    }
}
