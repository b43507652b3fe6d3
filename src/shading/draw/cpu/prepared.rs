//! A frame made ready for the rasteriser.

use glam::DVec3;

use super::{
    channels::Channels,
    cubic::Cubics,
    gouraud::{Flat, Gouraud},
    outline::Outline,
    phong::Phong,
    pixels::Pixels,
    plane::{Planes, Slopes},
    printed::Printed,
    quadratic::Quadratic,
    strips::{Cut, Exact},
};
use crate::shading::{
    Correction, Frame, Patches, Reference, Shade, Shader,
    boundary::edge_constants,
    shaders::{flat, gradient::Sign, quadratic},
};

/// Rows of a band unless told otherwise.
const BAND_ROWS: u32 = 16;

/// All that one frame needs before its pixels: the outline of every triangle, the shader's constants, and which band
/// of rows has which triangles.
#[derive(Clone, Debug)]
pub struct Prepared<'f> {
    pub(super) frame: &'f Frame,
    /// Which of the frame's triangles may have a pixel. Everything else here is about these alone.
    seen: Vec<u32>,
    pub(super) outlines: Vec<Outline>,
    pub(super) background: [f32; 3],
    pub(super) channels: Channels,
    pub(super) kind: Kinds<'f>,
    pub(super) band_rows: u32,
    /// The triangles of band i are `binned[starts[i]..starts[i + 1]]`, in the order of the frame.
    starts: Vec<u32>,
    binned: Vec<u32>,
}

/// The constants of every triangle; see [`WeightPlanes`](super::weights::WeightPlanes) for Q.
#[derive(Clone, Debug)]
pub(super) enum Kinds<'f> {
    Gray(Kind<1, 4>),
    Color(Kind<3, 8>),
    Pixels(Box<Pixels<'f>>),
}

#[derive(Clone, Debug)]
pub(super) enum Kind<const C: usize, const Q: usize> {
    Flat(Flat<C>),
    Gouraud(Gouraud<C>),
    Phong(Phong<C>),
    Quadratic(Quadratic<C, Q>),
    Printed(Printed<C, Q>),
    Exact(Exact<C, Q>),
    Cut(Cut<C, Q>),
    Cubics(Cubics<C>),
}

impl<'f> Prepared<'f> {
    /// `frame` ready to be drawn with `shade`.
    #[must_use]
    pub fn new(frame: &'f Frame, shade: &Shade) -> Self {
        Prepared::with_bands(frame, shade, BAND_ROWS)
    }

    /// The same with bands of `rows` rows, at least 1. The picture does not depend on it; the time does.
    #[must_use]
    pub fn with_bands(frame: &'f Frame, shade: &Shade, rows: u32) -> Self {
        let (seen, outlines): (Vec<u32>, Vec<Outline>) = (0..frame.triangles.len() as u32)
            .filter_map(|t| {
                let corners = frame.corners(t as usize).map(|v| v.screen);
                Some((t, Outline::new(corners, frame.width, frame.height)?))
            })
            .unzip();
        let (channels, kind) = Made { frame, shade, seen: &seen }.kinds();
        let background = match channels {
            Channels::Color => frame.background.as_vec3().to_array(),
            Channels::Gray(_) => [channels.pick_f32::<1>(frame.background)[0]; 3],
        };
        let band_rows = rows.max(1);
        let (starts, binned) = bins(&outlines, frame.height, band_rows);
        Prepared { frame, seen, outlines, background, channels, kind, band_rows, starts, binned }
    }

    /// Pixels across.
    #[must_use]
    pub fn width(&self) -> u32 {
        self.frame.width
    }

    /// Rows.
    #[must_use]
    pub fn height(&self) -> u32 {
        self.frame.height
    }

    /// The triangles that reach into band `band`.
    pub(super) fn triangles(&self, band: usize) -> &[u32] {
        &self.binned[self.starts[band] as usize..self.starts[band + 1] as usize]
    }

    /// The depths of a triangle.
    pub(super) fn depths(&self, triangle: u32) -> Planes<1> {
        let t = self.seen[triangle as usize];
        Slopes::of_triangle(self.frame, t).planes(self.frame.corners(t as usize).map(|v| [v.depth]))
    }
}

/// Sorts triangles into bands: counts, then places. Where each band's begin, and all of them.
fn bins(outlines: &[Outline], height: u32, rows: u32) -> (Vec<u32>, Vec<u32>) {
    let of = |outline: &Outline| (outline.first / rows) as usize..=((outline.end - 1) / rows) as usize;
    let mut next = vec![0u32; height.div_ceil(rows) as usize + 1];
    for outline in outlines {
        next[of(outline)].iter_mut().for_each(|count| *count += 1);
    }
    let mut sum = 0;
    for count in &mut next {
        sum += std::mem::replace(count, sum);
    }
    let starts = next.clone();
    let mut binned = vec![0; sum as usize];
    for (t, outline) in outlines.iter().enumerate() {
        for next in &mut next[of(outline)] {
            binned[*next as usize] = t as u32;
            *next += 1;
        }
    }
    (starts, binned)
}

/// What the constants are made of.
#[derive(Clone, Copy)]
struct Made<'a, 'f> {
    frame: &'f Frame,
    shade: &'a Shade,
    seen: &'a [u32],
}

impl<'f> Made<'_, 'f> {
    fn kinds(self) -> (Channels, Kinds<'f>) {
        if (self.shade.vertex, self.shade.reweight) != (Correction::Off, Correction::Off) {
            return (Channels::Color, self.pixels());
        }
        let frame = self.frame;
        let all = 0..frame.triangles.len();
        let vertices = frame.vertices.iter().map(|v| v.light).chain([frame.background]);
        match self.shade.shader {
            Shader::Flat => {
                let faces: Vec<DVec3> = self.seen.iter().map(|t| flat::light(frame, *t as usize)).collect();
                let channels = Channels::of(faces.iter().copied().chain([frame.background]));
                self.either(
                    channels,
                    |channels| Some(Kind::Flat(flat_kind(&faces, channels))),
                    |channels| Some(Kind::Flat(flat_kind(&faces, channels))),
                )
            }
            Shader::Phong => {
                let channels = Channels::of(phong_lights(frame).into_iter());
                self.either(
                    channels,
                    |channels| Phong::new(frame, self.seen, channels).map(Kind::Phong),
                    |channels| Phong::new(frame, self.seen, channels).map(Kind::Phong),
                )
            }
            Shader::Quadratic => {
                let middles: Vec<[DVec3; 3]> = all.map(|t| quadratic::middles(frame, t)).collect();
                let channels = Channels::of(vertices.chain(middles.iter().flatten().copied()));
                self.either(
                    channels,
                    |channels| Some(Kind::Quadratic(Quadratic::new(frame, self.seen, channels, &middles))),
                    |channels| Some(Kind::Quadratic(Quadratic::new(frame, self.seen, channels, &middles))),
                )
            }
            Shader::Patch => {
                let patches = Patches::new(frame, self.shade.gradients);
                let slopes = patches
                    .gradients()
                    .iter()
                    .flat_map(|[r, g, b]| [DVec3::new(r.x, g.x, b.x), DVec3::new(r.y, g.y, b.y)]);
                let channels = Channels::of(vertices.chain(slopes));
                self.either(
                    channels,
                    |channels| Some(Kind::Cubics(Cubics::new(frame, self.seen, channels, &patches))),
                    |channels| Some(Kind::Cubics(Cubics::new(frame, self.seen, channels, &patches))),
                )
            }
            _ => self.either(Channels::of(vertices), |channels| self.lit(channels), |channels| self.lit(channels)),
        }
    }

    fn pixels(self) -> Kinds<'f> {
        let reference = Reference::new(self.frame, self.shade);
        Kinds::Pixels(Box::new(Pixels { frame: self.frame, reference, seen: self.seen.to_vec() }))
    }

    /// One channel or three; pixel by pixel where the shader does not know how.
    fn either(
        self,
        channels: Channels,
        gray: impl FnOnce(Channels) -> Option<Kind<1, 4>>,
        color: impl FnOnce(Channels) -> Option<Kind<3, 8>>,
    ) -> (Channels, Kinds<'f>) {
        let kinds = match channels {
            Channels::Gray(_) => gray(channels).map(Kinds::Gray),
            Channels::Color => color(channels).map(Kinds::Color),
        };
        match kinds {
            Some(kinds) => (channels, kinds),
            None => (Channels::Color, self.pixels()),
        }
    }

    /// The shaders that need no light but the vertices'.
    fn lit<const C: usize, const Q: usize>(self, channels: Channels) -> Option<Kind<C, Q>> {
        let Made { frame, shade, seen } = self;
        let (b, depth) = (shade.strip(), shade.depth);
        let printed = |sign| Kind::Printed(Printed::new(frame, seen, channels, sign, b, depth));
        Some(match shade.shader {
            _ if b <= 0.0 => self.gouraud(channels),
            Shader::Fixed => printed(None),
            Shader::Gradient => printed(Some(Sign::Printed)),
            Shader::GradientRepaired => printed(Some(Sign::Repaired)),
            Shader::Exact => Kind::Exact(Exact::new(frame, seen, channels, &edge_constants(frame), b, depth)),
            Shader::Cut => Kind::Cut(Cut::new(frame, seen, channels, &edge_constants(frame), b, depth)),
            _ => self.gouraud(channels),
        })
    }

    fn gouraud<const C: usize, const Q: usize>(self, channels: Channels) -> Kind<C, Q> {
        let planes = |t: &u32| channels.planes(&Slopes::of_triangle(self.frame, *t), self.frame, *t);
        Kind::Gouraud(Gouraud(self.seen.iter().map(planes).collect()))
    }
}

fn flat_kind<const C: usize>(faces: &[DVec3], channels: Channels) -> Flat<C> {
    Flat(faces.iter().map(|light| channels.pick_f32(*light)).collect())
}

/// Everything that Phong's light is made of.
fn phong_lights(frame: &Frame) -> Vec<DVec3> {
    let lighting = &frame.lighting;
    let material = &lighting.material;
    let mut lights = vec![frame.background, lighting.ambient_light()];
    for lamp in &lighting.lamps {
        lights.push(lamp.intensity * material.color * material.diffuse);
        lights.push(lamp.intensity * material.specular_color * material.specular);
    }
    lights
}
