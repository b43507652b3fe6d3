//! The Kanizsa triangle: edges where nothing is drawn.

use super::{
    color::{self, StimulusColor},
    coverage::{Point, Polygon, area_in_disc, pixel, within},
    drawing::Area,
    kind::{Range, kind, low_above_high},
    orientation::{cos_sin, light, place},
    parameter::ParameterError,
};
use crate::light::LinearImage;

kind! {
    /// Three discs with a sector missing, so that a triangle seems to lie on them; Kanizsa 1955, Bangay fig. 1 l.
    ///
    /// L = high − (high − low)·(share of the pixel that lies in a disc and not in the triangle). The triangle is
    /// equilateral, its centroid in the middle of the window, one corner up at orientation 0; a disc stands at each
    /// corner.
    Kanizsa = "kanizsa" {
        side: f64 = 0.6, Range::Within(0.05, 1.0), "1", "Side of the triangle as a proportion of the window", "the side of the triangle as a proportion of the window", ["0.4", "0.6"];
        radius: f64 = 0.15, Range::Within(0.01, 0.5), "1", "Radius of the discs as a proportion of the window, at most half the triangle's side", "the radius of the discs as a proportion of the window", ["0.1", "0.15", "0.2"];
        orientation_deg: f64 = 0.0, Range::Finite, "°", "Turn of the triangle, counter-clockwise", "an angle in degrees, such as 45", ["0", "30"];
        low: f64 = 0.1, Range::Within(0.0, 1.0), "1", "Relative luminance of the discs", "the relative luminance of the discs", ["0.1"];
        high: f64 = 0.75, Range::Within(0.0, 1.0), "1", "Relative luminance of the ground", "the relative luminance of the ground, at least low's", ["0.75"];
        color: StimulusColor = StimulusColor::GRAY, Range::Any, "", color::MEANING, color::EXPECTED, ["gray", "yellow"];
    }
}

impl Kanizsa {
    fn contradictions(&self) -> Vec<ParameterError> {
        let parameter = |name: &str| Self::PARAMETERS.iter().find(|parameter| parameter.name == name);
        let overlap = (self.radius > self.side / 2.0)
            .then(|| {
                parameter("radius").map(|radius| {
                    radius.error(self.radius, format!("lets the discs overlap at a side of {}", self.side))
                })
            })
            .flatten();
        low_above_high(Self::PARAMETERS, self.low, self.high).into_iter().chain(overlap).collect()
    }

    /// The triangle's corners around the middle, counter-clockwise, y up, in a window of this side.
    fn corners(&self, window: f64) -> [Point; 3] {
        let reach = self.side * window / 3f64.sqrt();
        [90.0, 210.0, 330.0].map(|degrees| {
            let (cos, sin) = cos_sin(self.orientation_deg + degrees);
            [reach * cos, reach * sin]
        })
    }

    /// The light at `x` window sides from the middle, along the orientation.
    fn light_at(&self, x: f64) -> [f32; 3] {
        let corners = self.corners(1.0);
        let in_triangle = (0..3).all(|i| {
            let (a, b) = (corners[i], corners[(i + 1) % 3]);
            (b[0] - a[0]) * -a[1] - (b[1] - a[1]) * (x - a[0]) >= 0.0
        });
        let in_disc = corners.iter().any(|corner| (x - corner[0]).hypot(corner[1]) < self.radius);
        light(self.color.rgb(), if in_disc && !in_triangle { self.low } else { self.high })
    }
}

impl Area for Kanizsa {
    fn linear(&self, size: u32) -> LinearImage {
        let side = f64::from(size);
        let corners = self.corners(side);
        let weights = self.color.rgb();
        let radius = self.radius * side;
        LinearImage::from_fn(size, size, |ix, iy| {
            let center = [f64::from(ix) + 0.5 - side / 2.0, side / 2.0 - f64::from(iy) - 0.5];
            let disc =
                corners.iter().find(|corner| (center[0] - corner[0]).hypot(center[1] - corner[1]) < radius + 1.0);
            let share = disc.map_or(0.0, |disc| notched(center, *disc, &corners, radius));
            light(weights, self.high - (self.high - self.low) * share)
        })
    }

    fn profile(&self, size: u32) -> Vec<[f32; 3]> {
        (0..size).map(|i| self.light_at(place(i, size))).collect()
    }
}

/// The share of the pixel around `center` that lies in the disc and not in the triangle.
fn notched(center: Point, disc: Point, triangle: &[Point; 3], radius: f64) -> f64 {
    let from_disc = |p: Point| [p[0] - disc[0], p[1] - disc[1]];
    let cell = pixel(from_disc(center));
    let triangle: Polygon = triangle.iter().map(|corner| from_disc(*corner)).collect();
    let share = area_in_disc(&cell, radius) - area_in_disc(&within(&cell, &triangle), radius);
    share.clamp(0.0, 1.0)
}
