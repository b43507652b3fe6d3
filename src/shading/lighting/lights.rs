//! A material under lamps.

use glam::DVec3;

use super::{lamp::Lamp, material::Material, reflection::Reflection};
use crate::shading::channels::Channels;

/// A material under lamps.
#[derive(Clone, Debug, PartialEq)]
pub struct Lighting {
    /// The surface.
    pub material: Material,
    /// I_a of red, green and blue, 0 or more.
    pub ambient: DVec3,
    /// The lamps; their lights add up.
    pub lamps: Vec<Lamp>,
}

impl Lighting {
    /// [`Material::standard`] under white ambient light and one white lamp far away, to the right, above and before
    /// the surface, toward (0.36, 0.48, 0.8).
    #[must_use]
    pub fn standard() -> Lighting {
        let lamp = Lamp::directional(DVec3::new(0.36, 0.48, 0.8));
        Lighting { material: Material::standard(), ambient: DVec3::ONE, lamps: vec![lamp] }
    }

    /// The same with one white lamp far away in the direction `toward`, of any length above 0, in place of all lamps.
    #[must_use]
    pub fn with_direction(mut self, toward: DVec3) -> Lighting {
        self.lamps = vec![Lamp::directional(toward)];
        self
    }

    /// The same with the diffuse color O_d.
    #[must_use]
    pub fn with_color(mut self, color: DVec3) -> Lighting {
        self.material.color = color;
        self
    }

    /// The part of the light that comes from everywhere: k_a·I_a·O_d. Shoaff §3.1.
    #[must_use]
    pub fn ambient_light(&self) -> DVec3 {
        self.material.ambient * self.ambient * self.material.color
    }

    /// The light that a point at `position` with the unit normal `normal` sends along the unit vector `to_viewer`, of
    /// red, green and blue, linear, in eye space; see the [module](super) for the formula.
    ///
    /// Finite for every lighting whose numbers make sense: only the ambient light at a zero normal, and nothing from a
    /// lamp that stands at `position`. A sum of several lamps can exceed 1.
    #[must_use]
    pub fn light(&self, position: DVec3, normal: DVec3, to_viewer: DVec3) -> DVec3 {
        let [place, normal, to_viewer] = [position, normal, to_viewer].map(|v| v.to_array());
        let of_lamp = |lamp| Reflection::new(lamp, &self.material, Channels::Color).light(place, normal, to_viewer);
        self.ambient_light() + self.lamps.iter().map(|lamp| DVec3::from_array(of_lamp(lamp))).sum::<DVec3>()
    }
}
