//! A faceted cylinder under the three classical shaders: where Chevreul's scallops and Mach's bands come from in
//! computer graphics.

use super::{
    color::{self, StimulusColor},
    drawing::Profile,
    kind::{Range, kind, low_above_high, text_field},
    parameter::ParameterError,
};
use crate::light::names::named;

named! {
    /// How the facets are shaded.
    Shading, ShadingError {
        /// One luminance a facet, that of its own normal: a Chevreul staircase.
        Flat = "flat",
        /// Luminance interpolated between the edges: Mach bands at every edge.
        Gouraud = "gouraud",
        /// Normals interpolated between the edges, and lit.
        Phong = "phong",
    }
}
text_field!(Shading);

kind! {
    /// A cylinder of plane facets, seen from the side and lit from the viewer, the one-dimensional companion of a
    /// shaded mesh; Bangay fig. 1 c (flat) and f (Gouraud).
    ///
    /// The visible arc of 120° is cut into `facets` equal angles; an edge at angle φ stands at x = sin φ/(2 sin 60°)
    /// window sides. L = low + (high − low)·(N·V − ½)/½, so that the middle has `high` and the rims `low`. N is the
    /// facet's normal (flat), or L is interpolated between the edges' (Gouraud), or N is (Phong).
    Cylinder = "shaded-cylinder" {
        shading: Shading = Shading::Gouraud, Range::Any, "", "How the facets are shaded: flat, gouraud or phong", "flat, gouraud or phong", ["flat", "gouraud", "phong"];
        facets: u32 = 6, Range::Within(1.0, 256.0), "1", "Number of facets across the window", "a whole number of facets", ["4", "6", "12"];
        orientation_deg: f64 = 0.0, Range::Finite, "°", "Direction across the facets, counter-clockwise from the right", "an angle in degrees, such as 45", ["0", "45", "90"];
        low: f64 = 0.25, Range::Within(0.0, 1.0), "1", "Relative luminance of the rims", "the relative luminance of the rims", ["0.25"];
        high: f64 = 0.75, Range::Within(0.0, 1.0), "1", "Relative luminance of the middle", "the relative luminance of the middle, at least low's", ["0.75"];
        color: StimulusColor = StimulusColor::GRAY, Range::Any, "", color::MEANING, color::EXPECTED, ["gray", "yellow"];
    }
}

/// Half the visible arc: 60°.
const HALF_ARC: f64 = std::f64::consts::FRAC_PI_3;

impl Cylinder {
    fn contradictions(&self) -> Option<ParameterError> {
        low_above_high(Self::PARAMETERS, self.low, self.high)
    }

    /// Angle of edge `i` of 0…facets.
    fn angle(&self, i: u32) -> f64 {
        HALF_ARC * (2.0 * f64::from(i) / f64::from(self.facets) - 1.0)
    }

    /// Place of edge `i` in window sides.
    fn place(&self, i: u32) -> f64 {
        // The rims exactly at the window's sides.
        match i {
            0 => -0.5,
            i if i == self.facets => 0.5,
            i => self.angle(i).sin() / (2.0 * HALF_ARC.sin()),
        }
    }

    /// The facet that `x` lies on.
    fn facet(&self, x: f64) -> u32 {
        (1..self.facets).take_while(|i| self.place(*i) <= x).count() as u32
    }

    /// Luminance of a surface whose normal makes an angle of this cosine with the view.
    fn lit(&self, cosine: f64) -> f64 {
        self.low + (self.high - self.low) * (cosine - HALF_ARC.cos()) / (1.0 - HALF_ARC.cos())
    }

    fn flat(&self, facet: u32) -> f64 {
        self.lit(((self.angle(facet) + self.angle(facet + 1)) / 2.0).cos())
    }
}

impl Profile for Cylinder {
    fn orientation_deg(&self) -> f64 {
        self.orientation_deg
    }

    fn weights(&self) -> [f64; 3] {
        self.color.rgb()
    }

    fn luminance(&self, x: f64) -> f64 {
        let x = x.clamp(-0.5, 0.5);
        let facet = self.facet(x);
        let (left, right) = (self.place(facet), self.place(facet + 1));
        let t = ((x - left) / (right - left)).clamp(0.0, 1.0);
        let (before, after) = (self.angle(facet), self.angle(facet + 1));
        let mix = |a: f64, b: f64| (1.0 - t) * a + t * b;
        match self.shading {
            Shading::Flat => self.flat(facet),
            Shading::Gouraud => mix(self.lit(before.cos()), self.lit(after.cos())),
            Shading::Phong => {
                let (toward, aside) = (mix(before.cos(), after.cos()), mix(before.sin(), after.sin()));
                self.lit(toward / toward.hypot(aside))
            }
        }
    }

    fn jumps(&self) -> Vec<(f64, f64)> {
        match self.shading {
            Shading::Flat => (1..self.facets).map(|i| (self.place(i), self.flat(i) - self.flat(i - 1))).collect(),
            Shading::Gouraud | Shading::Phong => Vec::new(),
        }
    }

    fn turns(&self) -> Vec<f64> {
        [0.0].into_iter().chain((0..=self.facets).map(|i| self.place(i))).collect()
    }

    fn is_level(&self, x: f64) -> bool {
        self.shading == Shading::Flat || x.abs() > 0.5
    }
}
