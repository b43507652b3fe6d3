//! Highlights of rough surfaces: small mirrors, tilted at random. Shoaff §3.8.1, after Torrance and Sparrow, Blinn,
//! Cook and Torrance.

use std::f64::consts::PI;

use glam::DVec3;

/// A surface of small mirrors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Microfacets {
    /// How the mirrors are tilted.
    pub facets: Facets,
    /// m, the root mean square slope of the mirrors, 0.001…10: small is smooth, with a sharp highlight. For
    /// [`Facets::Gaussian`] it is in radians.
    pub slope: f64,
    /// η of red, green and blue: the index of refraction of the material over that of the medium around it,
    /// 0.001…1000.
    pub index: DVec3,
}

/// D: how many of the mirrors face a direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Facets {
    /// Torrance and Sparrow, [`gaussian`] with the free constant c1, 0 or more.
    Gaussian {
        /// c1.
        c1: f64,
    },
    /// Cook and Torrance, [`beckmann`].
    Beckmann,
}

impl Microfacets {
    /// ρ_s·(N·L) = F·D·G/(π·(N·V)), of red, green and blue: what takes the place of (R·V)^m. All vectors of unit
    /// length: the normal N, L toward the lamp, V toward the viewer. Zero where lamp or viewer are behind the surface.
    /// Finite, but without bound where both look along it.
    ///
    /// The 1/π is Shoaff's, and Cook and Torrance's. Conservation of energy asks for ¼ where [`beckmann`]'s D has a 1/π
    /// of its own: the highlight is four times that of today's renderers, and k_s has to make up for it.
    #[must_use]
    pub fn highlight(&self, normal: DVec3, to_lamp: DVec3, to_viewer: DVec3) -> DVec3 {
        let halfway = (to_lamp + to_viewer).normalize_or_zero();
        let (nl, nv) = (normal.dot(to_lamp), normal.dot(to_viewer));
        let (nh, vh) = (normal.dot(halfway), to_viewer.dot(halfway));
        // Written so that NaN gives no light. H of two opposite directions is zero, or all rounding.
        if !(nl > 0.0 && nv > 0.0 && vh > 0.0) {
            return DVec3::ZERO;
        }
        let shape = self.distribution(nh) * geometry(nh, nv, nl, vh) / (PI * nv);
        let reflectance = DVec3::from_array(self.index.to_array().map(|index| fresnel(vh, index)));
        shape * reflectance
    }

    /// D at the cosine N·H of a mirror's tilt β.
    #[must_use]
    pub fn distribution(&self, nh: f64) -> f64 {
        match self.facets {
            Facets::Gaussian { c1 } => gaussian(nh, self.slope, c1),
            Facets::Beckmann => beckmann(nh, self.slope),
        }
    }
}

/// Torrance and Sparrow's D = c1·exp(−(β/m)²), cos β = `nh` within 0…1.
#[must_use]
pub fn gaussian(nh: f64, slope: f64, c1: f64) -> f64 {
    let tilt = nh.clamp(0.0, 1.0).acos();
    c1 * (-(tilt / slope).powi(2)).exp()
}

/// Beckmann's D = exp(−(tan β/m)²)/(m²·cos⁴β), cos β = `nh` within 0…1. The integral of D·cos β over the hemisphere is
/// π: the mirrors, seen from above, fill the surface.
#[must_use]
pub fn beckmann(nh: f64, slope: f64) -> f64 {
    let cos2 = nh.clamp(0.0, 1.0).powi(2);
    let fall = (-(1.0 - cos2) / (cos2 * slope * slope)).exp();
    // The exponential wins over the fourth power, but ∞·0 would be NaN.
    if fall > 0.0 { fall / (slope * slope * cos2 * cos2) } else { 0.0 }
}

/// The part of the mirrors that is neither hidden from the viewer nor in shadow, 0…1:
/// G = min(1, 2(N·H)(N·V)/(V·H), 2(N·H)(N·L)/(V·H)), for cosines within 0…1 and V·H above 0.
#[must_use]
pub fn geometry(nh: f64, nv: f64, nl: f64, vh: f64) -> f64 {
    (2.0 * nh * nv.min(nl) / vh).clamp(0.0, 1.0)
}

/// The part F of unpolarized light that a smooth surface reflects, 0…1, `cosine` = L·H within 0…1:
/// F = ½·(g−c)²/(g+c)²·(1 + \[c(g+c)−1\]²/\[c(g−c)+1\]²), g² = η² + c² − 1. All of it beyond the critical angle.
///
/// η = η_t/η_i, `index`, is the index of the reflecting medium over that of the medium with the light. Shoaff prints
/// η_i/η_t, which is right for the refraction vector but here turns glass into air; and c(g−c)−1 in the denominator,
/// with which F is not 1 at grazing; and its form with tangents has a product where their quotient is meant.
#[must_use]
pub fn fresnel(cosine: f64, index: f64) -> f64 {
    let c = cosine.clamp(0.0, 1.0);
    let g2 = index * index + c * c - 1.0;
    if g2 < 0.0 {
        return 1.0;
    }
    let g = g2.sqrt();
    // Nothing reflects where there is no surface; without this η = 1 would be 0/0 at grazing.
    if g == c {
        return 0.0;
    }
    let across = (g - c) / (g + c);
    let along = (c * (g + c) - 1.0) / (c * (g - c) + 1.0);
    (0.5 * across * across * (1.0 + along * along)).min(1.0)
}
