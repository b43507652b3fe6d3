//! Where light comes from.

use glam::DVec3;

/// A lamp.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lamp {
    /// Where it is.
    pub place: LampPlace,
    /// I_p of red, green and blue, 0 or more.
    pub intensity: DVec3,
}

/// Where a lamp is, in eye space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LampPlace {
    /// Far away; a unit vector toward it.
    Direction(DVec3),
    /// At a point, and weaker with distance: see [`attenuation`].
    Point {
        /// The point.
        position: DVec3,
        /// c1, c2, c3: each 0 or more, not all 0. `[1, 0, 0]` does not weaken.
        attenuation: [f64; 3],
    },
}

impl Lamp {
    /// A white lamp far away in the direction `toward`, of any length above 0.
    #[must_use]
    pub fn directional(toward: DVec3) -> Lamp {
        Lamp { place: LampPlace::Direction(toward.normalize_or_zero()), intensity: DVec3::ONE }
    }

    /// A white lamp at `position`, as strong far away as near.
    #[must_use]
    pub fn point(position: DVec3) -> Lamp {
        Lamp { place: LampPlace::Point { position, attenuation: [1.0, 0.0, 0.0] }, intensity: DVec3::ONE }
    }

    /// The same lamp with the intensity I_p of red, green and blue.
    #[must_use]
    pub fn with_intensity(self, intensity: DVec3) -> Lamp {
        Lamp { intensity, ..self }
    }

    /// The unit vector L from `position` toward the lamp, and the light f_att·I_p that arrives there. L is zero at the
    /// very place of the lamp.
    #[must_use]
    pub fn at(&self, position: DVec3) -> (DVec3, DVec3) {
        match self.place {
            LampPlace::Direction(toward) => (toward, self.intensity),
            LampPlace::Point { position: lamp, attenuation: c } => {
                let offset = lamp - position;
                (offset.normalize_or_zero(), attenuation(c, offset.length()) * self.intensity)
            }
        }
    }
}

/// f_att = 1/(c1 + c2·d + c3·d²), at most 1, at the distance d = `distance` ≥ 0 from a lamp. Shoaff §3.2, which prints
/// max(…, 1) where at most 1 is meant: with it a lamp would never weaken.
#[must_use]
pub fn attenuation([c1, c2, c3]: [f64; 3], distance: f64) -> f64 {
    (1.0 / (c1 + (c2 + c3 * distance) * distance)).min(1.0)
}
