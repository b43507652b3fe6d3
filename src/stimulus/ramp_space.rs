//! The colors of a ramp between two plateaus: Shoaff §2.2.9.

use super::{color::StimulusColor, parameter::text_field};
use crate::light::color::{
    LAB_DELTA, WHITE, cube_roots, hsv_from_rgb, hue, lab_from_xyz, rgb_from_hsv, rgb_from_xyz, wrapped_deg,
    xyz_from_lab, xyz_from_rgb,
};
use crate::light::names::named;

named! {
    /// The space in which a ramp is straight.
    ///
    /// Between two luminances of one color `rgb` and `hsv` are the same ramp. Between two colors they are not: halfway
    /// from (1,0,0) to (0,1,0) is (½,½,0) in RGB and (1,1,0) in HSV, Shoaff §2.2.9.
    #[derive(Default)]
    RampSpace, RampSpaceError {
        /// Linear light, which is also XYZ's and CMY's straight line.
        #[default]
        Rgb = "rgb",
        /// Value, saturation and hue of the linear light, the hue along the shorter arc; of two equal arcs, along the one
        /// that rises. A gray plateau has the other's hue, and black its color's hue and saturation.
        Hsv = "hsv",
        /// CIELAB, white and primaries those of sRGB; what is then outside the gamut is clipped, channel by channel.
        Lab = "lab",
    }
}
text_field!(RampSpace);

impl RampSpace {
    /// Whether files leave it out.
    pub(super) fn is_default(&self) -> bool {
        *self == RampSpace::default()
    }
}

/// The light from one plateau to another, where it is not one color throughout; ready to be evaluated many times.
#[derive(Clone, Copy, Debug)]
pub struct Between {
    low: [f64; 3],
    high: [f64; 3],
    space: RampSpace,
    /// The low plateau in the space, and the difference to the high one.
    from: [f64; 3],
    way: [f64; 3],
}

impl Between {
    /// Between two colors at the luminances `low` and `high`.
    pub fn new(color: StimulusColor, low: f64, color_high: StimulusColor, high: f64, space: RampSpace) -> Self {
        let lights = [color.light(low), color_high.light(high)];
        let space = if lights[0] == lights[1] { RampSpace::Rgb } else { space };
        let ends = match space {
            RampSpace::Rgb => lights,
            // Of the colors, so that black keeps its hue and saturation.
            RampSpace::Hsv => [(color, low), (color_high, high)].map(|(color, level)| {
                let [hue, saturation, value] = hsv_from_rgb(color.rgb());
                [hue, saturation, value * level]
            }),
            RampSpace::Lab => lights.map(|rgb| lab_from_xyz(xyz_from_rgb(rgb))),
        };
        let (mut from, mut way) = (ends[0], [0, 1, 2].map(|i| ends[1][i] - ends[0][i]));
        if space == RampSpace::Hsv {
            let [low, high] = [color, color_high].map(|color| hue(color.rgb()));
            from[0] = low.or(high).unwrap_or(0.0);
            let turn = wrapped_deg(high.unwrap_or(from[0]) - from[0]);
            way[0] = if turn > 180.0 { turn - 360.0 } else { turn };
        }
        Self { low: lights[0], high: lights[1], space, from, way }
    }

    /// The light `part` of the way from low, at 0, to high, at 1; each channel 0…1.
    #[inline]
    pub fn light_at_part(&self, part: f64) -> [f64; 3] {
        if part <= 0.0 {
            return self.low;
        }
        if part >= 1.0 {
            return self.high;
        }
        let point = [0, 1, 2].map(|i| self.from[i] + self.way[i] * part);
        let rgb = match self.space {
            RampSpace::Rgb => point,
            RampSpace::Hsv => rgb_from_hsv(point),
            RampSpace::Lab => rgb_from_xyz(xyz_from_lab(point)),
        };
        rgb.map(|value| value.clamp(0.0, 1.0))
    }

    /// The least and the most light between two parts of the way.
    pub fn bounds(&self, from: f64, to: f64) -> [[f64; 3]; 2] {
        let (half, steepness) = (0.5 * (to - from), self.steepness());
        let light = self.light_at_part(0.5 * (from + to));
        [-half, half].map(|half| [0, 1, 2].map(|channel| light[channel] + half * steepness[channel]))
    }

    /// The most that each channel can change, per part of the way.
    fn steepness(&self) -> [f64; 3] {
        let (from, way) = (self.from, self.way.map(f64::abs));
        let to = [0, 1, 2].map(|i| from[i] + self.way[i]);
        match self.space {
            RampSpace::Rgb => way,
            RampSpace::Hsv => {
                // Every channel is V, V(1−S), or V(1−S·t) with t the sixth of a turn, or 1 − t.
                let (value, saturation) = (from[2].max(to[2]), from[1].max(to[1]));
                [way[2] + value * way[1] + value * saturation * way[0] / 60.0; 3]
            }
            RampSpace::Lab => {
                // Every channel is a sum of cubes, or of straight lines no steeper than these where the cubes begin, of the
                // cube roots of X, Y and Z; they are straight in Lab.
                let [from, to] = [from, to].map(cube_roots);
                let steepest = [0, 1, 2].map(|i| {
                    let root = from[i].abs().max(to[i].abs()).max(LAB_DELTA);
                    WHITE[i] * 3.0 * root * root * (to[i] - from[i]).abs()
                });
                let by_xyz = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(rgb_from_xyz);
                [0, 1, 2].map(|channel| (0..3).map(|i| by_xyz[i][channel].abs() * steepest[i]).sum())
            }
        }
    }
}
