//! Materials, lamps, and the light that a lit surface sends to the eye (Shoaff §3), for any type of [`Number`]: one
//! pixel or several at once.

use glam::DVec3;

use super::microfacets::Microfacets;
use crate::shading::number::{Channels, Constant, Number, all, dot, power, unit};

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

impl Material {
    /// A white material with k_a = 0.1, k_d = 0.6, k_s = 0.3, and Phong's highlight with m = 20. Under one white lamp
    /// and white ambient light, no point is brighter than 1.
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

    /// Makes a white lamp that is infinitely far away in the direction `toward`, a vector of any length above 0.
    pub fn directional(toward: DVec3) -> Lamp {
        Lamp { position: LampPosition::Direction(toward.normalize_or_zero()), intensity: DVec3::ONE }
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
    /// [`Material::standard`] under white ambient light and one distant white lamp to the right of, above and in front
    /// of the surface, toward (0.36, 0.48, 0.8).
    pub fn standard() -> Lighting {
        let lamp = Lamp::directional(DVec3::new(0.36, 0.48, 0.8));
        Lighting { material: Material::standard(), ambient: DVec3::ONE, lamps: vec![lamp] }
    }

    /// Returns the reflected ambient light: k_a·I_a·O_d. Shoaff §3.1.
    pub fn ambient_light(&self) -> DVec3 {
        self.material.ambient * self.ambient * self.material.color
    }

    /// Returns the linear red, green and blue light that a point at `position` with the unit normal `normal` sends
    /// along the unit vector `to_viewer`, in eye space. See the [module](super) for the formula.
    ///
    /// The result is finite for all valid lightings: a zero normal gives only the ambient light, and a lamp at
    /// `position` contributes nothing. The sum of several lamps can exceed 1.
    pub fn light(&self, position: DVec3, normal: DVec3, to_viewer: DVec3) -> DVec3 {
        let [position, normal, to_viewer] = [position, normal, to_viewer].map(|v| v.to_array());
        let of_lamp =
            |lamp| Reflection::new(lamp, &self.material, Channels::Color).light(position, normal, to_viewer, None);
        self.ambient_light() + self.lamps.iter().map(|lamp| DVec3::from_array(of_lamp(lamp))).sum::<DVec3>()
    }
}

/// The largest exponent of a highlight that is computed as a power of an f32; f32 is too imprecise for sharper
/// highlights.
const MAX_POWER_EXPONENT: f64 = 128.0;

/// A lamp and how the surface reflects its light: I_p·k_d·O_d and I_p·k_s·O_s.
#[derive(Clone, Debug)]
pub struct Reflection<T, const C: usize> {
    position: PreparedPosition<T>,
    diffuse: [T; C],
    specular: [T; C],
    highlight: Highlight<C>,
}

#[derive(Clone, Copy, Debug)]
enum PreparedPosition<T> {
    Far([T; 3]),
    Near { at: [T; 3], attenuation: [T; 3] },
}

/// s, the highlight before multiplication by k_s and O_s.
#[derive(Clone, Copy, Debug)]
enum Highlight<const C: usize> {
    Absent,
    /// A power of a cosine.
    Power {
        blinn: bool,
        exponent: u32,
    },
    /// Any other highlight, computed pixel by pixel in f64.
    Any {
        model: Specular,
        shininess: f64,
        channels: Channels,
    },
}

impl<T: Constant, const C: usize> Reflection<T, C> {
    /// Prepares `lamp` for a surface of `material`, in the channels that are shaded.
    pub fn new(lamp: &Lamp, material: &Material, channels: Channels) -> Self {
        let vector = |v: DVec3| v.to_array().map(T::of);
        let m = material.shininess;
        Reflection {
            position: match lamp.position {
                LampPosition::Direction(toward) => PreparedPosition::Far(vector(toward)),
                LampPosition::Point { position, attenuation } => {
                    PreparedPosition::Near { at: vector(position), attenuation: attenuation.map(T::of) }
                }
            },
            diffuse: channels.pick(lamp.intensity * material.color * material.diffuse),
            specular: channels.pick(lamp.intensity * material.specular_color * material.specular),
            highlight: match material.specular_model {
                _ if material.specular == 0.0 => Highlight::Absent,
                Specular::Phong | Specular::Blinn if m.fract() == 0.0 && (1.0..=MAX_POWER_EXPONENT).contains(&m) => {
                    Highlight::Power { blinn: material.specular_model == Specular::Blinn, exponent: m as u32 }
                }
                model => Highlight::Any { model, shininess: m, channels },
            },
        }
    }

    /// True if the light depends on the position of the surface.
    pub fn is_near(&self) -> bool {
        matches!(self.position, PreparedPosition::Near { .. })
    }

    /// Returns f_att·I_p·(k_d·O_d·(N·L) + k_s·O_s·s) where N·L is above 0, and 0 elsewhere, for a position, a unit
    /// normal N and a unit vector V toward the viewer. `color`, if given, multiplies O_d.
    #[inline(always)]
    pub fn light<N: Number<Constant = T>>(
        &self,
        position: [N; 3],
        normal: [N; 3],
        to_viewer: [N; 3],
        color: Option<[N; C]>,
    ) -> [N; C] {
        let zero = normal[0].of(0.0);
        let (to_lamp, strength) = match &self.position {
            PreparedPosition::Far(toward) => (all(zero, toward), zero.of(1.0)),
            PreparedPosition::Near { at, attenuation: factors } => {
                let at = all(zero, at);
                let (toward, distance) = unit([at[0] - position[0], at[1] - position[1], at[2] - position[2]]);
                (toward, attenuation(*factors, distance))
            }
        };
        let cosine = dot(normal, to_lamp);
        let highlight = self.highlight.light(normal, to_lamp, to_viewer);
        let lit = zero.below(cosine);
        let mut light = [zero; C];
        for c in 0..C {
            let mut diffuse = cosine.times(self.diffuse[c]);
            if let Some(color) = color {
                diffuse = diffuse * color[c];
            }
            let reflected = diffuse + highlight[c].times(self.specular[c]);
            light[c] = N::select(lit, reflected * strength, zero);
        }
        light
    }
}

/// f_att = 1/(c1 + c2·d + c3·d²), at most 1, at the distance d = `distance` ≥ 0 from a lamp. Shoaff §3.2, which prints
/// max(…, 1) although min is meant: with max, a lamp would never weaken.
#[inline(always)]
pub fn attenuation<N: Number>([c1, c2, c3]: [N::Constant; 3], distance: N) -> N {
    let weaker = (distance.times(c3) + distance.all(c2)) * distance + distance.all(c1);
    (distance.of(1.0) / weaker).min(distance.of(1.0))
}

/// Returns Phong's R·V, where R is the mirror image of L, or Blinn's N·H, where H is halfway between L and V;
/// never below 0. Shoaff §3.3, §3.6.
#[inline(always)]
fn shine<N: Number>(blinn: bool, normal: [N; 3], to_lamp: [N; 3], to_viewer: [N; 3]) -> N {
    let cosine = if blinn {
        let [l, v] = [to_lamp, to_viewer];
        dot(normal, unit([l[0] + v[0], l[1] + v[1], l[2] + v[2]]).0)
    } else {
        let (nl, nv) = (dot(normal, to_lamp), dot(normal, to_viewer));
        nl.of(2.0) * nl * nv - dot(to_lamp, to_viewer)
    };
    cosine.max(cosine.of(0.0))
}

impl<const C: usize> Highlight<C> {
    #[inline(always)]
    fn light<N: Number>(&self, normal: [N; 3], to_lamp: [N; 3], to_viewer: [N; 3]) -> [N; C] {
        match self {
            Highlight::Absent => [normal[0].of(0.0); C],
            Highlight::Power { blinn, exponent } => [power(shine(*blinn, normal, to_lamp, to_viewer), *exponent); C],
            Highlight::Any { model, shininess, channels } => {
                let [n, l, v] = [normal, to_lamp, to_viewer];
                N::each([n[0], n[1], n[2], l[0], l[1], l[2], v[0], v[1], v[2]], |numbers| {
                    // Rounded vectors do not have unit length, which would show in sharp highlights.
                    let [n, l, v] = [0, 3, 6].map(|i| DVec3::from_slice(&numbers[i..i + 3]).normalize_or_zero());
                    channels.pick(exact_highlight(*model, *shininess, n, l, v))
                })
            }
        }
    }
}

fn exact_highlight(model: Specular, shininess: f64, n: DVec3, l: DVec3, v: DVec3) -> DVec3 {
    let blinn = match model {
        Specular::CookTorrance(facets) => return facets.highlight(n, l, v),
        model => model == Specular::Blinn,
    };
    DVec3::splat(shine(blinn, n.to_array(), l.to_array(), v.to_array()).powf(shininess))
}
