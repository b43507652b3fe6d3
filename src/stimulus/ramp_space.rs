//! The colors of a ramp between two plateaus: Shoaff §2.2.9.

use super::{color::StimulusColor, parameter::text_field};
use crate::light::color::{
    hsv_from_rgb, hue, lab_from_xyz, rgb_from_hsv, rgb_from_xyz, wrapped_deg, xyz_from_lab, xyz_from_rgb,
};
use crate::text::names::named;

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
text_field!(RampSpace: Self::NAMES);

/// The light between two plateaus of a ramp that is not just one color at varying luminance, prepared for repeated
/// evaluation.
#[derive(Clone, Copy, Debug)]
pub struct ColorRamp {
    low: [f64; 3],
    high: [f64; 3],
    /// In linear light, every channel changes evenly along the way.
    pub(super) space: RampSpace,
    /// The low plateau in the space; `difference` leads from it to the high plateau.
    from: [f64; 3],
    difference: [f64; 3],
}

impl ColorRamp {
    /// Creates the light between `color` at the luminance `low` and `color_high` at the luminance `high`.
    pub fn new(color: StimulusColor, low: f64, color_high: StimulusColor, high: f64, space: RampSpace) -> Self {
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
    pub fn light_at_fraction(&self, fraction: f64) -> [f64; 3] {
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
