//! The light of one lamp that a surface sends to the eye, Shoaff §3, for any [`Number`] of pixels.

use glam::DVec3;

use super::{
    lamp::{Lamp, LampPlace},
    material::{Material, Specular},
};
use crate::shading::{
    channels::Channels,
    number::{Constant, Number, all, dot, power, unit},
};

/// Largest exponent of a highlight that is a power of an f32; the f32 of a sharper one lacks digits.
const LARGEST_EXPONENT: f64 = 128.0;

/// A lamp, and what the surface does with its light: I_p·k_d·O_d and I_p·k_s·O_s.
#[derive(Clone, Debug)]
pub struct Reflection<T, const C: usize> {
    place: Place<T>,
    diffuse: [T; C],
    specular: [T; C],
    highlight: Highlight<C>,
}

#[derive(Clone, Copy, Debug)]
enum Place<T> {
    Far([T; 3]),
    Near { at: [T; 3], attenuation: [T; 3] },
}

/// s, the highlight before k_s and O_s.
#[derive(Clone, Copy, Debug)]
enum Highlight<const C: usize> {
    Absent,
    /// A power of a cosine.
    Power {
        blinn: bool,
        exponent: u32,
    },
    /// Any other, pixel by pixel in f64.
    Any {
        model: Specular,
        shininess: f64,
        channels: Channels,
    },
}

impl<T: Constant, const C: usize> Reflection<T, C> {
    /// What a surface of `material` makes of `lamp`, in the channels that are shaded.
    pub fn new(lamp: &Lamp, material: &Material, channels: Channels) -> Self {
        let vector = |v: DVec3| v.to_array().map(T::of);
        let m = material.shininess;
        Reflection {
            place: match lamp.place {
                LampPlace::Direction(toward) => Place::Far(vector(toward)),
                LampPlace::Point { position, attenuation } => {
                    Place::Near { at: vector(position), attenuation: attenuation.map(T::of) }
                }
            },
            diffuse: channels.pick(lamp.intensity * material.color * material.diffuse),
            specular: channels.pick(lamp.intensity * material.specular_color * material.specular),
            highlight: match material.specular_model {
                _ if material.specular == 0.0 => Highlight::Absent,
                Specular::Phong | Specular::Blinn if m.fract() == 0.0 && (1.0..=LARGEST_EXPONENT).contains(&m) => {
                    Highlight::Power { blinn: material.specular_model == Specular::Blinn, exponent: m as u32 }
                }
                model => Highlight::Any { model, shininess: m, channels },
            },
        }
    }

    /// Whether it depends on where the surface is.
    pub fn is_near(&self) -> bool {
        matches!(self.place, Place::Near { .. })
    }

    /// f_att·I_p·(k_d·O_d·(N·L) + k_s·O_s·s) where N·L is above 0, for the place, the unit normal N and the unit vector V
    /// toward the viewer.
    #[inline(always)]
    pub fn light<N: Number<Constant = T>>(&self, place: [N; 3], normal: [N; 3], to_viewer: [N; 3]) -> [N; C] {
        let zero = normal[0].of(0.0);
        let (to_lamp, strength) = match &self.place {
            Place::Far(toward) => (all(zero, toward), zero.of(1.0)),
            Place::Near { at, attenuation: factors } => {
                let at = all(zero, at);
                let (toward, distance) = unit([at[0] - place[0], at[1] - place[1], at[2] - place[2]]);
                (toward, attenuation(*factors, distance))
            }
        };
        let cosine = dot(normal, to_lamp);
        let highlight = self.highlight.light(normal, to_lamp, to_viewer);
        let lit = zero.below(cosine);
        let mut light = [zero; C];
        for c in 0..C {
            let reflected = cosine.times(self.diffuse[c]) + highlight[c].times(self.specular[c]);
            light[c] = N::select(lit, reflected * strength, zero);
        }
        light
    }
}

/// f_att = 1/(c1 + c2·d + c3·d²), at most 1, at the distance d = `distance` ≥ 0 from a lamp. Shoaff §3.2, which prints
/// max(…, 1) where at most 1 is meant: with it a lamp would never weaken.
#[must_use]
#[inline(always)]
pub fn attenuation<N: Number>([c1, c2, c3]: [N::Constant; 3], distance: N) -> N {
    let weaker = (distance.times(c3) + distance.all(c2)) * distance + distance.all(c1);
    (distance.of(1.0) / weaker).min(distance.of(1.0))
}

/// Phong's R·V, R the mirror image of L, or Blinn's N·H, H halfway between L and V; at least 0. Shoaff §3.3, §3.6.
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
                    // Rounded vectors are not of unit length, which sharp highlights show.
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
