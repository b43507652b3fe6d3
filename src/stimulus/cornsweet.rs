//! The Craik–O'Brien–Cornsweet edge: equal areas that an edge between them makes look unequal.

use super::{
    color::{self, StimulusColor},
    drawing::Profile,
    kind::{Range, kind, low_above_high},
    parameter::ParameterError,
};
kind! {
    /// Two areas of the same luminance with an edge between them, from which the luminance returns to the areas' own;
    /// Craik 1940, O'Brien 1958, Cornsweet 1970; Bangay fig. 1 g, h.
    ///
    /// L(x) = (low + high)/2 ± (high − low)/2·(1 − |x|/width)^exponent for |x| < width, + beyond the edge and − before
    /// it, (low + high)/2 elsewhere; x across the edge in window sides. Exponent 1 is the linear profile.
    Cornsweet = "cornsweet" {
        width: f64 = 0.2, Range::Within(0.0, 0.5), "1", "Proportion of the window that the ramp fills on each side of the edge", "the proportion of the window that each ramp fills", ["0.05", "0.1", "0.2", "0.4"];
        exponent: f64 = 1.0, Range::Within(0.1, 20.0), "1", "Exponent of the return to the mean: 1 is linear, larger is steeper at the edge", "an exponent such as 1 or 2.75", ["1", "2", "2.75"];
        orientation_deg: f64 = 0.0, Range::Finite, "°", "Direction from the dark to the bright side of the edge, counter-clockwise from the right", "an angle in degrees, such as 45", ["0", "45", "90"];
        low: f64 = 0.4, Range::Within(0.0, 1.0), "1", "Relative luminance on the dark side of the edge", "the relative luminance on the dark side", ["0.4"];
        high: f64 = 0.6, Range::Within(0.0, 1.0), "1", "Relative luminance on the bright side of the edge", "the relative luminance on the bright side, at least low's", ["0.6"];
        color: StimulusColor = StimulusColor::GRAY, Range::Any, "", color::MEANING, color::EXPECTED, ["gray", "yellow"];
    }
}

impl Cornsweet {
    fn contradictions(&self) -> Option<ParameterError> {
        low_above_high(Self::PARAMETERS, self.low, self.high)
    }
}

impl Profile for Cornsweet {
    fn orientation_deg(&self) -> f64 {
        self.orientation_deg
    }

    fn weights(&self) -> [f64; 3] {
        self.color.rgb()
    }

    fn luminance(&self, x: f64) -> f64 {
        let mean = (self.low + self.high) / 2.0;
        let left = 1.0 - x.abs() / self.width;
        if self.width == 0.0 || left <= 0.0 {
            return mean;
        }
        let half = (self.high - self.low) / 2.0 * left.powf(self.exponent);
        if x >= 0.0 { mean + half } else { mean - half }
    }

    fn jumps(&self) -> Vec<(f64, f64)> {
        // Without width there is no edge left.
        if self.width == 0.0 { Vec::new() } else { vec![(0.0, self.high - self.low)] }
    }

    fn turns(&self) -> Vec<f64> {
        vec![-self.width, 0.0, self.width]
    }

    fn is_level(&self, x: f64) -> bool {
        x.abs() >= self.width
    }
}
