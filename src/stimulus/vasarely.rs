//! Vasarely's nested squares: graded steps whose corners glow.

use super::{
    color::{self, StimulusColor},
    coverage::{Point, area, pixel, within},
    drawing::Area,
    kind::{Range, kind, low_above_high},
    orientation::{Grid, light, place},
    parameter::ParameterError,
};
use crate::light::LinearImage;

kind! {
    /// Squares within squares of graded luminance, whose diagonals look brighter; after Vasarely's "Arcturus", Bangay
    /// fig. 1 j, k.
    ///
    /// L = low + (high − low)·k/(squares − 1), k = ⌊squares·(1 − 2d)⌋ kept within 0…squares − 1, d = max(|x|, |y|) in
    /// window sides, x and y turned by the orientation: `low` outside, `high` in the middle.
    Vasarely = "vasarely" {
        squares: u32 = 12, Range::Within(2.0, 256.0), "1", "Number of nested squares", "a whole number of squares", ["6", "12", "24"];
        orientation_deg: f64 = 0.0, Range::Finite, "°", "Turn of the squares, counter-clockwise", "an angle in degrees, such as 45", ["0", "45"];
        low: f64 = 0.1, Range::Within(0.0, 1.0), "1", "Relative luminance of the outermost square", "the relative luminance of the outermost square", ["0.1"];
        high: f64 = 0.9, Range::Within(0.0, 1.0), "1", "Relative luminance of the innermost square", "the relative luminance of the innermost square, at least low's", ["0.9"];
        color: StimulusColor = StimulusColor::GRAY, Range::Any, "", color::MEANING, color::EXPECTED, ["gray", "yellow"];
    }
}

impl Vasarely {
    fn contradictions(&self) -> Option<ParameterError> {
        low_above_high(Self::PARAMETERS, self.low, self.high)
    }

    /// In how many squares beyond the outermost a point at this distance lies.
    fn inside(&self, distance: f64) -> f64 {
        (f64::from(self.squares) * (1.0 - 2.0 * distance)).floor().clamp(0.0, f64::from(self.squares - 1))
    }

    /// The mean of that over a pixel that lies in at least `least` and at most `most` squares.
    fn covered(&self, grid: &Grid, place: Point, least: f64, most: f64) -> f64 {
        let side = f64::from(grid.size);
        // In the frame of the pixel, whose sides run along the axes: the squares are turned.
        let corner = |x: f64, y: f64| {
            let (x, y) = (x - place[0] * side, y - place[1] * side);
            [x * grid.cos - y * grid.sin, x * grid.sin + y * grid.cos]
        };
        let cell = pixel([0.0, 0.0]);
        (least as u32 + 1..=most as u32).fold(least, |sum, k| {
            let half = side / 2.0 * (1.0 - f64::from(k) / f64::from(self.squares));
            let square = [corner(-half, -half), corner(half, -half), corner(half, half), corner(-half, half)];
            sum + area(&within(&cell, &square))
        })
    }

    fn luminance(&self, squares: f64) -> f64 {
        self.low + (self.high - self.low) * squares / f64::from(self.squares - 1)
    }

    /// The light at `x` window sides from the middle, along the orientation.
    fn light_at(&self, x: f64) -> [f32; 3] {
        light(self.color.rgb(), self.luminance(self.inside(x.abs())))
    }
}
impl Area for Vasarely {
    fn linear(&self, size: u32) -> LinearImage {
        let grid = Grid::new(size, self.orientation_deg);
        let weights = self.color.rgb();
        let turned = Grid::new(size, self.orientation_deg + 90.0);
        let sharp = grid.is_along_pixels();
        LinearImage::from_fn(size, size, |ix, iy| {
            let place = [grid.across(ix, iy), turned.across(ix, iy)];
            let distance = place[0].abs().max(place[1].abs());
            let reach = if sharp { 0.0 } else { std::f64::consts::FRAC_1_SQRT_2 / f64::from(size) };
            let (least, most) = (self.inside(distance + reach), self.inside((distance - reach).max(0.0)));
            let squares = if least == most { least } else { self.covered(&grid, place, least, most) };
            light(weights, self.luminance(squares))
        })
    }

    fn profile(&self, size: u32) -> Vec<[f32; 3]> {
        (0..size).map(|i| self.light_at(place(i, size))).collect()
    }
}
