//! What a surface does with the light of one lamp.

use glam::DVec3;

use super::microfacets::Microfacets;

/// What a surface does with light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    /// O_d, the diffuse colour: of red, green and blue, 0…1.
    pub color: DVec3,
    /// O_s, the specular colour: of red, green and blue, 0…1. White for plastics; the metal's colour for metals.
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

    /// How much of the light from a lamp goes to the viewer, of red, green and blue: k_d·O_d·(N·L) + k_s·O_s·s,
    /// Shoaff §3.4. All three vectors of unit length: the normal N, L toward the lamp, V toward the viewer.
    ///
    /// Nothing for a lamp behind the surface, not even a highlight; nor for a zero N or L.
    #[must_use]
    pub fn reflected(&self, normal: DVec3, to_lamp: DVec3, to_viewer: DVec3) -> DVec3 {
        let cosine = normal.dot(to_lamp);
        // Written so that NaN reflects nothing.
        if cosine > 0.0 {
            let highlight = self.highlight(normal, to_lamp, to_viewer);
            self.diffuse * cosine * self.color + self.specular * self.specular_color * highlight
        } else {
            DVec3::ZERO
        }
    }

    /// s: the highlight before k_s and O_s, for N·L > 0.
    fn highlight(&self, normal: DVec3, to_lamp: DVec3, to_viewer: DVec3) -> DVec3 {
        match self.specular_model {
            Specular::Phong => {
                let mirrored = 2.0 * normal.dot(to_lamp) * normal - to_lamp;
                DVec3::splat(mirrored.dot(to_viewer).max(0.0).powf(self.shininess))
            }
            Specular::Blinn => {
                let halfway = (to_lamp + to_viewer).normalize_or_zero();
                DVec3::splat(normal.dot(halfway).max(0.0).powf(self.shininess))
            }
            Specular::CookTorrance(facets) => facets.highlight(normal, to_lamp, to_viewer),
        }
    }
}

impl Default for Material {
    fn default() -> Material {
        Material::standard()
    }
}
