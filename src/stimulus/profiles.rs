//! Classical stimuli that vary in one direction: Chevreul's staircase, Cornsweet's edge and a shaded cylinder.

use super::{
    color::{self, StimulusColor},
    drawing::Profile,
    parameter::{Range, kind, text_field, unknown},
};
use crate::text::names::named;

kind! {
    /// A staircase of `steps` uniform bands of equal width, Chevreul 1839; Bangay fig. 1 a, b.
    ///
    /// L(x) = low + (high − low)·k/(steps − 1), where k = ⌊(x + ½)·steps⌋, limited to 0…steps − 1, and x is the
    /// position across the bands in window sides.
    Chevreul = "chevreul" {
        steps: u32 = 5, Range::Within(2.0, 256.0), "1", "Number of uniform bands", "a whole number of bands", ["3", "5", "9"];
        orientation_deg: f64 = 0.0, Range::Direction, "°", "Direction in which the bands brighten, counterclockwise from the right", "an angle in degrees, such as 45", ["0", "45", "90"];
        low: f64 = 0.25, Range::Within(0.0, 1.0), "1", "Relative luminance of the darkest band", "the relative luminance of the darkest band", ["0.25"];
        high: f64 = 0.75, Range::Within(0.0, 1.0), "1", "Relative luminance of the brightest band", "the relative luminance of the brightest band, not below low", ["0.75"];
        color: StimulusColor = StimulusColor::GRAY, Range::Any, "", color::MEANING, color::EXPECTED, ["gray", "yellow"];
    }
}

impl Profile for &Chevreul {
    fn light(&self, x: f64, added: f64) -> [f64; 3] {
        let band = ((x + 0.5) * f64::from(self.steps)).floor().clamp(0.0, f64::from(self.steps - 1));
        self.color.light(self.low + (self.high - self.low) * band / f64::from(self.steps - 1) + added)
    }

    fn turns(&self) -> Option<Vec<(f64, f64)>> {
        let height = (self.high - self.low) / f64::from(self.steps - 1);
        Some((1..self.steps).map(|k| (f64::from(k) / f64::from(self.steps) - 0.5, height)).collect())
    }
}

kind! {
    /// Two areas of the same luminance with an edge between them. On each side of the edge, the luminance gradually
    /// returns to the luminance of the areas. Craik 1940, O'Brien 1958, Cornsweet 1970; Bangay fig. 1 g, h.
    ///
    /// L(x) = (low + high)/2 ± (high − low)/2·(1 − |x|/width)^exponent for |x| < width, with + beyond the edge and −
    /// before it. Elsewhere, L(x) = (low + high)/2. x is the position across the edge in window sides. An exponent of 1
    /// gives the linear profile.
    Cornsweet = "cornsweet" {
        width: f64 = 0.2, Range::Within(0.0, 0.5), "1", "Proportion of the window that the ramp fills on each side of the edge", "the proportion of the window that each ramp fills", ["0.05", "0.1", "0.2", "0.4"];
        exponent: f64 = 1.0, Range::Within(0.1, 20.0), "1", "Exponent of the return to the mean: 1 is linear; larger values are steeper at the edge", "an exponent such as 1 or 2.75", ["1", "2", "2.75"];
        orientation_deg: f64 = 0.0, Range::Direction, "°", "Direction from the dark to the bright side of the edge, counterclockwise from the right", "an angle in degrees, such as 45", ["0", "45", "90"];
        low: f64 = 0.4, Range::Within(0.0, 1.0), "1", "Relative luminance on the dark side of the edge", "the relative luminance on the dark side", ["0.4"];
        high: f64 = 0.6, Range::Within(0.0, 1.0), "1", "Relative luminance on the bright side of the edge", "the relative luminance on the bright side, not below low", ["0.6"];
        color: StimulusColor = StimulusColor::GRAY, Range::Any, "", color::MEANING, color::EXPECTED, ["gray", "yellow"];
    }
}

impl Profile for &Cornsweet {
    fn light(&self, x: f64, added: f64) -> [f64; 3] {
        let mean = (self.low + self.high) / 2.0;
        let left = 1.0 - x.abs() / self.width;
        if self.width == 0.0 || left <= 0.0 {
            return self.color.light(mean + added);
        }
        let half = (self.high - self.low) / 2.0 * left.powf(self.exponent);
        self.color.light(if x >= 0.0 { mean + half } else { mean - half } + added)
    }

    fn turns(&self) -> Option<Vec<(f64, f64)>> {
        // With a width of 0, there is no edge.
        let height = if self.width == 0.0 { 0.0 } else { self.high - self.low };
        Some(vec![(-self.width, 0.0), (0.0, height), (self.width, 0.0)])
    }
}

named! {
    /// How the facets are shaded.
    Shading, ShadingError {
        /// Each facet has one luminance, computed from its own normal: a Chevreul staircase.
        Flat = "flat",
        /// Luminance is interpolated between the edges: Mach bands appear at every edge.
        Gouraud = "gouraud",
        /// Normals are interpolated between the edges, and each point is then lit.
        Phong = "phong",
    }
}
text_field!(Shading: Self::NAMES, unknown;);

kind! {
    /// A cylinder of flat facets, seen from the side and lit from the viewer's position: the one-dimensional
    /// counterpart of a shaded mesh; Bangay fig. 1 c (flat) and f (Gouraud).
    ///
    /// The visible arc of 120° is divided into `facets` equal angles. An edge at angle φ is at x = sin φ/(2 sin 60°)
    /// window sides. L = low + (high − low)·(N·V − ½)/½, so the luminance is `high` in the middle and `low` at the
    /// rims. With flat shading, N is the normal of the facet. With Gouraud shading, L is interpolated between the
    /// edges; with Phong shading, N is interpolated.
    Cylinder = "shaded-cylinder" {
        shading: Shading = Shading::Gouraud, Range::Any, "", "How the facets are shaded: flat, gouraud or phong", "flat, gouraud or phong", ["flat", "gouraud", "phong"];
        facets: u32 = 6, Range::Within(1.0, 256.0), "1", "Number of facets across the window", "a whole number of facets", ["4", "6", "12"];
        orientation_deg: f64 = 0.0, Range::Direction, "°", "Direction across the facets, counterclockwise from the right", "an angle in degrees, such as 45", ["0", "45", "90"];
        low: f64 = 0.25, Range::Within(0.0, 1.0), "1", "Relative luminance of the rims", "the relative luminance of the rims", ["0.25"];
        high: f64 = 0.75, Range::Within(0.0, 1.0), "1", "Relative luminance of the middle", "the relative luminance of the middle, not below low", ["0.75"];
        color: StimulusColor = StimulusColor::GRAY, Range::Any, "", color::MEANING, color::EXPECTED, ["gray", "yellow"];
    }
}

/// Half the visible arc: 60°.
const HALF_ARC: f64 = std::f64::consts::FRAC_PI_3;

impl Cylinder {
    /// Returns the angle of edge `i`, 0…`facets`, in radians.
    fn angle(&self, i: u32) -> f64 {
        HALF_ARC * (2.0 * f64::from(i) / f64::from(self.facets) - 1.0)
    }

    /// Returns the position of edge `i` in window sides.
    fn place(&self, i: u32) -> f64 {
        // The rims lie exactly on the sides of the window.
        match i {
            0 => -0.5,
            i if i == self.facets => 0.5,
            i => self.angle(i).sin() / (2.0 * HALF_ARC.sin()),
        }
    }

    /// Returns the facet on which `x` lies.
    fn facet(&self, x: f64) -> u32 {
        (1..self.facets).take_while(|i| self.place(*i) <= x).count() as u32
    }

    /// Returns the luminance of a surface, given the cosine of the angle between its normal and the line of sight.
    fn lit(&self, cosine: f64) -> f64 {
        self.low + (self.high - self.low) * (cosine - HALF_ARC.cos()) / (1.0 - HALF_ARC.cos())
    }

    fn flat(&self, facet: u32) -> f64 {
        self.lit(((self.angle(facet) + self.angle(facet + 1)) / 2.0).cos())
    }
}

impl Profile for &Cylinder {
    fn light(&self, x: f64, added: f64) -> [f64; 3] {
        let x = x.clamp(-0.5, 0.5);
        let facet = self.facet(x);
        let (left, right) = (self.place(facet), self.place(facet + 1));
        let t = ((x - left) / (right - left)).clamp(0.0, 1.0);
        let (before, after) = (self.angle(facet), self.angle(facet + 1));
        let mix = |a: f64, b: f64| (1.0 - t) * a + t * b;
        let luminance = match self.shading {
            Shading::Flat => self.flat(facet),
            Shading::Gouraud => mix(self.lit(before.cos()), self.lit(after.cos())),
            Shading::Phong => {
                let (toward, aside) = (mix(before.cos(), after.cos()), mix(before.sin(), after.sin()));
                self.lit(toward / toward.hypot(aside))
            }
        };
        self.color.light(luminance + added)
    }

    fn turns(&self) -> Option<Vec<(f64, f64)>> {
        let is_edge = |i: &u32| self.shading == Shading::Flat && (1..self.facets).contains(i);
        let height = |i: u32| if is_edge(&i) { self.flat(i) - self.flat(i - 1) } else { 0.0 };
        let edges = (0..=self.facets).map(|i| (self.place(i), height(i)));
        Some(edges.chain([(0.0, 0.0)]).collect())
    }
}
