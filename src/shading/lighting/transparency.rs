//! A surface through which another one is seen. Shoaff §4.4.

use glam::DVec3;

/// How a surface lets through the light of what is behind it. Not refracted: what is behind stays in its place.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Transparency {
    /// Not at all.
    #[default]
    Opaque,
    /// Interpolated: (1 − k_t)·I_1 + k_t·I_2, as through a fine mesh; the surface's own light weakens as it clears.
    Interpolated {
        /// k_t, the transmission coefficient, 0 (opaque) … 1 (invisible).
        k_t: f64,
    },
    /// Filtered: I_1 + k_t·O_t·I_2, as through colored glass; the surface's own light stays. Can exceed 1.
    Filtered {
        /// k_t, the transmission coefficient, 0 (opaque) … 1.
        k_t: f64,
        /// O_t, the transparency color: of red, green and blue, 0…1.
        color: DVec3,
    },
}

impl Transparency {
    /// The light of a surface that sends `front`, I_1, itself, before one that sends `behind`, I_2: linear, of red,
    /// green and blue. For several surfaces, from the farthest to the nearest.
    #[must_use]
    pub fn through(&self, front: DVec3, behind: DVec3) -> DVec3 {
        match *self {
            Transparency::Opaque => front,
            Transparency::Interpolated { k_t } => (1.0 - k_t) * front + k_t * behind,
            Transparency::Filtered { k_t, color } => front + k_t * color * behind,
        }
    }
}
