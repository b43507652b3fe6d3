//! The Mach-band stimulus of Bangay §3.1: two plateaus of luminance and the ramp between them, rotated about the
//! center; and the colors of the ramp (Shoaff §2.2.9).

use super::{
    color::{self, StimulusColor},
    drawing::Profile,
    parameter::{ParameterError, Range, kind, parameter_error, text_field, unknown},
};
use crate::{
    light::{
        Depth, TANH_K,
        color::{hsv_from_rgb, hue, lab_from_xyz, rgb_from_hsv, rgb_from_xyz, wrapped_deg, xyz_from_lab, xyz_from_rgb},
    },
    text::names::named,
};

named! {
    /// The color space in which a ramp is a straight line.
    ///
    /// Between two luminances of one color, `rgb` and `hsv` give the same ramp. Between two colors, they do not: the
    /// color halfway from (1,0,0) to (0,1,0) is (½,½,0) in RGB but (1,1,0) in HSV (Shoaff §2.2.9).
    #[derive(Default)]
    RampSpace, RampSpaceError {
        /// Linear light. A straight line here is also straight in XYZ and CMY.
        #[default]
        Rgb = "rgb",
        /// Value, saturation and hue of the linear light. The hue takes the shorter arc; if both arcs are equal, it
        /// increases. A gray plateau takes the hue of the other plateau; a black plateau keeps the hue and saturation
        /// of its color.
        Hsv = "hsv",
        /// CIELAB with the white and the primaries of sRGB. Colors outside the gamut are clipped, channel by channel.
        Lab = "lab",
    }
}
text_field!(RampSpace: Self::NAMES, unknown;);

kind! {
    /// A square window of side 1 with a ramp across its middle. It is defined in light, not in codes: L = low + (high −
    /// low)·I_n(u), where u = x/width + ½ and x is the distance from the center line, positive on the brighter side.
    ///
    /// The plateaus have the light low·`color` and high·`color_high`. The ramp is the straight line between them in
    /// `space`, traversed at the fraction I_n(u). Equal plateaus of the same color make a uniform field: a catch trial.
    ///
    /// With `rounding` r, the ramp is its mean over r window sides, which turns each corner into a parabola. `nulling` a
    /// subtracts a·(high − low)·(g(x − width/2) − g(x + width/2)), with g a Gaussian of height 1 and standard deviation
    /// 0.02 window sides: the opposite of the lines that people see. If it is negative, it adds to those, and the ramp
    /// continues beyond the plateaus as far as there is light.
    ///
    /// Files omit the last four parameters if they have their default values, because most ramps have one color.
    MachBand = "mach-band" where contradictions {
        width: f64 = 0.4, Range::Within(0.0, 1.0), "1", "Proportion of the window that the ramp fills; 0 is a step", "the proportion of the window that the ramp fills", ["0", "0.05", "0.1", "0.2", "0.4", "0.8"];
        depth: Depth = Depth::Finite(1), Range::Any, "1", "Continuity depth n of the ramp: n − 1 derivatives vanish at its ends; inf is a scaled tanh", "a whole number from 1 to 32, or inf", ["1", "2", "3", "4", "inf"];
        tanh_k: f64 = TANH_K, Range::Within(1e-3, 100.0), "1", "Steepness k of a ramp of infinite depth: 5 as printed; 10 leaves no visible step at the ends", "a steepness from 0.001 to 100, such as 5", ["5", "10"];
        orientation_deg: f64 = 0.0, Range::Direction, "°", "Orientation, counterclockwise: 0 brightens to the right, 90 upward", "an angle in degrees, such as 45", ["0", "45", "90", "135"];
        low: f64 = 0.25, Range::Within(0.0, 1.0), "1", "Relative luminance of the darker plateau", "the relative luminance of the darker plateau", ["0.1", "0.25"];
        high: f64 = 0.75, Range::Within(0.0, 1.0), "1", "Relative luminance of the brighter plateau", "the relative luminance of the brighter plateau, not below low", ["0.75", "0.9"];
        color: StimulusColor = StimulusColor::YELLOW, Range::Any, "", color::MEANING, color::EXPECTED, ["yellow", "gray"];
        #[serde(skip_serializing_if = "is_default")]
        color_high: Option<StimulusColor> = None, Range::Any, "", "Color of the brighter plateau; same means the color of the darker one", "same, or any color that the darker plateau can have, such as red, 1,0.5,0 or hsv:30,1,1", ["same", "gray"];
        #[serde(skip_serializing_if = "is_default")]
        space: RampSpace = RampSpace::Rgb, Range::Any, "", "Color space in which the ramp is a straight line; rgb is linear light", "rgb, hsv or lab", ["rgb", "hsv", "lab"];
        #[serde(skip_serializing_if = "is_default")]
        rounding: f64 = 0.0, Range::Within(0.0, 1.0), "1", "Proportion of the window over which both corners of a ramp of depth 1 are rounded: the ramp is averaged over it", "the proportion of the window over which the corners are rounded", ["0", "0.1", "0.4"];
        #[serde(skip_serializing_if = "is_default")]
        nulling: f64 = 0.0, Range::Within(-1.0, 1.0), "1", "Amplitude of a dark line at the bright end of the ramp and a bright one at its dark end, as a proportion of their difference", "the amplitude of an opposite profile, from -1 to 1, with lines within the range of light", ["0", "0.05", "0.1", "0.2"];
    }
}

/// Standard deviation of the lines that `nulling` draws, window sides.
const NULLING_SD: f64 = 0.02;

fn is_default<T: Default + PartialEq>(value: &T) -> bool {
    *value == T::default()
}

/// Returns ∫ I₁ from −∞ to `u`.
fn integral(u: f64) -> f64 {
    if u <= 0.0 {
        0.0
    } else if u < 1.0 {
        0.5 * u * u
    } else {
        u - 0.5
    }
}

impl MachBand {
    fn contradictions(&self) -> Option<ParameterError> {
        let (name, value, problem) = if self.rounding > 0.0 && self.depth != Depth::Finite(1) {
            let problem = format!("rounds the corners of a ramp of depth 1, but the depth is {}", self.depth);
            ("rounding", self.rounding, problem)
        } else if self.nulling * (self.high - self.low) < -self.low.min(1.0 - self.high) {
            ("nulling", self.nulling, "draws lines beyond the light 0…1".to_owned())
        } else {
            return None;
        };
        parameter_error(Self::PARAMETERS, name, value, problem)
    }

    /// Returns the profile across the ramp, prepared for repeated evaluation.
    pub fn ramp(&self) -> Ramp<'_> {
        let color_high = self.color_high.unwrap_or(self.color);
        // In any space, a catch trial must be uniform to the last bit.
        let is_one_color = self.color == color_high && (self.space != RampSpace::Lab || self.low == self.high);
        let color_ramp = || ColorRamp::new(self.color, self.low, color_high, self.high, self.space);
        Ramp { band: self, color_ramp: (!is_one_color).then(color_ramp) }
    }
}

/// The light across a ramp.
#[derive(Clone, Copy, Debug)]
pub struct Ramp<'a> {
    band: &'a MachBand,
    /// `None` if the ramp is just one color at varying luminance.
    color_ramp: Option<ColorRamp>,
}

impl Ramp<'_> {
    /// Returns low + (high − low)·I_n, less the lines of `nulling`, at `x` window sides from the center line, positive on
    /// the brighter side. The result does not depend on the colors or the space.
    ///
    /// A ramp of width 0 is the limit of narrow ramps: low before the line, high after it, and halfway between them on
    /// it.
    pub fn luminance_at(&self, x: f64) -> f64 {
        let (MachBand { low, high, .. }, fraction) = (self.band, self.fraction_at(x));
        let most = if fraction > 1.0 { 1.0 } else { *high };
        // low + (high − low) can differ from high by a rounding error.
        if fraction == 1.0 { *high } else { (low + (high - low) * fraction).min(most).max(0.0) }
    }

    /// Returns red, green and blue at `x`, 0…1.
    pub fn light_at(&self, x: f64) -> [f64; 3] {
        match &self.color_ramp {
            Some(color_ramp) => color_ramp.light_at_fraction(self.fraction_at(x)),
            None => self.band.color.light(self.luminance_at(x)),
        }
    }

    /// Returns I_n, less the lines of `nulling`, at `x`: the fraction of the way from the darker to the brighter plateau,
    /// 0…1, or beyond it if `nulling` is negative.
    fn fraction_at(&self, x: f64) -> f64 {
        // At a width of 0, x/0 is ±∞ off the line, which the interpolation maps to 0 and 1. Only 0/0 needs a decision
        // here.
        let at = |x: f64| if x == 0.0 { 0.5 } else { x / self.band.width + 0.5 };
        let ramp = match self.band.rounding {
            0.0 => self.band.depth.interpolation(at(x), self.band.tanh_k),
            _ if self.band.width == 0.0 => (x / self.band.rounding + 0.5).clamp(0.0, 1.0),
            rounding => {
                let share = rounding / self.band.width;
                (integral(at(x) + 0.5 * share) - integral(at(x) - 0.5 * share)) / share
            }
        };
        let nulling = self.band.nulling;
        if nulling == 0.0 {
            return ramp.clamp(0.0, 1.0);
        }
        let line = |center: f64| (-0.5 * ((x - center) / NULLING_SD).powi(2)).exp();
        let opposite = line(0.5 * self.band.width) - line(-0.5 * self.band.width);
        (ramp - nulling * opposite).clamp(nulling.min(0.0), 1.0 - nulling.min(0.0))
    }
}

/// The light between two plateaus of a ramp that is not just one color at varying luminance, prepared for repeated
/// evaluation.
#[derive(Clone, Copy, Debug)]
struct ColorRamp {
    low: [f64; 3],
    high: [f64; 3],
    /// In linear light, every channel changes evenly along the way.
    space: RampSpace,
    /// The low plateau in the space; `difference` leads from it to the high plateau.
    from: [f64; 3],
    difference: [f64; 3],
}

impl ColorRamp {
    /// Creates the light between `color` at the luminance `low` and `color_high` at the luminance `high`.
    fn new(color: StimulusColor, low: f64, color_high: StimulusColor, high: f64, space: RampSpace) -> Self {
        let lights = [color.light(low), color_high.light(high)];
        let space = if lights[0] == lights[1] { RampSpace::Rgb } else { space };
        let ends = match space {
            RampSpace::Rgb => lights,
            // Computed from the colors and not from the light, so that black keeps its hue and saturation.
            RampSpace::Hsv => [(color, low), (color_high, high)].map(|(color, level)| {
                let [hue, saturation, value] = hsv_from_rgb(color.rgb());
                [hue, saturation, value * level]
            }),
            RampSpace::Lab => lights.map(|rgb| lab_from_xyz(xyz_from_rgb(rgb))),
        };
        let (mut from, mut difference) = (ends[0], [0, 1, 2].map(|i| ends[1][i] - ends[0][i]));
        if space == RampSpace::Hsv {
            let [low, high] = [color, color_high].map(|color| hue(color.rgb()));
            from[0] = low.or(high).unwrap_or(0.0);
            let turn = wrapped_deg(high.unwrap_or(from[0]) - from[0]);
            difference[0] = if turn > 180.0 { turn - 360.0 } else { turn };
        }
        Self { low: lights[0], high: lights[1], space, from, difference }
    }

    /// Returns the light at `fraction` of the way from the low plateau (0) to the high one (1), or on the line beyond them;
    /// each channel is 0…1.
    #[inline]
    fn light_at_fraction(&self, fraction: f64) -> [f64; 3] {
        if fraction == 0.0 {
            return self.low;
        }
        if fraction == 1.0 {
            return self.high;
        }
        let point = [0, 1, 2].map(|i| self.from[i] + self.difference[i] * fraction);
        let rgb = match self.space {
            RampSpace::Rgb => point,
            RampSpace::Hsv => rgb_from_hsv(point),
            RampSpace::Lab => rgb_from_xyz(xyz_from_lab(point)),
        };
        rgb.map(|value| value.clamp(0.0, 1.0))
    }
}

impl Profile for Ramp<'_> {
    fn light(&self, x: f64, _: f64) -> [f64; 3] {
        self.light_at(x)
    }

    fn turns(&self) -> Option<Vec<(f64, f64)>> {
        let is_straight = self.color_ramp.is_none_or(|color_ramp| color_ramp.space == RampSpace::Rgb);
        let is_known = is_straight && self.band.rounding == 0.0 && self.band.nulling == 0.0;
        is_known.then(|| vec![(-0.5 * self.band.width, 0.0), (0.5 * self.band.width, 0.0)])
    }
}
