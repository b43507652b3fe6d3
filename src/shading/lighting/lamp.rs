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
    /// At a point, and weaker with distance: see [`attenuation`](super::attenuation).
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
}
