//! Which pixels a triangle covers.

use std::ops::Range;

use glam::DVec2;

use super::projected::Frame;

/// Rows that are computed at once.
const ROWS: usize = 8;

/// Half a pixel, less far more than f64's rounding and far less than the 2⁻³¹ px by which an edge passes by a pixel's
/// center at least: places are multiples of 1/256 px and below 2¹⁵ px.
const NEARLY_HALF: f64 = 0.5 - 1.0 / (1u64 << 33) as f64;

/// Added to a number below 2⁵¹, brings its whole part, rounded to nearest, into the lowest bits.
const TO_WHOLE: f64 = 1.5 * (1u64 << 52) as f64;

/// A triangle as rows of pixels: those whose center lies inside, or on a left or top edge, as graphics cards have it.
/// Exact.
#[derive(Clone, Copy, Debug)]
pub struct Outline {
    /// The first row, and the one after the last, within the window.
    pub first: u32,
    pub end: u32,
    /// The sides that bound it from the left, at most two, and those from the right.
    left: [Side; 2],
    right: [Side; 2],
}

/// A side as its column at the height of a row's centers: `x + (row − y)·slope`, in pixels from the center of the first.
#[derive(Clone, Copy, Debug)]
struct Side {
    x: f64,
    y: f64,
    slope: f64,
}

/// The first pixel whose center is at `place` or beyond, of at most `count`.
fn first_center(place: f64, count: u32) -> u32 {
    // Casts from f64 saturate, and take NaN for 0.
    ((place - 0.5).ceil() as u32).min(count)
}

impl Outline {
    /// The triangle with these corners in a window of `width` × `height` pixels; `None` if it looks away, or holds no
    /// pixel's center for a simple reason.
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
        // Counter-clockwise to the eye and y down: left edges go down. Level ones bound nothing from left or right.
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

    /// Calls `of` with each of `rows`, which must be the triangle's, its first pixel and the one after the last.
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

/// The first whole number that `x` does not exceed, within 0…`width`.
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
