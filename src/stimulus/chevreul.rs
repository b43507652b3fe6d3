//! The Chevreul staircase: uniform steps that look scalloped.

use super::{
    color::{self, StimulusColor},
    drawing::Profile,
    kind::{Range, kind, low_above_high},
    parameter::ParameterError,
};
kind! {
    /// A staircase of `steps` uniform bands of equal width, Chevreul 1839; Bangay fig. 1 a, b.
    ///
    /// L(x) = low + (high − low)·k/(steps − 1) with k = ⌊(x + ½)·steps⌋ kept within 0…steps − 1, x across the bands in
    /// window sides.
    Chevreul = "chevreul" {
        steps: u32 = 5, Range::Within(2.0, 256.0), "1", "Number of uniform bands", "a whole number of bands", ["3", "5", "9"];
        orientation_deg: f64 = 0.0, Range::Finite, "°", "Direction in which the bands brighten, counter-clockwise from the right", "an angle in degrees, such as 45", ["0", "45", "90"];
        low: f64 = 0.25, Range::Within(0.0, 1.0), "1", "Relative luminance of the darkest band", "the relative luminance of the darkest band", ["0.25"];
        high: f64 = 0.75, Range::Within(0.0, 1.0), "1", "Relative luminance of the brightest band", "the relative luminance of the brightest band, at least low's", ["0.75"];
        color: StimulusColor = StimulusColor::GRAY, Range::Any, "", color::MEANING, color::EXPECTED, ["gray", "yellow"];
    }
}

impl Chevreul {
    fn contradictions(&self) -> Option<ParameterError> {
        low_above_high(Self::PARAMETERS, self.low, self.high)
    }

    fn band(&self, x: f64) -> f64 {
        ((x + 0.5) * f64::from(self.steps)).floor().clamp(0.0, f64::from(self.steps - 1))
    }
}

impl Profile for Chevreul {
    fn orientation_deg(&self) -> f64 {
        self.orientation_deg
    }

    fn weights(&self) -> [f64; 3] {
        self.color.rgb()
    }

    fn luminance(&self, x: f64) -> f64 {
        self.low + (self.high - self.low) * self.band(x) / f64::from(self.steps - 1)
    }

    fn jumps(&self) -> Vec<(f64, f64)> {
        let height = (self.high - self.low) / f64::from(self.steps - 1);
        (1..self.steps).map(|k| (f64::from(k) / f64::from(self.steps) - 0.5, height)).collect()
    }

    fn turns(&self) -> Vec<f64> {
        self.jumps().into_iter().map(|(at, _)| at).collect()
    }

    fn is_level(&self, _: f64) -> bool {
        true
    }
}
