//! Stimuli that vary in both directions: Vasarely's nested squares and Kanizsa's triangle. The area of each pixel that
//! a shape covers is computed exactly.

use glam::DVec2;

use super::{
    color::{self, StimulusColor},
    drawing::{Area, Grid, cos_sin, place},
    parameter::{ParameterError, Range, kind, parameter_error},
};
use crate::light::LinearImage;

kind! {
    /// Nested squares of graded luminance. Their diagonals look brighter. After Vasarely's "Arcturus"; Bangay fig. 1 j,
    /// k.
    ///
    /// L = low + (high − low)·k/(squares − 1), where k = ⌊squares·(1 − 2d)⌋, limited to 0…squares − 1, and d = max(|x|,
    /// |y|) in window sides; x and y are rotated by the orientation. The luminance is `low` outside and `high` in the
    /// middle.
    Vasarely = "vasarely" {
        squares: u32 = 12, Range::Within(2.0, 256.0), "1", "Number of nested squares", "a whole number of squares", ["6", "12", "24"];
        orientation_deg: f64 = 0.0, Range::Direction, "°", "Rotation of the squares, counterclockwise", "an angle in degrees, such as 45", ["0", "45"];
        low: f64 = 0.1, Range::Within(0.0, 1.0), "1", "Relative luminance of the outermost square", "the relative luminance of the outermost square", ["0.1"];
        high: f64 = 0.9, Range::Within(0.0, 1.0), "1", "Relative luminance of the innermost square", "the relative luminance of the innermost square, not below low", ["0.9"];
        color: StimulusColor = StimulusColor::GRAY, Range::Any, "", color::MEANING, color::EXPECTED, ["gray", "yellow"];
    }
}

impl Vasarely {
    /// Returns how many squares contain a point at this distance from the center, not counting the outermost square.
    fn inside(&self, distance: f64) -> f64 {
        (f64::from(self.squares) * (1.0 - 2.0 * distance)).floor().clamp(0.0, f64::from(self.squares - 1))
    }

    /// Returns the mean of [`Self::inside`] over a pixel, within which it ranges from `least` to `most`.
    fn covered(&self, grid: &Grid, place: DVec2, least: f64, most: f64) -> f64 {
        let side = f64::from(grid.size);
        // In the frame of the pixel, whose sides run along the axes, the squares are rotated.
        let corner = |x: f64, y: f64| {
            let (x, y) = (x - place.x * side, y - place.y * side);
            DVec2::new(x * grid.cos - y * grid.sin, x * grid.sin + y * grid.cos)
        };
        let cell = pixel(DVec2::ZERO);
        (least as u32 + 1..=most as u32).fold(least, |sum, k| {
            let half = side / 2.0 * (1.0 - f64::from(k) / f64::from(self.squares));
            let square = [corner(-half, -half), corner(half, -half), corner(half, half), corner(-half, half)];
            sum + area(&within(&cell, &square))
        })
    }

    /// Returns the light of a point that this many squares contain, not counting the outermost square.
    fn light(&self, squares: f64) -> [f32; 3] {
        let luminance = self.low + (self.high - self.low) * squares / f64::from(self.squares - 1);
        self.color.light(luminance).map(|light| light as f32)
    }
}

impl Area for Vasarely {
    fn linear(&self, size: u32) -> LinearImage {
        let grid = Grid::new(size, self.orientation_deg);
        let turned = Grid::new(size, self.orientation_deg + 90.0);
        let sharp = grid.is_along_pixels();
        LinearImage::from_fn(size, size, |ix, iy| {
            let place = DVec2::new(grid.across(ix, iy), turned.across(ix, iy));
            let distance = place.abs().max_element();
            let reach = if sharp { 0.0 } else { std::f64::consts::FRAC_1_SQRT_2 / f64::from(size) };
            let (least, most) = (self.inside(distance + reach), self.inside((distance - reach).max(0.0)));
            let squares = if least == most { least } else { self.covered(&grid, place, least, most) };
            self.light(squares)
        })
    }

    fn profile(&self, size: u32) -> Vec<[f32; 3]> {
        (0..size).map(|i| self.light(self.inside(place(i, size).abs()))).collect()
    }
}

kind! {
    /// Three discs with a sector missing, so that a triangle seems to lie on top of them; Kanizsa 1955, Bangay fig. 1
    /// l.
    ///
    /// L = high − (high − low)·(share of the pixel's area that lies in a disc but not in the triangle). The triangle is
    /// equilateral with its centroid at the center of the window; at orientation 0, one corner points up. A disc is
    /// centered on each corner.
    Kanizsa = "kanizsa" where overlap {
        side: f64 = 0.6, Range::Within(0.05, 1.0), "1", "Side of the triangle as a proportion of the window", "the side of the triangle as a proportion of the window", ["0.4", "0.6"];
        radius: f64 = 0.15, Range::Within(0.01, 0.5), "1", "Radius of the discs as a proportion of the window, at most half the triangle's side", "the radius of the discs as a proportion of the window", ["0.1", "0.15", "0.2"];
        orientation_deg: f64 = 0.0, Range::Direction, "°", "Rotation of the triangle, counterclockwise", "an angle in degrees, such as 45", ["0", "30"];
        low: f64 = 0.1, Range::Within(0.0, 1.0), "1", "Relative luminance of the discs", "the relative luminance of the discs", ["0.1"];
        high: f64 = 0.75, Range::Within(0.0, 1.0), "1", "Relative luminance of the background", "the relative luminance of the background, not below low", ["0.75"];
        color: StimulusColor = StimulusColor::GRAY, Range::Any, "", color::MEANING, color::EXPECTED, ["gray", "yellow"];
    }
}

impl Kanizsa {
    fn overlap(&self) -> Option<ParameterError> {
        let problem = || format!("lets the discs overlap at a side of {}", self.side);
        (self.radius > self.side / 2.0).then(|| parameter_error(Self::PARAMETERS, "radius", self.radius, problem()))?
    }

    /// Returns the triangle's corners counterclockwise, relative to the center of a window with this side; y points up.
    fn corners(&self, window: f64) -> [DVec2; 3] {
        let reach = self.side * window / 3f64.sqrt();
        [90.0, 210.0, 330.0].map(|degrees| {
            let (cos, sin) = cos_sin(self.orientation_deg + degrees);
            DVec2::new(reach * cos, reach * sin)
        })
    }

    /// Returns the light of a pixel. `share` is the part of its area that lies in a disc but not in the triangle.
    fn light(&self, share: f64) -> [f32; 3] {
        self.color.light(self.high - (self.high - self.low) * share).map(|light| light as f32)
    }
}

impl Area for Kanizsa {
    fn linear(&self, size: u32) -> LinearImage {
        let side = f64::from(size);
        let corners = self.corners(side);
        let radius = self.radius * side;
        LinearImage::from_fn(size, size, |ix, iy| {
            let center = DVec2::new(f64::from(ix) + 0.5 - side / 2.0, side / 2.0 - f64::from(iy) - 0.5);
            let disc = corners.iter().find(|corner| center.distance(**corner) < radius + 1.0);
            let share = disc.map_or(0.0, |disc| notched(center, *disc, &corners, radius));
            self.light(share)
        })
    }

    fn profile(&self, size: u32) -> Vec<[f32; 3]> {
        let corners = self.corners(1.0);
        let light = |at: DVec2| {
            let in_triangle = edges(&corners).all(|(a, b)| (b - a).perp_dot(at - a) >= 0.0);
            let in_disc = corners.iter().any(|corner| at.distance(*corner) < self.radius);
            self.light(f64::from(u8::from(in_disc && !in_triangle)))
        };
        (0..size).map(|i| light(DVec2::new(place(i, size), 0.0))).collect()
    }
}

/// Returns the share of the area of the pixel at `center` that lies in the disc but not in the triangle.
fn notched(center: DVec2, disc: DVec2, triangle: &[DVec2; 3], radius: f64) -> f64 {
    let cell = pixel(center - disc);
    let triangle = triangle.map(|corner| corner - disc);
    let share = area_in_disc(&cell, radius) - area_in_disc(&within(&cell, &triangle), radius);
    share.clamp(0.0, 1.0)
}

/// A convex polygon with its corners in counterclockwise order, in pixels.
type Polygon = Vec<DVec2>;

/// Returns the unit square around a center.
fn pixel(center: DVec2) -> Polygon {
    [[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]].map(|corner| center + DVec2::from(corner)).to_vec()
}

/// Returns the part of a convex polygon to the left of the line from `a` to `b`; Sutherland and Hodgman 1974.
fn left_of(polygon: &[DVec2], a: DVec2, b: DVec2) -> Polygon {
    let mut kept = Polygon::with_capacity(polygon.len() + 1);
    for (p, q) in edges(polygon) {
        let [at_p, at_q] = [p, q].map(|point| (b - a).perp_dot(point - a));
        if at_p >= 0.0 {
            kept.push(p);
        }
        if (at_p > 0.0 && at_q < 0.0) || (at_p < 0.0 && at_q > 0.0) {
            kept.push(p + at_p / (at_p - at_q) * (q - p));
        }
    }
    kept
}

/// Returns the part of a convex polygon that lies within `clip`, whose corners must be in counterclockwise order.
fn within(polygon: &[DVec2], clip: &[DVec2]) -> Polygon {
    edges(clip).fold(polygon.to_vec(), |kept, (a, b)| left_of(&kept, a, b))
}

/// Returns the area of a polygon, positive if its corners are in counterclockwise order.
fn area(polygon: &[DVec2]) -> f64 {
    edges(polygon).map(|(p, q)| p.perp_dot(q)).sum::<f64>() / 2.0
}

/// Returns the area of the intersection of a polygon and the disc of this radius around the origin. Each edge
/// contributes the triangle that its part inside the disc forms with the origin, and the sectors that its parts outside
/// span.
fn area_in_disc(polygon: &[DVec2], radius: f64) -> f64 {
    edges(polygon).map(|(p, q)| edge_in_disc(p, q, radius)).sum()
}

fn edges(polygon: &[DVec2]) -> impl Iterator<Item = (DVec2, DVec2)> {
    polygon.iter().enumerate().map(|(i, &p)| (p, polygon[(i + 1) % polygon.len()]))
}

fn edge_in_disc(p: DVec2, q: DVec2, radius: f64) -> f64 {
    let d = q - p;
    let (a, b, c) = (d.dot(d), p.dot(d), p.dot(p) - radius * radius);
    if a == 0.0 {
        return 0.0;
    }
    let discriminant = b * b - a * c;
    if discriminant <= 0.0 {
        return sector(p, q, radius);
    }
    let root = discriminant.sqrt();
    // Where the edge enters and leaves the disc, clamped to the edge.
    let (enter, leave) = (((-b - root) / a).clamp(0.0, 1.0), ((-b + root) / a).clamp(0.0, 1.0));
    if enter >= leave {
        return sector(p, q, radius);
    }
    let (first, last) = (p + enter * d, p + leave * d);
    sector(p, first, radius) + first.perp_dot(last) / 2.0 + sector(last, q, radius)
}

/// Returns the signed area of the sector between the directions of two points.
fn sector(p: DVec2, q: DVec2, radius: f64) -> f64 {
    radius * radius / 2.0 * p.perp_dot(q).atan2(p.dot(q))
}
