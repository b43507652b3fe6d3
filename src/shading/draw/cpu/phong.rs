//! Phong shading: the normal interpolated, and lit at every pixel by far or near lamps, with Phong's or Blinn's highlight.

use glam::DVec3;
use pulp::Simd;

use super::{
    band::{Chunk, Rows},
    channels::Channels,
    lanes::{Lanes, add, each},
    plane::{Line, Planes, Slopes},
};
use crate::shading::{Frame, LampPlace, Specular};

/// Largest exponent of a highlight that f32 powers; sharper ones lose digits.
const LARGEST_EXPONENT: f64 = 128.0;

/// See [`shaders::phong`](crate::shading::shaders::phong).
#[derive(Clone, Debug)]
pub(super) struct Phong<const C: usize> {
    normals: Vec<Planes<3>>,
    /// Places in eye space; empty if only directions matter.
    places: Vec<Planes<3>>,
    ambient: [f32; C],
    lamps: Vec<Lamp<C>>,
    blinn: bool,
    exponent: u32,
    shines: bool,
    /// Where the eye is on the z axis, if not far away.
    eye: Option<f32>,
}

#[derive(Clone, Debug)]
struct Lamp<const C: usize> {
    place: Place,
    diffuse: [f32; C],
    specular: [f32; C],
}

#[derive(Clone, Copy, Debug)]
enum Place {
    /// Toward the lamp, and toward the highlight: the lamp's mirror image needs N·V and L·V, Blinn's halfway vector N·H.
    Far {
        toward: [f32; 3],
        halfway: [f32; 3],
    },
    Near {
        at: [f32; 3],
        attenuation: [f32; 3],
    },
}

impl<const C: usize> Phong<C> {
    /// `None` if the frame's lighting is beyond what is fast here.
    pub fn new(frame: &Frame, seen: &[u32], channels: Channels) -> Option<Phong<C>> {
        let lighting = &frame.lighting;
        let material = &lighting.material;
        let shines = material.specular != 0.0;
        let blinn = match material.specular_model {
            Specular::Phong => false,
            Specular::Blinn => true,
            Specular::CookTorrance(_) => return None,
        };
        let exponent = material.shininess;
        if shines && !(exponent.fract() == 0.0 && (1.0..=LARGEST_EXPONENT).contains(&exponent)) {
            return None;
        }
        if frame.encoding.is_some() {
            return None;
        }
        let eye = frame.view.distance.is_finite().then_some(frame.view.distance as f32);
        let lamps: Vec<Lamp<C>> = lighting
            .lamps
            .iter()
            .map(|lamp| Lamp {
                place: match lamp.place {
                    LampPlace::Direction(toward) => {
                        let halfway = (toward + DVec3::Z).normalize_or_zero();
                        Place::Far { toward: toward.as_vec3().to_array(), halfway: halfway.as_vec3().to_array() }
                    }
                    LampPlace::Point { position, attenuation } => {
                        Place::Near { at: position.as_vec3().to_array(), attenuation: attenuation.map(|c| c as f32) }
                    }
                },
                diffuse: channels.pick_f32(lamp.intensity * material.color * material.diffuse),
                specular: channels.pick_f32(lamp.intensity * material.specular_color * material.specular),
            })
            .collect();
        let planes = |of: fn(&crate::shading::FrameVertex) -> DVec3| {
            let plane =
                |t: &u32| Slopes::of_triangle(frame, *t).planes(frame.corners(*t as usize).map(|v| of(v).to_array()));
            seen.iter().map(plane).collect()
        };
        let near = eye.is_some() || lamps.iter().any(|lamp| matches!(lamp.place, Place::Near { .. }));
        Some(Phong {
            normals: planes(|v| v.normal),
            places: if near { planes(|v| v.eye) } else { Vec::new() },
            ambient: channels.pick_f32(lighting.ambient_light()),
            lamps,
            blinn,
            exponent: if shines { exponent as u32 } else { 1 },
            shines,
            eye,
        })
    }
}

#[derive(Clone, Copy)]
pub(super) struct Row {
    normal: Line<3>,
    place: Option<Line<3>>,
}

impl<const C: usize> Rows<C> for Phong<C> {
    type Row = Row;

    #[inline(always)]
    fn row<S: Simd>(&self, _: S, triangle: u32, x: u32, y: u32) -> Row {
        let normal = self.normals[triangle as usize].line(x, y);
        let place = self.places.get(triangle as usize).map(|place| place.line(x, y));
        Row { normal, place }
    }

    #[inline(always)]
    fn light<S: Simd>(&self, row: &Row, chunk: Chunk<S>) -> [Lanes<S>; C] {
        let steps = chunk.steps;
        let long: [Lanes<S>; 3] = row.normal.along(steps);
        let per_length = steps.all(1.0) / dot(&long, &long).max(steps.all(1e-30)).sqrt();
        let normal: [Lanes<S>; 3] = each(
            steps.simd(),
            #[inline(always)]
            |i| long[i] * per_length,
        );
        let mut sum: [Lanes<S>; C] = each(
            steps.simd(),
            #[inline(always)]
            |c| steps.all(self.ambient[c]),
        );
        let far_eye = [steps.all(0.0), steps.all(0.0), steps.all(1.0)];
        let (mut place, mut viewer) = (far_eye, far_eye);
        if let Some(line) = &row.place {
            place = line.along(steps);
            if let Some(eye) = self.eye {
                let zero = steps.all(0.0);
                viewer = unit(&[zero - place[0], zero - place[1], steps.all(eye) - place[2]]).0;
            }
        }
        for lamp in &self.lamps {
            let mut strength = steps.all(1.0);
            let (toward, halfway) = match &lamp.place {
                Place::Far { toward, halfway } => {
                    let toward = each(
                        steps.simd(),
                        #[inline(always)]
                        |i| steps.all(toward[i]),
                    );
                    let halfway: [Lanes<S>; 3] = each(
                        steps.simd(),
                        #[inline(always)]
                        |i| steps.all(halfway[i]),
                    );
                    (toward, if self.eye.is_none() { Some(halfway) } else { None })
                }
                Place::Near { at, attenuation: [c1, c2, c3] } => {
                    let offset = each(
                        steps.simd(),
                        #[inline(always)]
                        |i| steps.all(at[i]) - place[i],
                    );
                    let (toward, distance) = unit(&offset);
                    let weaker = (distance * *c3 + *c2) * distance + *c1;
                    strength = (steps.all(1.0) / weaker).min(steps.all(1.0));
                    (toward, None)
                }
            };
            let cosine = dot(&normal, &toward);
            let mut highlight = steps.all(0.0);
            if self.shines {
                let shine = if self.blinn {
                    let halfway = match halfway {
                        Some(halfway) => halfway,
                        None => {
                            unit(&each(
                                steps.simd(),
                                #[inline(always)]
                                |i| toward[i] + viewer[i],
                            ))
                            .0
                        }
                    };
                    dot(&normal, &halfway)
                } else {
                    cosine * 2.0 * dot(&normal, &viewer) - dot(&toward, &viewer)
                };
                highlight = power(shine.max(steps.all(0.0)), self.exponent);
            }
            let lit = steps.all(0.0).below(cosine);
            sum = add(
                sum,
                #[inline(always)]
                |c| {
                    let light = cosine * lamp.diffuse[c] + highlight * lamp.specular[c];
                    lit.select(light * strength, steps.all(0.0))
                },
            );
        }
        sum
    }
}

#[inline(always)]
fn dot<S: Simd>(a: &[Lanes<S>; 3], b: &[Lanes<S>; 3]) -> Lanes<S> {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The unit vector, or zero, and the length.
#[inline(always)]
fn unit<S: Simd>(v: &[Lanes<S>; 3]) -> ([Lanes<S>; 3], Lanes<S>) {
    let length = dot(v, v).sqrt();
    let per_length = length.all(1.0) / length.max(length.all(1e-30));
    (
        each(
            length.simd(),
            #[inline(always)]
            |i| v[i] * per_length,
        ),
        length,
    )
}

/// x^`exponent` by squaring, `exponent` at least 1.
#[inline(always)]
fn power<S: Simd>(x: Lanes<S>, exponent: u32) -> Lanes<S> {
    let (mut result, mut square, mut rest) = (x, x, exponent - 1);
    while rest > 0 {
        if rest & 1 == 1 {
            result = result * square;
        }
        square = square * square;
        rest >>= 1;
    }
    result
}
