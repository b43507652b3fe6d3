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
    /// Filtered: I_1 + k_t·O_t·I_2, as through coloured glass; the surface's own light stays. Can exceed 1.
    Filtered {
        /// k_t, the transmission coefficient, 0 (opaque) … 1.
        k_t: f64,
        /// O_t, the transparency colour: of red, green and blue, 0…1.
        color: DVec3,
    },
}

/// A transparency that makes no sense.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum TransparencyError {
    /// A coefficient that is none.
    #[error("transmission coefficient k_t is {0}; expected a number within 0…1")]
    Coefficient(f64),
    /// A colour that is none.
    #[error("transparency colour is {0}; expected red, green and blue, each within 0…1")]
    Color(DVec3),
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

    /// Whether coefficient and colour make sense.
    ///
    /// # Errors
    /// When k_t or a component of O_t is outside 0…1 or not a number.
    pub fn validate(&self) -> Result<(), TransparencyError> {
        let (k_t, color) = match *self {
            Transparency::Opaque => (0.0, DVec3::ONE),
            Transparency::Interpolated { k_t } => (k_t, DVec3::ONE),
            Transparency::Filtered { k_t, color } => (k_t, color),
        };
        if !(0.0..=1.0).contains(&k_t) {
            return Err(TransparencyError::Coefficient(k_t));
        }
        if !color.to_array().iter().all(|c| (0.0..=1.0).contains(c)) {
            return Err(TransparencyError::Color(color));
        }
        Ok(())
    }
}
