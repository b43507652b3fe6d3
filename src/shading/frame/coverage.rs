//! The pixels that a triangle covers, and the visible triangle at each pixel.

use std::ops::Range;

use glam::DVec2;

use super::projected::Frame;
use crate::system::checkpoint;

/// The index that stands for no triangle.
pub const NONE: u32 = u32::MAX;

/// Returns the triangle that each pixel shows, row by row from the top left; [`NONE`] where there is only background.
///
/// A pixel belongs to the triangles whose [`Outline`]s contain it. The nearest triangle is visible; in a tie, the first
/// one is. Depth is affine on the screen.
pub fn visible(frame: &Frame) -> Vec<u32> {
    let (width, height) = (frame.width as usize, frame.height as usize);
    let mut seen = vec![NONE; width * height];
    let mut nearest = vec![f64::INFINITY; width * height];
    each_layer(frame, &outlines(frame), 0..frame.height, |triangle, at, depth| {
        if depth < nearest[at] {
            (nearest[at], seen[at]) = (depth, triangle as u32);
        }
    });
    seen
}

/// Returns the outlines of all triangles.
pub(crate) fn outlines(frame: &Frame) -> Vec<Option<Outline>> {
    frame.each_triangle(|t| Outline::new(frame.corners(t).map(|v| v.screen), frame.width, frame.height))
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
        let depths = depths(frame, triangle);
        outline.each_span(within, frame.width, |y, (left, right)| {
            let row = (y - rows.start) as usize * frame.width as usize;
            for x in left..right {
                of(triangle, row + x as usize, depths.at(x, y).0[0]);
            }
        });
    }
}

/// Returns the depths of a triangle as a plane.
pub fn depths(frame: &Frame, triangle: usize) -> Planes<1> {
    let corners = frame.corners(triangle);
    Planes::new(corners.map(|v| v.screen), corners.map(|v| [v.depth]))
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
    for crease in &frame.creases {
        let [a, b] = crease.ends.map(|v| frame.vertices[v as usize].screen);
        // Half a pixel per step.
        let steps = (2.0 * a.distance(b)).ceil().max(1.0);
        for step in 0..=steps as usize {
            let around = around(frame, a.lerp(b, step as f64 / steps));
            if around.clone().any(|pixel| seen[pixel] == crease.triangle) {
                around.for_each(|pixel| inside[pixel] = false);
            }
        }
    }
    inside
}

/// Returns each pixel of the frame with the one to its right, and with the one below, as indices.
pub(crate) fn neighbors(frame: &Frame) -> impl Iterator<Item = (usize, usize)> + use<> {
    let (width, count) = (frame.width as usize, frame.width as usize * frame.height as usize);
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
    let (columns, width) = (range(place.x, frame.width), i64::from(frame.width));
    range(place.y, frame.height).flat_map(move |y| columns.clone().map(move |x| (y * width + x) as usize))
}

/// True if the surface continues from triangle `one` at pixel `here` to triangle `other` at the neighboring pixel
/// `there`: the triangles share a corner, or their depths differ by no more than their slopes explain.
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

/// The number of rows that are computed at once.
const ROWS: usize = 8;

/// Slightly less than half a pixel. The difference is far larger than the rounding errors of f64 and far smaller than
/// 2⁻³¹ px, the smallest nonzero distance of an edge from a pixel center: positions are multiples of 1/256 px and below
/// 2¹⁵ px.
const NEARLY_HALF: f64 = 0.5 - 1.0 / (1u64 << 33) as f64;

/// Adding this to a number below 2⁵¹ rounds the number to the nearest whole number and moves it into the lowest bits.
const TO_WHOLE: f64 = 1.5 * (1u64 << 52) as f64;

/// A triangle as rows of pixels. It contains exactly the pixels whose centers lie inside or on a left or top edge, as
/// on graphics cards.
#[derive(Clone, Copy, Debug)]
pub struct Outline {
    /// The first row within the window; `end` is the row after the last.
    pub first: u32,
    pub end: u32,
    /// The sides that bound the triangle on the left, at most two; `right` has the sides that bound it on the right.
    left: [Side; 2],
    right: [Side; 2],
}

/// A side of a triangle. At the height of a row's pixel centers, it is in column `x + (row − y)·slope`, in pixels from
/// the center of the first pixel.
#[derive(Clone, Copy, Debug)]
struct Side {
    x: f64,
    y: f64,
    slope: f64,
}

/// Returns the first pixel whose center is at or beyond `place`, at most `count`.
fn first_center(place: f64, count: u32) -> u32 {
    // Casts from f64 saturate and turn NaN into 0.
    ((place - 0.5).ceil() as u32).min(count)
}

impl Outline {
    /// Makes the outline of the triangle with these corners in a window of `width` × `height` pixels; `None` if the
    /// triangle faces away or if its bounding box contains no pixel center of the window.
    pub fn new(corners: [DVec2; 3], width: u32, height: u32) -> Option<Outline> {
        let [a, b, c] = corners;
        let (low, high) = (a.min(b).min(c), a.max(b).max(c));
        let (first, end) = (first_center(low.y, height), first_center(high.y, height));
        let is_narrow = first_center(low.x, width) >= first_center(high.x, width);
        if first >= end || is_narrow || Frame::area2(a, b, c) <= 0.0 {
            return None;
        }
        let open = |x| Side { x, y: 0.0, slope: 0.0 };
        let mut outline = Outline { first, end, left: [open(f64::NEG_INFINITY); 2], right: [open(f64::INFINITY); 2] };
        let (mut lefts, mut rights) = (0, 0);
        // The corners are counterclockwise for the viewer, and y points down, so left edges go down. Horizontal edges
        // bound neither the left nor the right.
        for (from, to) in [(b, c), (c, a), (a, b)] {
            if from.y < to.y {
                outline.left[lefts] = Side::new(from, to);
                lefts += 1;
            } else if to.y < from.y {
                outline.right[rights] = Side::new(to, from);
                rights += 1;
            }
        }
        Some(outline)
    }

    /// Calls `of` with each row of `rows`, its first pixel, and the pixel after its last. The rows must be within the
    /// outline.
    #[inline(always)]
    pub fn each_span(&self, rows: Range<u32>, width: u32, mut of: impl FnMut(u32, (u32, u32))) {
        let width = f64::from(width);
        for block in rows.clone().step_by(ROWS) {
            let (mut left, mut right) = ([0; ROWS], [0; ROWS]);
            for i in 0..ROWS {
                let y = f64::from(block) + i as f64;
                let [a, b] = [self.left[0].at(y), self.left[1].at(y)];
                left[i] = center(if a > b { a } else { b }, width);
                let [a, b] = [self.right[0].at(y), self.right[1].at(y)];
                right[i] = center(if a < b { a } else { b }, width);
            }
            for (i, row) in (block..rows.end).take(ROWS).enumerate() {
                of(row, (left[i], right[i]));
            }
        }
    }
}

/// Returns `x` rounded up to a whole number and clamped to 0…`width`.
#[inline(always)]
fn center(x: f64, width: f64) -> u32 {
    let x = if x > 0.0 { x } else { 0.0 };
    let x = if x < width { x } else { width };
    ((x + NEARLY_HALF) + TO_WHOLE).to_bits() as u32
}

impl Side {
    fn new(top: DVec2, bottom: DVec2) -> Side {
        Side { x: top.x - 0.5, y: top.y - 0.5, slope: (bottom.x - top.x) / (bottom.y - top.y) }
    }

    #[inline(always)]
    fn at(&self, row: f64) -> f64 {
        self.x + (row - self.y) * self.slope
    }
}

/// `Q` quantities of one triangle that are affine on the screen. They are recomputed for every row in f64, so that long
/// thin triangles lose no precision; along a row, f32 is sufficient.
#[derive(Clone, Copy, Debug)]
pub struct Planes<const Q: usize> {
    /// A corner, measured from the center of the first pixel.
    origin: DVec2,
    /// The quantities at that corner.
    at: [f64; Q],
    right: [f64; Q],
    down: [f64; Q],
}

impl<const Q: usize> Planes<Q> {
    /// Planes that are 0 everywhere.
    pub const ZERO: Self = Planes { origin: DVec2::ZERO, at: [0.0; Q], right: [0.0; Q], down: [0.0; Q] };

    /// Makes the planes through the `values` of a triangle's corners.
    pub fn new([a, b, c]: [DVec2; 3], values: [[f64; Q]; 3]) -> Self {
        let per_area = 1.0 / Frame::area2(a, b, c);
        let slope = |from: DVec2, to: DVec2| DVec2::new(to.y - from.y, from.x - to.x) * per_area;
        let (to_b, to_c) = (slope(c, a), slope(a, b));
        let mut planes = Planes { origin: a - 0.5, at: values[0], ..Planes::ZERO };
        for (q, start) in values[0].iter().enumerate() {
            let slope = to_b * (values[1][q] - start) + to_c * (values[2][q] - start);
            (planes.right[q], planes.down[q]) = (slope.x, slope.y);
        }
        planes
    }

    /// Returns the quantities at the center of pixel `x` of `row`, and their steps to the next pixel.
    #[inline(always)]
    pub fn at(&self, x: u32, row: u32) -> ([f64; Q], [f64; Q]) {
        let (x, y) = (f64::from(x) - self.origin.x, f64::from(row) - self.origin.y);
        (std::array::from_fn(|q| self.at[q] + self.right[q] * x + self.down[q] * y), self.right)
    }
}
