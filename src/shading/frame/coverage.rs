//! The pixels that a triangle covers, and the visible triangle at each pixel.

use std::ops::Range;

use glam::DVec2;

use super::projected::{Frame, Side};
use crate::system::checkpoint;

/// The index that stands for no triangle.
pub const NONE: u32 = u32::MAX;

/// Returns the triangle that each pixel shows, row by row from the top left; [`NONE`] where there is only background.
///
/// A pixel belongs to the triangles whose [`Outline`]s contain it. The nearest triangle is visible; in a tie, the first
/// one is.
pub fn visible(frame: &Frame) -> Vec<u32> {
    visible_in(frame, &outlines(frame), 0..frame.view.height)
}

/// Returns [`visible`] for some rows only.
pub(crate) fn visible_in(frame: &Frame, outlines: &[Option<Outline>], rows: Range<u32>) -> Vec<u32> {
    let pixels = rows.len() * frame.view.width as usize;
    let (mut seen, mut nearest) = (vec![NONE; pixels], vec![f64::INFINITY; pixels]);
    each_layer(frame, outlines, rows, |triangle, at, depth| {
        if depth < nearest[at] {
            (nearest[at], seen[at]) = (depth, triangle as u32);
        }
    });
    seen
}

/// Returns the outlines of all triangles.
pub(crate) fn outlines(frame: &Frame) -> Vec<Option<Outline>> {
    frame.each_triangle(|t| Outline::new(frame.corners(t).map(|v| v.screen), frame.view.width, frame.view.height))
}

/// Calls `of` with every triangle, in order, and every pixel that it covers in `rows`: the pixel's index from the first
/// of these rows, and its depth.
pub(crate) fn each_layer(
    frame: &Frame,
    outlines: &[Option<Outline>],
    rows: Range<u32>,
    mut of: impl FnMut(usize, usize, f64),
) {
    for (triangle, outline) in outlines.iter().enumerate() {
        checkpoint();
        let Some(outline) = outline else { continue };
        let within = outline.first.max(rows.start)..outline.end.min(rows.end);
        if within.is_empty() {
            continue;
        }
        for y in within {
            let row = (y - rows.start) as usize * frame.view.width as usize;
            for x in outline.span(y, frame.view.width) {
                let center = DVec2::new(f64::from(x), f64::from(y)) + 0.5;
                of(triangle, row + x as usize, frame.depth(triangle, frame.weights(triangle, center)));
            }
        }
    }
}

/// For each pixel, returns true if it shows the surface and lies neither on an outline nor at an edge at which the
/// surface is meant to have a crease. Outlines run along the background and where a nearer part of the surface hides a
/// farther part.
pub fn interior_mask(frame: &Frame) -> Vec<bool> {
    let seen = visible(frame);
    let mut inside: Vec<bool> = seen.iter().map(|triangle| *triangle != NONE).collect();
    for (a, b) in neighbors(frame) {
        let (one, other) = (seen[a], seen[b]);
        if one != other && (one == NONE || other == NONE || !is_joined(frame, one as usize, other as usize, a, b)) {
            (inside[a], inside[b]) = (false, false);
        }
    }
    for Side { triangle, corner } in &frame.creases {
        let corners = frame.corners(*triangle as usize);
        let [a, b] = [1, 2].map(|end| corners[(*corner as usize + end) % 3].screen);
        // Half a pixel per step.
        let steps = (2.0 * a.distance(b)).ceil().max(1.0);
        for step in 0..=steps as usize {
            let around = around(frame, a.lerp(b, step as f64 / steps));
            if around.clone().any(|pixel| seen[pixel] == *triangle) {
                around.for_each(|pixel| inside[pixel] = false);
            }
        }
    }
    inside
}

/// Returns each pixel of the frame with the one to its right, and with the one below, as indices.
pub(crate) fn neighbors(frame: &Frame) -> impl Iterator<Item = (usize, usize)> + use<> {
    let (width, count) = (frame.view.width as usize, frame.view.width as usize * frame.view.height as usize);
    let of = move |here: usize| {
        let [right, below] = [here + 1, here + width];
        let right = (!right.is_multiple_of(width)).then_some((here, right));
        right.into_iter().chain((below < count).then_some((here, below)))
    };
    (0..count).flat_map(of)
}

/// Returns the pixels of the frame that are at most one pixel from the pixel at `place`, as indices.
pub(crate) fn around(frame: &Frame, place: DVec2) -> impl Iterator<Item = usize> + Clone + use<> {
    let range = |at: f64, size: u32| (at.floor() as i64 - 1).max(0)..(at.floor() as i64 + 2).min(size.into());
    let (columns, width) = (range(place.x, frame.view.width), i64::from(frame.view.width));
    range(place.y, frame.view.height).flat_map(move |y| columns.clone().map(move |x| (y * width + x) as usize))
}

/// True if the surface continues from triangle `one` at pixel `here` to triangle `other` at the neighboring pixel
/// `there`: the triangles share a corner, or their depths differ by no more than their slopes explain.
fn is_joined(frame: &Frame, one: usize, other: usize, here: usize, there: usize) -> bool {
    let corners = [one, other].map(|t| frame.triangles[t].vertices);
    if corners[0].iter().any(|vertex| corners[1].contains(vertex)) {
        return true;
    }
    let depth = |t: usize, pixel: usize| frame.depth(t, frame.weights(t, frame.view.center(pixel)));
    let [first, second] = [(one, here), (other, there)].map(|(t, pixel)| depth(t, pixel));
    let [ahead, behind] = [(one, there), (other, here)].map(|(t, pixel)| depth(t, pixel));
    (first - second).abs() <= 2.0 * (first - ahead).abs().max((second - behind).abs())
}

/// More than the rounding errors of f64, and less than 2⁻³¹ px, the smallest nonzero distance of an edge from a pixel
/// center: positions are multiples of 1/256 px and below 2¹⁵ px.
const ROUNDING: f64 = 1.0 / (1u64 << 33) as f64;

/// A triangle as rows of pixels. It contains exactly the pixels whose centers lie inside or on a left or top edge, as
/// on graphics cards.
#[derive(Clone, Copy, Debug)]
pub struct Outline {
    /// The first row within the window; `end` is the row after the last.
    pub first: u32,
    pub end: u32,
    /// The sides that bound the triangle on the left, at most two; `right` has the sides that bound it on the right.
    left: [Slope; 2],
    right: [Slope; 2],
}

/// A side of a triangle. At the height of a row's pixel centers, it is in column `x + (row − y)·slope`, in pixels from
/// the center of the first pixel.
#[derive(Clone, Copy, Debug)]
struct Slope {
    x: f64,
    y: f64,
    slope: f64,
}

/// Returns the first pixel, at most `count`, whose center is at or beyond a place in pixels from the center of the first.
fn first_pixel(place: f64, count: u32) -> u32 {
    // Casts from f64 saturate and turn NaN into 0.
    ((place - ROUNDING).ceil() as u32).min(count)
}

impl Outline {
    /// Makes the outline of the triangle with these corners in a window of `width` × `height` pixels; `None` if the
    /// triangle faces away or if its bounding box contains no pixel center of the window.
    pub fn new(corners: [DVec2; 3], width: u32, height: u32) -> Option<Outline> {
        let [a, b, c] = corners;
        let (low, high) = (a.min(b).min(c) - 0.5, a.max(b).max(c) - 0.5);
        let (first, end) = (first_pixel(low.y, height), first_pixel(high.y, height));
        let is_narrow = first_pixel(low.x, width) >= first_pixel(high.x, width);
        if first >= end || is_narrow || Frame::area2(a, b, c) <= 0.0 {
            return None;
        }
        let open = |x| Slope { x, y: 0.0, slope: 0.0 };
        let mut outline = Outline { first, end, left: [open(f64::NEG_INFINITY); 2], right: [open(f64::INFINITY); 2] };
        let (mut lefts, mut rights) = (0, 0);
        // The corners are counterclockwise for the viewer, and y points down, so left edges go down. Horizontal edges
        // bound neither the left nor the right.
        for (from, to) in [(b, c), (c, a), (a, b)] {
            if from.y < to.y {
                outline.left[lefts] = Slope::new(from, to);
                lefts += 1;
            } else if to.y < from.y {
                outline.right[rights] = Slope::new(to, from);
                rights += 1;
            }
        }
        Some(outline)
    }

    /// Returns the pixels of a row, which must be within the outline.
    fn span(&self, row: u32, width: u32) -> Range<u32> {
        let [left, right] = [self.left, self.right].map(|sides| sides.map(|side| side.at(row.into())));
        first_pixel(left[0].max(left[1]), width)..first_pixel(right[0].min(right[1]), width)
    }
}

impl Slope {
    fn new(top: DVec2, bottom: DVec2) -> Slope {
        Slope { x: top.x - 0.5, y: top.y - 0.5, slope: (bottom.x - top.x) / (bottom.y - top.y) }
    }

    fn at(&self, row: f64) -> f64 {
        self.x + (row - self.y) * self.slope
    }
}
