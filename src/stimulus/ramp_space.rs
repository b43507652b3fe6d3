//! How a ramp passes from the light of one plateau to that of the other: Shoaff §2.2.9.

use super::{color::StimulusColor, parameter::text_field};
use crate::light::color::{LAB_DELTA, Lab, Primaries, cube_roots, lab_from_xyz, xyz_from_lab};
use crate::light::color_models::{Hsv, hsv_from_rgb, rgb_from_hsv, wrapped_deg};
use crate::light::names::named;

named! {
    /// The space in which a ramp is straight.
    ///
    /// Between two luminances of one color `rgb` and `hsv` are the same ramp. Between two colors they are not: half-way from
    /// (1,0,0) to (0,1,0) is (½,½,0) in RGB and (1,1,0) in HSV, Shoaff §2.2.9.
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
    /// Whether this is what files leave out.
    pub(super) fn is_default(&self) -> bool {
        *self == RampSpace::default()
    }
}

/// The light from one plateau to another, where it is not one color throughout; ready to be evaluated many times.
#[derive(Clone, Copy, Debug)]
pub struct Between {
    low: [f64; 3],
    high: [f64; 3],
    course: Course,
}

/// Which way from one light to another.
#[derive(Clone, Copy, Debug)]
enum Course {
    Rgb,
    /// From `low` by `arc` degrees.
    Hsv {
        low: Hsv,
        high: Hsv,
        arc: f64,
    },
    Lab {
        low: Lab,
        high: Lab,
    },
}

impl Between {
    /// Between two colors at the luminances `low` and `high`.
    pub fn new(color: StimulusColor, low: f64, color_high: StimulusColor, high: f64, space: RampSpace) -> Self {
        let ends = [(color, low), (color_high, high)].map(|(color, level)| color.rgb().map(|weight| weight * level));
        let course = match space {
            _ if ends[0] == ends[1] => Course::Rgb,
            RampSpace::Rgb => Course::Rgb,
            RampSpace::Hsv => hsv_course(color, low, color_high, high),
            RampSpace::Lab => {
                let [low, high] = ends.map(|rgb| lab_from_xyz(Primaries::SRGB.xyz_from_rgb(rgb), WHITE));
                Course::Lab { low, high }
            }
        };
        Self { low: ends[0], high: ends[1], course }
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
        let rgb = match self.course {
            Course::Rgb => [0, 1, 2].map(|channel| mix(self.low[channel], self.high[channel], part)),
            Course::Hsv { low, high, arc } => rgb_from_hsv(Hsv {
                hue: low.hue.map(|hue| hue + arc * part),
                saturation: mix(low.saturation, high.saturation, part),
                value: mix(low.value, high.value, part),
            }),
            Course::Lab { low, high } => {
                let lab = Lab {
                    lightness: mix(low.lightness, high.lightness, part),
                    a: mix(low.a, high.a, part),
                    b: mix(low.b, high.b, part),
                };
                Primaries::SRGB.rgb_from_xyz(xyz_from_lab(lab, WHITE))
            }
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
        match self.course {
            Course::Rgb => [0, 1, 2].map(|channel| (self.high[channel] - self.low[channel]).abs()),
            Course::Hsv { low, high, arc } => {
                // Every channel is V, V(1−S), or V(1−S·t) with t the sixth of a turn, or 1 − t.
                let (value, saturation) = (low.value.max(high.value), low.saturation.max(high.saturation));
                let most = (high.value - low.value).abs()
                    + value * (high.saturation - low.saturation).abs()
                    + value * saturation * arc.abs() / 60.0;
                [most; 3]
            }
            Course::Lab { low, high } => {
                // Every channel is a sum of cubes, or of straight lines no steeper than these where the cubes begin, of the
                // cube roots of X, Y and Z; they are straight in Lab.
                let [from, to] = [low, high].map(cube_roots);
                let steepest = [0, 1, 2].map(|i| {
                    let root = from[i].abs().max(to[i].abs()).max(LAB_DELTA);
                    WHITE[i] * 3.0 * root * root * (to[i] - from[i]).abs()
                });
                let channels = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
                let by_xyz = channels.map(|xyz| Primaries::SRGB.rgb_from_xyz(xyz));
                [0, 1, 2].map(|channel| (0..3).map(|i| by_xyz[i][channel].abs() * steepest[i]).sum())
            }
        }
    }
}

/// HSV of the colors at their full, and from it that of the lights: black keeps hue and saturation.
fn hsv_course(color: StimulusColor, low: f64, color_high: StimulusColor, high: f64) -> Course {
    let [mut low, mut high] = [(color, low), (color_high, high)].map(|(color, level)| {
        let hsv = hsv_from_rgb(color.rgb());
        Hsv { value: hsv.value * level, ..hsv }
    });
    low.hue = low.hue.or(high.hue);
    high.hue = high.hue.or(low.hue);
    let turn = wrapped_deg(high.hue.unwrap_or(0.0) - low.hue.unwrap_or(0.0));
    Course::Hsv { low, high, arc: if turn > 180.0 { turn - 360.0 } else { turn } }
}

fn mix(from: f64, to: f64, part: f64) -> f64 {
    from + (to - from) * part
}

const WHITE: [f64; 3] = Primaries::SRGB.white_xyz();
