//! Which pixels of a row a triangle covers: those whose centre lies inside, or on a left or top edge; exactly the
//! pixels of [`coverage`](crate::shading::coverage).

use glam::DVec2;

/// Rows that are computed at once.
pub(super) const ROWS: usize = 8;

/// Half a pixel, less far more than f64's rounding and far less than the 2⁻³¹ px by which an edge passes by a pixel's
/// centre at least: places are multiples of 1/256 px and below 2¹⁵ px.
const NEARLY_HALF: f64 = 0.5 - 1.0 / (1u64 << 33) as f64;

/// Added to a number below 2⁵¹, brings its whole part, rounded to nearest, into the lowest bits.
const TO_WHOLE: f64 = 1.5 * (1u64 << 52) as f64;

/// A triangle as rows of pixels.
#[derive(Clone, Copy, Debug)]
pub(super) struct Outline {
    /// The first row, and the one after the last, within the window.
    pub first: u32,
    pub end: u32,
    /// The side from the top to the bottom.
    long: Side,
    /// From the top to the middle corner, and on to the bottom.
    short: [Side; 2],
    long_is_left: bool,
}

/// A side as its column at the height of a row's centres: `x + (row − y)·slope`, in pixels from the centre of the first.
#[derive(Clone, Copy, Debug)]
struct Side {
    x: f64,
    y: f64,
    slope: f64,
}

/// The triangle's corners in order of height.
#[derive(Clone, Copy, Debug)]
pub(super) struct Heights {
    pub top: usize,
    pub middle: usize,
    pub bottom: usize,
}

impl Heights {
    pub fn of(corners: [DVec2; 3]) -> Heights {
        let mut order = [0, 1, 2];
        order.sort_by(|a, b| corners[*a].y.total_cmp(&corners[*b].y));
        let [top, middle, bottom] = order;
        Heights { top, middle, bottom }
    }
}

/// The first pixel whose centre is at `place` or beyond, of at most `count`.
fn first_centre(place: f64, count: u32) -> u32 {
    // Casts from f64 saturate, and take NaN for 0.
    ((place - 0.5).ceil() as u32).min(count)
}

impl Outline {
    /// The triangle with these corners in a window of `width` × `height` pixels; `None` if it holds no pixel's centre
    /// for a simple reason.
    pub fn new(corners: [DVec2; 3], width: u32, height: u32) -> Option<Outline> {
        let low = corners[0].min(corners[1]).min(corners[2]);
        let high = corners[0].max(corners[1]).max(corners[2]);
        let (first, end) = (first_centre(low.y, height), first_centre(high.y, height));
        if first >= end || first_centre(low.x, width) >= first_centre(high.x, width) {
            return None;
        }
        let Heights { top, middle, bottom } = Heights::of(corners);
        let [top, middle, bottom] = [top, middle, bottom].map(|k| corners[k]);
        // y points down: the middle corner is on the right if the turn to the bottom is positive.
        let long_is_left = (middle - top).perp_dot(bottom - top) > 0.0;
        let open = if long_is_left { f64::INFINITY } else { f64::NEG_INFINITY };
        let short = [Side::new(top, middle, open), Side::new(middle, bottom, open)];
        Some(Outline { first, end, long: Side::new(top, bottom, open), short, long_is_left })
    }

    /// The first pixel and the one after the last of [`ROWS`] rows from `row` on. Rows outside the triangle have any.
    #[inline(always)]
    pub fn spans(&self, row: u32, width: u32) -> ([u32; ROWS], [u32; ROWS]) {
        let (mut left, mut right) = ([0.0; ROWS], [0.0; ROWS]);
        let (long, [upper, lower]) = (&self.long, &self.short);
        let width = f64::from(width);
        for i in 0..ROWS {
            let y = f64::from(row) + i as f64;
            let (long, upper, lower) = (long.at(y), upper.at(y), lower.at(y));
            // Both short sides bound the triangle: it is convex.
            let (a, b) = if self.long_is_left {
                (long, if upper < lower { upper } else { lower })
            } else {
                (if upper > lower { upper } else { lower }, long)
            };
            left[i] = a;
            right[i] = b;
        }
        let (mut first, mut end) = ([0; ROWS], [0; ROWS]);
        for i in 0..ROWS {
            first[i] = centre(left[i], width);
            end[i] = centre(right[i], width);
        }
        (first, end)
    }
}

/// The first whole number that `x` does not exceed, within 0…`width`.
#[inline(always)]
fn centre(x: f64, width: f64) -> u32 {
    let x = if x > 0.0 { x } else { 0.0 };
    let x = if x < width { x } else { width };
    ((x + NEARLY_HALF) + TO_WHOLE).to_bits() as u32
}

impl Side {
    /// A horizontal side bounds nothing from left or right: it is at `open`.
    fn new(from: DVec2, to: DVec2, open: f64) -> Side {
        let down = to.y - from.y;
        let (x, slope) = if down > 0.0 { (from.x - 0.5, (to.x - from.x) / down) } else { (open, 0.0) };
        Side { x, y: from.y - 0.5, slope }
    }

    #[inline(always)]
    fn at(&self, row: f64) -> f64 {
        self.x + (row - self.y) * self.slope
    }
}
