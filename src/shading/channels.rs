//! Whether red, green and blue are one.

use glam::DVec3;

use super::number::Constant;

/// Which channels are shaded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Channels {
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
    pub fn pick<T: Constant, const C: usize>(self, light: DVec3) -> [T; C] {
        let (light, first) = (light.to_array(), self.first());
        std::array::from_fn(|c| T::of(light[(first + c) % 3]))
    }
}
