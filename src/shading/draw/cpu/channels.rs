//! Whether red, green and blue are one.

use glam::DVec3;

use super::plane::{Planes, Slopes};
use crate::shading::Frame;

/// Which channels are shaded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Channels {
    /// Red, green and blue.
    Color,
    /// One that stands for those that have any light; the others are dark. Gray pictures are so, and yellow ones.
    Gray([bool; 3]),
}

impl Channels {
    /// Those of a picture made of `lights`.
    pub fn of(lights: impl Iterator<Item = DVec3> + Clone) -> Channels {
        let lit = lights.clone().fold([false; 3], |lit, light| {
            let [r, g, b] = light.to_array().map(|l| l != 0.0);
            [lit[0] | r, lit[1] | g, lit[2] | b]
        });
        let first = Channels::Gray(lit).first();
        let mut lights = lights;
        if lights.all(|light| (0..3).all(|c| !lit[c] || light[c] == light[first])) {
            Channels::Gray(lit)
        } else {
            Channels::Color
        }
    }

    /// The first channel that is shaded.
    fn first(self) -> usize {
        match self {
            Channels::Color => 0,
            Channels::Gray(lit) => lit.iter().position(|lit| *lit).unwrap_or(0),
        }
    }

    /// The `C` channels of `light` that are shaded.
    pub fn pick<const C: usize>(self, light: DVec3) -> [f64; C] {
        let (light, first) = (light.to_array(), self.first());
        std::array::from_fn(|c| light[(first + c) % 3])
    }

    /// The same in f32.
    pub fn pick_f32<const C: usize>(self, light: DVec3) -> [f32; C] {
        self.pick(light).map(|light| light as f32)
    }

    /// The planes through the lights of the corners of triangle `t`.
    pub fn planes<const C: usize>(self, slopes: &Slopes, frame: &Frame, t: u32) -> Planes<C> {
        slopes.planes(frame.corners(t as usize).map(|v| self.pick(v.light)))
    }
}
