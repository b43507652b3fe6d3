//! A scene described by a few numbers that commands, definitions, and the window can set.

use glam::DVec3;

use super::projected::{Frame, View};
use crate::shading::{
    lighting::{Highlight, Lamp, LampPosition, Lighting, Material, Microfacets},
    mesh::Surface,
};

/// The small mirrors of a highlight, Shoaff §3.8.1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Mirrors {
    /// m, the root mean square slope; `None` makes the highlight as sharp as Blinn's, √(2/(shininess + 2)).
    pub slope: Option<f64>,
    /// c₁ of Torrance and Sparrow; with `None`, as many mirrors face along the normal as in Beckmann's distribution.
    pub c1: Option<f64>,
    /// η, the index of refraction. At normal incidence, the mirrors reflect F₀ = ((η − 1)/(η + 1))² of the light; with
    /// `None`, a quarter.
    pub index: Option<f64>,
}

impl Mirrors {
    /// Returns the mirrors of a highlight, for the exponent `shininess` of Phong's and Blinn's.
    pub fn facets(self, highlight: Highlight, shininess: f64) -> Microfacets {
        let slope = self.slope.unwrap_or_else(|| (2.0 / (shininess + 2.0)).sqrt());
        let c1 = self.c1.unwrap_or_else(|| 1.0 / (slope * slope));
        let c1 = (highlight == Highlight::TorranceSparrow).then_some(c1);
        Microfacets { c1, slope, index: DVec3::splat(self.index.unwrap_or(3.0)) }
    }
}

/// A surface of one color, rotated and lit by one lamp.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scene {
    /// Rotation in degrees about x, then y, then z; see [`View::rotated`].
    pub rotate_deg: [f64; 3],
    /// A vector toward the lamp in eye space (x right, y up, z to the viewer), of any length above 0.
    pub light: DVec3,
    /// O_d of red, green and blue, 0…1.
    pub color: DVec3,
    /// Ambient light, k_a·I_a.
    pub ambient: f64,
    /// Diffuse light at normal incidence, k_d·I_p.
    pub diffuse: f64,
    /// k_s·I_p, the light that Phong's or Blinn's highlight adds in its middle; small mirrors may add more or less.
    pub specular: f64,
    /// The shape of the highlight.
    pub highlight: Highlight,
    /// m, the exponent of the highlight; see [`Mirrors::facets`].
    pub shininess: f64,
    /// The small mirrors, if the highlight has them.
    pub mirrors: Mirrors,
    /// Background light, in the surface's color.
    pub background: f64,
    /// The share of the window's smaller side that the bounding sphere fills.
    pub fill: f64,
    /// Distance of the eye in radii of the bounding sphere; infinite for a parallel projection.
    pub distance: f64,
}

impl Default for Scene {
    /// A matte gray surface, viewed and lit obliquely, with a small highlight.
    fn default() -> Self {
        Self {
            rotate_deg: [25.0, -35.0, 0.0],
            light: DVec3::new(0.36, 0.48, 0.8),
            color: DVec3::ONE,
            ambient: 0.1,
            diffuse: 0.6,
            specular: 0.2,
            highlight: Highlight::Phong,
            shininess: 20.0,
            mirrors: Mirrors::default(),
            background: 0.05,
            fill: 0.9,
            distance: f64::INFINITY,
        }
    }
}

impl Scene {
    /// Returns the material and the lamp.
    pub fn lighting(&self) -> Lighting {
        let material = Material {
            color: self.color,
            // The highlight has the surface's color, too: a yellow stimulus has no blue anywhere.
            specular_color: self.color,
            ambient: self.ambient,
            diffuse: self.diffuse,
            specular: self.specular,
            shininess: self.shininess,
            highlight: self.highlight,
            facets: self.mirrors.facets(self.highlight, self.shininess),
        };
        // Whatever its length.
        let toward = (self.light / self.light.abs().max_element()).normalize_or(DVec3::Z);
        let lamp = Lamp { position: LampPosition::Direction(toward), intensity: DVec3::ONE };
        Lighting { material, ambient: DVec3::ONE, lamps: vec![lamp] }
    }

    /// Returns the view in a window of `width` × `height` pixels.
    pub fn view(&self, width: u32, height: u32) -> View {
        View { width, height, fill: self.fill, distance: self.distance, ..View::square(1) }.rotated(self.rotate_deg)
    }

    /// Projects and lights `surface` in a window of `width` × `height` pixels.
    pub fn frame(&self, surface: &Surface, width: u32, height: u32) -> Frame {
        Frame::new(surface, &self.view(width, height), &self.lighting(), self.color * self.background)
    }
}
