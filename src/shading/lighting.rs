//! The light that a point of a surface sends to the eye, Shoaff §3. The same function lights vertices and pixels:
//!
//! I = k_a·I_a·O_d + Σ f_att·I_p·[k_d·O_d·(N·L)⁺ + k_s·O_s·s], separately for red, green and blue,
//!
//! where s is the [`Highlight`]. Everything is evaluated in eye space, before the projection,
//! because the projection does not preserve angles. Light values are linear. Lamps cast no shadows. Transparency and
//! refraction are those of §4.4.

use std::f64::consts::PI;

use glam::DVec3;

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
    pub highlight: Highlight,
    /// The small mirrors, if the highlight has them.
    pub facets: Microfacets,
}

named! {
    /// The shape of a highlight.
    Highlight, HighlightError {
        /// (R·V)^m, where R is the lamp's mirror image. Shoaff §3.3 and §3.6.
        Phong = "phong",
        /// (N·H)^m, where H is halfway between lamp and viewer. Shoaff §3.6. In the plane of L and N, its angle is half of
        /// Phong's, so an equally sharp highlight needs about four times the exponent.
        Blinn = "blinn",
        /// A rough surface of small mirrors with Gaussian tilts. Shoaff §3.8.1.
        TorranceSparrow = "torrance-sparrow",
        /// Small mirrors with tilts that follow Beckmann's distribution.
        CookTorrance = "cook-torrance",
    }
}

impl Highlight {
    /// True if it is made of small mirrors.
    pub const fn has_mirrors(self) -> bool {
        matches!(self, Highlight::TorranceSparrow | Highlight::CookTorrance)
    }
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
    /// At a point; the light weakens with distance, see [`attenuation`].
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
    /// along the unit vector `to_viewer`, in eye space. See the [module](self) for the formula.
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
            (cosine * diffuse * color + material.shine(normal, to_lamp, to_viewer) * specular) * strength
        } else {
            DVec3::ZERO
        }
    }
}

impl Material {
    /// Returns s, the highlight before multiplication by k_s and O_s: a power of Phong's R·V, where R is the mirror image
    /// of L, or of Blinn's N·H, where H is halfway between L and V, or what small mirrors reflect. Shoaff §3.3, §3.6.
    fn shine(&self, normal: DVec3, to_lamp: DVec3, to_viewer: DVec3) -> DVec3 {
        if self.specular == 0.0 {
            return DVec3::ZERO;
        }
        let cosine = match self.highlight {
            Highlight::TorranceSparrow | Highlight::CookTorrance => {
                return self.facets.highlight(normal, to_lamp, to_viewer);
            }
            Highlight::Phong => 2.0 * normal.dot(to_lamp) * normal.dot(to_viewer) - to_lamp.dot(to_viewer),
            Highlight::Blinn => normal.dot((to_lamp + to_viewer).normalize_or_zero()),
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

/// A surface that consists of small mirrors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Microfacets {
    /// c1 of Torrance and Sparrow's distribution of the mirrors' tilts, [`gaussian`], 0 or more; with `None`, the
    /// distribution is Cook and Torrance's, [`beckmann`].
    pub c1: Option<f64>,
    /// m, the root mean square slope of the mirrors, 0.001…10: a small m is a smooth surface with a sharp highlight.
    /// For [`gaussian`], it is in radians.
    pub slope: f64,
    /// η of red, green and blue: the index of refraction of the material, divided by the index of the surrounding
    /// medium; 0.001…1000.
    pub index: DVec3,
}

impl Microfacets {
    /// Returns ρ_s·(N·L) = F·D·G/(π·(N·V)) for red, green and blue, which replaces (R·V)^m. All vectors have unit
    /// length: the normal N, L toward the lamp, and V toward the viewer. The result is zero if the lamp or the viewer
    /// is behind the surface. It is finite, but grows without bound as both directions approach the surface.
    ///
    /// The factor 1/π is from Shoaff and from Cook and Torrance. Conservation of energy requires ¼ instead, with
    /// another 1/π in the D of [`beckmann`]: the highlight is therefore four times as bright as in today's renderers,
    /// and k_s has to compensate.
    pub fn highlight(&self, normal: DVec3, to_lamp: DVec3, to_viewer: DVec3) -> DVec3 {
        let halfway = (to_lamp + to_viewer).normalize_or_zero();
        let (nl, nv) = (normal.dot(to_lamp), normal.dot(to_viewer));
        let (nh, vh) = (normal.dot(halfway), to_viewer.dot(halfway));
        // The condition is negated so that NaN gives no light. For two opposite directions, H is zero or pure rounding
        // error.
        if !(nl > 0.0 && nv > 0.0 && vh > 0.0) {
            return DVec3::ZERO;
        }
        let shape = self.distribution(nh) * geometry(nh, nv, nl, vh) / (PI * nv);
        let reflectance = DVec3::from_array(self.index.to_array().map(|index| fresnel(vh, index)));
        shape * reflectance
    }

    /// Returns D at the cosine N·H of a mirror's tilt β.
    pub fn distribution(&self, nh: f64) -> f64 {
        self.c1.map_or_else(|| beckmann(nh, self.slope), |c1| gaussian(nh, self.slope, c1))
    }
}

/// Torrance and Sparrow's D = c1·exp(−(β/m)²), where cos β = `nh` is within 0…1.
pub fn gaussian(nh: f64, slope: f64, c1: f64) -> f64 {
    let tilt = nh.clamp(0.0, 1.0).acos();
    c1 * (-(tilt / slope).powi(2)).exp()
}

/// Beckmann's D = exp(−(tan β/m)²)/(m²·cos⁴β), where cos β = `nh` is within 0…1. The integral of D·cos β over the
/// hemisphere is π: seen from above, the mirrors fill the surface.
pub fn beckmann(nh: f64, slope: f64) -> f64 {
    let cos2 = nh.clamp(0.0, 1.0).powi(2);
    let fall = (-(1.0 - cos2) / (cos2 * slope * slope)).exp();
    // The exponential falls faster than the fourth power, but 0/0 would be NaN.
    if fall > 0.0 { fall / (slope * slope * cos2 * cos2) } else { 0.0 }
}

/// The fraction of the mirrors that is neither hidden from the viewer nor in shadow, 0…1: G = min(1, 2(N·H)(N·V)/(V·H),
/// 2(N·H)(N·L)/(V·H)), for cosines within 0…1 and V·H above 0.
pub fn geometry(nh: f64, nv: f64, nl: f64, vh: f64) -> f64 {
    (2.0 * nh * nv.min(nl) / vh).clamp(0.0, 1.0)
}

/// The fraction F, 0…1, of unpolarized light that a smooth surface reflects, where `cosine` = L·H is within 0…1: F =
/// ½·(g−c)²/(g+c)²·(1 + \[c(g+c)−1\]²/\[c(g−c)+1\]²), g² = η² + c² − 1. Beyond the critical angle, F is 1.
///
/// `index` is η = η_t/η_i, the index of the reflecting medium divided by the index of the medium with the light.
/// Shoaff's formula has three errors: it uses η_i/η_t, which is right for the refraction vector but here turns glass
/// into air; it has c(g−c)−1 in the denominator, so that F is not 1 at grazing incidence; and its form with tangents
/// has a product where the quotient is meant.
pub fn fresnel(cosine: f64, index: f64) -> f64 {
    let c = cosine.clamp(0.0, 1.0);
    let g2 = index * index + c * c - 1.0;
    if g2 < 0.0 {
        return 1.0;
    }
    let g = g2.sqrt();
    // With η = 1 there is no boundary, so nothing is reflected; without this check, grazing incidence would give 0/0.
    if g == c {
        return 0.0;
    }
    let across = (g - c) / (g + c);
    let along = (c * (g + c) - 1.0) / (c * (g - c) + 1.0);
    (0.5 * across * across * (1.0 + along * along)).min(1.0)
}
