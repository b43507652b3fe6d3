//! Highlights of rough surfaces, modeled as small, randomly tilted mirrors. Shoaff §3.8.1, after Torrance and Sparrow,
//! Blinn, and Cook and Torrance.

use std::f64::consts::PI;

use glam::DVec3;

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
