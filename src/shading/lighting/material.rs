//! How a surface reflects the light of one lamp.

use glam::DVec3;

use super::microfacets::Microfacets;

/// How a surface reflects light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    /// O_d, the diffuse color: of red, green and blue, 0…1.
    pub color: DVec3,
    /// O_s, the specular color: of red, green and blue, 0…1. White for plastics; the metal's color for metals.
    pub specular_color: DVec3,
    /// k_a, how much of the ambient light is reflected, 0…1.
    pub ambient: f64,
    /// k_d, how much is reflected in all directions alike, 0…1.
    pub diffuse: f64,
    /// k_s, how much is reflected as a highlight, 0…1.
    pub specular: f64,
    /// m, the exponent of Phong's and Blinn's highlight, above 0: 1 is broad, several hundred is sharp.
    pub shininess: f64,
    /// The shape of the highlight.
    pub specular_model: Specular,
}

/// The shape of a highlight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Specular {
    /// Phong: (R·V)^m, R the lamp's mirror image. Shoaff §3.3 and §3.6.
    Phong,
    /// Blinn: (N·H)^m, H halfway between lamp and viewer. Shoaff §3.6. In the plane of L and N its angle is half of
    /// Phong's, so that about four times the exponent makes as sharp a highlight.
    Blinn,
    /// Torrance–Sparrow and Cook–Torrance: a rough surface of small mirrors. Shoaff §3.8.1.
    CookTorrance(Microfacets),
}

impl Material {
    /// White, k_a = 0.1, k_d = 0.6, k_s = 0.3, Phong's highlight with m = 20: under one white lamp and white ambient
    /// light no point is brighter than 1.
    #[must_use]
    pub const fn standard() -> Material {
        Material {
            color: DVec3::ONE,
            specular_color: DVec3::ONE,
            ambient: 0.1,
            diffuse: 0.6,
            specular: 0.3,
            shininess: 20.0,
            specular_model: Specular::Phong,
        }
    }
}
