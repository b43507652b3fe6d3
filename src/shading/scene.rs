//! A scene in few numbers: what a command, a definition and the pane let people set.

use glam::DVec3;

use super::{
    frame::Frame,
    illumination::{Lamp, LampPlace, Lighting},
    surface::Surface,
    view::View,
};

/// A surface of one colour, turned before one lamp.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scene {
    /// Degrees about x, then y, then z; see [`View::rotated`].
    pub rotate_deg: [f64; 3],
    /// Toward the lamp, in eye space (x right, y up, z to the viewer); any length above 0.
    pub light: DVec3,
    /// O_d of red, green and blue, 0…1.
    pub color: DVec3,
    /// Light of the surface where the lamp does not reach, k_a·I_a.
    pub ambient: f64,
    /// Light that the lamp adds where it falls straight on the surface, k_d·I_p.
    pub diffuse: f64,
    /// Light of the highlight's middle, k_s·I_p.
    pub specular: f64,
    /// m, the exponent of the highlight.
    pub shininess: f64,
    /// Light around the surface, in its colour.
    pub background: f64,
    /// How much of the smaller side of the window the bounding sphere fills.
    pub fill: f64,
    /// Distance of the eye in radii of the bounding sphere; infinite for a parallel projection.
    pub distance: f64,
}

impl Default for Scene {
    /// A dull gray surface, seen and lit obliquely, with a small highlight.
    fn default() -> Self {
        Self {
            rotate_deg: [25.0, -35.0, 0.0],
            light: DVec3::new(0.36, 0.48, 0.8),
            color: DVec3::ONE,
            ambient: 0.1,
            diffuse: 0.6,
            specular: 0.2,
            shininess: 20.0,
            background: 0.05,
            fill: 0.9,
            distance: f64::INFINITY,
        }
    }
}

impl Scene {
    /// What lights the surface.
    #[must_use]
    pub fn lighting(&self) -> Lighting {
        let mut lighting = Lighting::standard();
        lighting.material.color = self.color;
        // The highlight too has the colour: a yellow stimulus has no blue anywhere.
        lighting.material.specular_color = self.color;
        lighting.material.ambient = self.ambient;
        lighting.material.diffuse = self.diffuse;
        lighting.material.specular = self.specular;
        lighting.material.shininess = self.shininess;
        lighting.ambient = DVec3::ONE;
        lighting.lamps =
            vec![Lamp { place: LampPlace::Direction(self.light.normalize_or(DVec3::Z)), intensity: DVec3::ONE }];
        lighting
    }

    /// From where it is seen, in a window of `width` × `height` pixels.
    #[must_use]
    pub fn view(&self, width: u32, height: u32) -> View {
        View { width, height, fill: self.fill, distance: self.distance, ..View::square(1) }.rotated(self.rotate_deg)
    }

    /// `surface` seen and lit, in a window of `width` × `height` pixels.
    #[must_use]
    pub fn frame(&self, surface: &Surface, width: u32, height: u32) -> Frame {
        Frame::new(surface, &self.view(width, height), &self.lighting(), self.color * self.background)
    }
}
