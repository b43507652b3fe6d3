//! Light interpolated between the vertices, in both of the ways in which text books give it: by weights, and line by
//! line with increments. They are equal.

use glam::DVec2;

use crate::shading::boundary::{Corner, Intensity};

/// Bangay eq. 2: L = w_A·I_A + w_B·I_B + w_C·I_C.
#[must_use]
pub fn weighted<V: Intensity>(w: [f64; 3], lights: [V; 3]) -> V {
    lights[0] * w[0] + lights[1] * w[1] + lights[2] * w[2]
}

/// Gouraud's own way: calls `pixel(x, y, light)` for the pixels of the triangle, row by row from the top.
///
/// Along the left and right side of a row place and light change by a constant from row to row; along the row, the
/// light by `(I_right − I_left)/(X_right − X_left)` from pixel to pixel. Text books begin a row with I_left at the
/// first pixel; its centre is a fraction of a pixel inside the edge, and the light here begins there. Rows and columns
/// below 0 are left out. A triangle without area has no pixels.
pub fn scan_lines<V: Intensity>(corners: [Corner<V>; 3], mut pixel: impl FnMut(u32, u32, V)) {
    let [mut top, mut middle, mut bottom] = corners;
    if middle.0.y < top.0.y {
        (top, middle) = (middle, top);
    }
    if bottom.0.y < middle.0.y {
        (middle, bottom) = (bottom, middle);
    }
    if middle.0.y < top.0.y {
        (top, middle) = (middle, top);
    }
    let side = (middle.0 - top.0).perp_dot(bottom.0 - top.0);
    if side != 0.0 && side.is_finite() {
        // y points down: the middle corner is on the right if the turn to the bottom is positive.
        let middle_right = side > 0.0;
        for (from, to) in [(top, middle), (middle, bottom)] {
            rows(from, to, (top, bottom), middle_right, &mut pixel);
        }
    }
}

/// The rows between the heights of `from` and `to`, the ends of a short side, `long` being the side from top to bottom.
fn rows<V: Intensity>(
    from: Corner<V>,
    to: Corner<V>,
    long: (Corner<V>, Corner<V>),
    short_is_right: bool,
    pixel: &mut impl FnMut(u32, u32, V),
) {
    let (first, last) = (centres_from(from.0.y), centres_from(to.0.y));
    if first >= last {
        return;
    }
    let mut short = Side::new(from, to, first);
    let mut long = Side::new(long.0, long.1, first);
    for y in first..last {
        let (left, right) = if short_is_right { (&long, &short) } else { (&short, &long) };
        row(y, left, right, pixel);
        short.step();
        long.step();
    }
}

fn row<V: Intensity>(y: u32, left: &Side<V>, right: &Side<V>, pixel: &mut impl FnMut(u32, u32, V)) {
    let (first, last) = (centres_from(left.x), centres_from(right.x));
    if first >= last {
        return;
    }
    let step = (right.light - left.light) * (1.0 / (right.x - left.x));
    let mut light = left.light + step * (f64::from(first) + 0.5 - left.x);
    for x in first..last {
        pixel(x, y, light);
        light = light + step;
    }
}

/// The first pixel whose centre is at `place` or beyond.
fn centres_from(place: f64) -> u32 {
    (place - 0.5).ceil() as u32
}

/// A side of the triangle at the height of a row of pixels.
struct Side<V> {
    x: f64,
    light: V,
    dx: f64,
    dlight: V,
}

impl<V: Intensity> Side<V> {
    fn new((from, from_light): (DVec2, V), (to, to_light): (DVec2, V), row: u32) -> Side<V> {
        let per_row = 1.0 / (to.y - from.y);
        let (dx, dlight) = ((to.x - from.x) * per_row, (to_light - from_light) * per_row);
        let down = f64::from(row) + 0.5 - from.y;
        Side { x: from.x + dx * down, light: from_light + dlight * down, dx, dlight }
    }

    fn step(&mut self) {
        self.x += self.dx;
        self.light = self.light + self.dlight;
    }
}
