//! Materials, lamps, and the light that a lit surface sends to the eye (Shoaff §3); transparency and refraction (§4.4).

use glam::DVec3;

use super::microfacets::Microfacets;
use crate::{light::interpolation::power, text::names::named};

/// How a surface reflects light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    /// O_d, the diffuse color: red, green and blue, 0…1.
    pub color: DVec3,
    /// O_s, the specular color: red, green and blue, 0…1. White for plastics; the metal's own color for metals.
    pub specular_color: DVec3,
    /// k_a, the fraction of the ambient light that is reflected, 0…1.
    pub ambient: f64,
    /// k_d, the fraction that is reflected equally in all directions, 0…1.
    pub diffuse: f64,
    /// k_s, the fraction that is reflected as a highlight, 0…1.
    pub specular: f64,
    /// m, the exponent of the Phong and Blinn highlights, above 0: 1 is broad, several hundred is sharp.
    pub shininess: f64,
    /// The shape of the highlight.
    pub specular_model: Specular,
}

/// The shape of a highlight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Specular {
    /// Phong: (R·V)^m, where R is the lamp's mirror image. Shoaff §3.3 and §3.6.
    Phong,
    /// Blinn: (N·H)^m, where H is halfway between lamp and viewer. Shoaff §3.6. In the plane of L and N, its angle is
    /// half of Phong's, so an equally sharp highlight needs about four times the exponent.
    Blinn,
    /// Torrance–Sparrow and Cook–Torrance: a rough surface of small mirrors. Shoaff §3.8.1.
    CookTorrance(Microfacets),
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lamp {
    /// The position of the lamp.
    pub position: LampPosition,
    /// I_p of red, green and blue, 0 or more.
    pub intensity: DVec3,
}

/// Position of a lamp in eye space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LampPosition {
    /// Infinitely far away; the unit vector points toward the lamp.
    Direction(DVec3),
    /// At a point; the light weakens with distance, see [`attenuation`](super::attenuation).
    Point {
        /// The position of the lamp.
        position: DVec3,
        /// c1, c2, c3: each 0 or more, not all 0. With `[1, 0, 0]`, the light does not weaken.
        attenuation: [f64; 3],
    },
}

impl Lamp {
    /// Returns a vector from a position toward the lamp, of any length.
    pub fn toward(&self, position: DVec3) -> DVec3 {
        match self.position {
            LampPosition::Direction(toward) => toward,
            LampPosition::Point { position: lamp, .. } => lamp - position,
        }
    }
}

/// A material, and the light that falls on it.
#[derive(Clone, Debug, PartialEq)]
pub struct Lighting {
    /// The material of the surface.
    pub material: Material,
    /// I_a of red, green and blue, 0 or more.
    pub ambient: DVec3,
    /// The lamps; their light adds up.
    pub lamps: Vec<Lamp>,
}

impl Lighting {
    /// Returns the reflected ambient light: k_a·I_a·O_d. Shoaff §3.1.
    pub fn ambient_light(&self) -> DVec3 {
        self.material.ambient * self.ambient * self.material.color
    }

    /// True if the light depends on the distance of the surface from a lamp.
    pub(crate) fn has_near_lamps(&self) -> bool {
        self.lamps.iter().any(|lamp| matches!(lamp.position, LampPosition::Point { .. }))
    }

    /// Returns the linear red, green and blue light that a point at `position` with the unit normal `normal` sends
    /// along the unit vector `to_viewer`, in eye space. See the [module](super) for the formula.
    ///
    /// The result is finite for all valid lightings: a zero normal gives only the ambient light, and a lamp at
    /// `position` contributes nothing. The sum of several lamps can exceed 1.
    pub fn light(&self, position: DVec3, normal: DVec3, to_viewer: DVec3) -> DVec3 {
        self.painted(position, normal, to_viewer, DVec3::ONE)
    }

    /// Returns the same for a point whose paint multiplies O_d by `color`.
    pub(crate) fn painted(&self, position: DVec3, normal: DVec3, to_viewer: DVec3, color: DVec3) -> DVec3 {
        let of_lamp = |lamp: &Lamp| self.of_lamp(lamp, position, normal, to_viewer, color);
        self.lamps.iter().map(of_lamp).fold(self.ambient_light() * color, |sum, light| sum + light)
    }

    /// Returns f_att·I_p·(k_d·O_d·(N·L) + k_s·O_s·s) if N·L is above 0, and otherwise 0.
    fn of_lamp(&self, lamp: &Lamp, position: DVec3, normal: DVec3, to_viewer: DVec3, color: DVec3) -> DVec3 {
        let (to_lamp, strength) = match lamp.position {
            LampPosition::Direction(toward) => (toward, 1.0),
            LampPosition::Point { attenuation: factors, .. } => {
                let toward = lamp.toward(position);
                (toward.normalize_or_zero(), attenuation(factors, toward.length()))
            }
        };
        let (material, cosine) = (&self.material, normal.dot(to_lamp));
        // Also false for NaN.
        if cosine > 0.0 {
            let diffuse = lamp.intensity * material.color * material.diffuse;
            let specular = lamp.intensity * material.specular_color * material.specular;
            (cosine * diffuse * color + material.highlight(normal, to_lamp, to_viewer) * specular) * strength
        } else {
            DVec3::ZERO
        }
    }
}

impl Material {
    /// Returns s, the highlight before multiplication by k_s and O_s: a power of Phong's R·V, where R is the mirror image
    /// of L, or of Blinn's N·H, where H is halfway between L and V, or what small mirrors reflect. Shoaff §3.3, §3.6.
    fn highlight(&self, normal: DVec3, to_lamp: DVec3, to_viewer: DVec3) -> DVec3 {
        if self.specular == 0.0 {
            return DVec3::ZERO;
        }
        let cosine = match self.specular_model {
            Specular::CookTorrance(facets) => return facets.highlight(normal, to_lamp, to_viewer),
            Specular::Phong => 2.0 * normal.dot(to_lamp) * normal.dot(to_viewer) - to_lamp.dot(to_viewer),
            Specular::Blinn => normal.dot((to_lamp + to_viewer).normalize_or_zero()),
        };
        let (cosine, m) = (cosine.max(0.0), self.shininess);
        // Products are the same on every machine.
        let is_whole = m.fract() == 0.0 && (1.0..=MAX_POWER_EXPONENT).contains(&m);
        DVec3::splat(if is_whole { power(cosine, m as usize) } else { cosine.powf(m) })
    }
}

/// The largest exponent of a highlight that is computed by multiplying.
const MAX_POWER_EXPONENT: f64 = 128.0;

/// f_att = 1/(c1 + c2·d + c3·d²), at most 1, at the distance d = `distance` ≥ 0 from a lamp. Shoaff §3.2, which prints
/// max(…, 1) although min is meant: with max, a lamp would never weaken.
pub fn attenuation([c1, c2, c3]: [f64; 3], distance: f64) -> f64 {
    (1.0 / ((distance * c3 + c2) * distance + c1)).min(1.0)
}

/// What happens to a ray of light at the boundary between two media.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Refraction {
    /// The ray crosses the boundary along the unit vector T, away from the surface.
    Transmitted(DVec3),
    /// Total internal reflection: no light passes; all of it leaves along the unit vector R, the mirror image of L.
    TotalReflection(DVec3),
}

impl Refraction {
    /// Returns T = (η·cos θ_i − cos θ_t)·N − η·L with cos θ_t = √(1 − η²(1 − cos²θ_i)), for a ray from the direction
    /// `to_source` (L) at a surface with the normal `normal` (N), both of unit length. `ratio` is η = η_i/η_t, the
    /// index of the medium that the light comes from, divided by the index of the medium that it enters.
    ///
    /// If N points to the far side of the surface, it is reversed: the light always comes from the medium on L's side.
    pub fn of(to_source: DVec3, normal: DVec3, ratio: f64) -> Refraction {
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

named! {
    /// Which of the two formulas of transparency applies.
    Transmits, UnknownTransparency {
        /// No light passes.
        Opaque = "opaque",
        /// (1 − k_t)·I_1 + k_t·I_2, as seen through a fine mesh; the surface's own light decreases as k_t increases.
        Interpolated = "interpolated",
        /// I_1 + k_t·O_t·I_2, as seen through colored glass; the surface's own light stays the same. The sum can exceed 1.
        Filtered = "filtered",
    }
}

/// How a surface transmits light from behind it, without refraction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transparency {
    /// The formula.
    pub kind: Transmits,
    /// k_t, the transmission coefficient, 0 (opaque) … 1.
    pub k_t: f64,
    /// O_t, the transparency color: red, green and blue, 0…1.
    pub color: DVec3,
}

impl Transparency {
    /// Returns the linear red, green and blue light of a surface that itself sends `front` (I_1), in front of a surface
    /// that sends `behind` (I_2). For several surfaces, apply this from the farthest to the nearest.
    pub fn through(&self, front: DVec3, behind: DVec3) -> DVec3 {
        match self.kind {
            Transmits::Opaque => front,
            Transmits::Interpolated => (1.0 - self.k_t) * front + self.k_t * behind,
            Transmits::Filtered => front + self.k_t * self.color * behind,
        }
    }
}
