//! Refraction of light that enters another medium, and transparency of surfaces. Shoaff §4.4.

use glam::DVec3;

/// What happens to a ray of light at the boundary between two media.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Refraction {
    /// The ray crosses the boundary along the unit vector T, away from the surface.
    Transmitted(DVec3),
    /// Total internal reflection: no light passes; all of it leaves along the unit vector R, the mirror image of L.
    TotalReflection(DVec3),
    /// There is no result because a vector does not have unit length or the ratio of the indices is not a finite number
    /// above 0.
    Undefined,
}

/// The tolerance for the length of a unit vector.
const UNIT: f64 = 1e-6;

impl Refraction {
    /// Returns T = (η·cos θ_i − cos θ_t)·N − η·L with cos θ_t = √(1 − η²(1 − cos²θ_i)), for a ray from the direction
    /// `to_source` (L) at a surface with the normal `normal` (N), both of unit length. `ratio` is η = η_i/η_t, the
    /// index of the medium that the light comes from, divided by the index of the medium that it enters.
    ///
    /// If N points to the far side of the surface, it is reversed: the light always comes from the medium on L's side.
    pub fn of(to_source: DVec3, normal: DVec3, ratio: f64) -> Refraction {
        // The negated condition rejects NaN.
        let unit = |v: DVec3| (v.length() - 1.0).abs() <= UNIT;
        if !(unit(to_source) && unit(normal) && ratio > 0.0 && ratio.is_finite()) {
            return Refraction::Undefined;
        }
        let facing = normal.dot(to_source);
        let (cos_i, normal) = if facing < 0.0 { (-facing, -normal) } else { (facing, normal) };
        let sin_t = ratio * to_source.cross(normal).length();
        if sin_t > 1.0 {
            return Refraction::TotalReflection(2.0 * cos_i * normal - to_source);
        }
        let cos_t = ((1.0 - sin_t) * (1.0 + sin_t)).sqrt();
        Refraction::Transmitted((ratio * cos_i - cos_t) * normal - ratio * to_source)
    }
}

/// How a surface transmits light from behind it, without refraction.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Transparency {
    /// The surface transmits no light.
    #[default]
    Opaque,
    /// Interpolated: (1 − k_t)·I_1 + k_t·I_2, as seen through a fine mesh; the surface's own light decreases as k_t
    /// increases.
    Interpolated {
        /// k_t, the transmission coefficient, 0 (opaque) … 1 (invisible).
        k_t: f64,
    },
    /// Filtered: I_1 + k_t·O_t·I_2, as seen through colored glass; the surface's own light stays the same. The sum can
    /// exceed 1.
    Filtered {
        /// k_t, the transmission coefficient, 0 (opaque) … 1.
        k_t: f64,
        /// O_t, the transparency color: red, green and blue, 0…1.
        color: DVec3,
    },
}

impl Transparency {
    /// Returns the linear red, green and blue light of a surface that itself sends `front` (I_1), in front of a surface
    /// that sends `behind` (I_2). For several surfaces, apply this from the farthest to the nearest.
    pub fn through(&self, front: DVec3, behind: DVec3) -> DVec3 {
        match *self {
            Transparency::Opaque => front,
            Transparency::Interpolated { k_t } => (1.0 - k_t) * front + k_t * behind,
            Transparency::Filtered { k_t, color } => front + k_t * color * behind,
        }
    }
}
