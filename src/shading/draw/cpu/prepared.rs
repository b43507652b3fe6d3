//! A frame made ready to be drawn, and drawn.

use pulp::Arch;
use rayon::prelude::*;

use super::{
    band::{Band, Corners, Fast, Scratch},
    encoder::Encoder,
    target::{Linear, Target},
};
use crate::{
    light::LinearImage,
    shading::{
        channels::Channels,
        draw::reference::Reference,
        frame::{Frame, Outline},
        lighting::Specular,
        shaders::{Shade, Shading, with_shader},
    },
};

/// Rows of a band.
const BAND_ROWS: u32 = 16;

/// All that one frame needs before its pixels: the outline of every triangle, the shader's constants, and which band
/// of rows has which triangles.
#[derive(Clone, Debug)]
pub struct Prepared<'f> {
    frame: &'f Frame,
    outlines: Vec<Option<Outline>>,
    /// The triangles of each band, in the order of the frame.
    bands: Vec<Vec<u32>>,
    channels: Channels,
    shading: Painter<'f>,
}

/// The way to the light of the pixels.
#[derive(Clone, Debug)]
enum Painter<'f> {
    /// In lanes of f32, for one channel.
    Gray(Vec<Corners>, Box<Shading<f32, 1>>),
    /// In lanes of f32, for three.
    Color(Vec<Corners>, Box<Shading<f32, 3>>),
    /// One by one in f64.
    Exact(&'f Reference<'f>),
}

impl<'f> Prepared<'f> {
    /// `frame` ready to be drawn with `shade`.
    #[must_use]
    pub fn new(frame: &'f Frame, shade: &Shade) -> Self {
        let channels = channels(frame);
        let shading = match channels {
            Channels::Gray(_) => {
                Painter::Gray(corners::<1>(frame, channels), Box::new(Shading::new(frame, shade, channels)))
            }
            Channels::Color => {
                Painter::Color(corners::<3>(frame, channels), Box::new(Shading::new(frame, shade, channels)))
            }
        };
        Prepared::with(frame, channels, shading)
    }

    fn with(frame: &'f Frame, channels: Channels, shading: Painter<'f>) -> Self {
        let outline = |t| Outline::new(frame.corners(t).map(|v| v.screen), frame.width, frame.height);
        let outlines = frame.each_triangle(outline);
        let mut bands = vec![Vec::new(); frame.height.div_ceil(BAND_ROWS) as usize];
        for (t, outline) in (0..).zip(&outlines) {
            if let Some(Outline { first, end, .. }) = outline {
                let reached = (first / BAND_ROWS) as usize..=((end - 1) / BAND_ROWS) as usize;
                bands[reached].iter_mut().for_each(|triangles| triangles.push(t));
            }
        }
        Prepared { frame, outlines, bands, channels, shading }
    }

    /// The picture in linear light.
    #[must_use]
    pub fn image(&self) -> LinearImage {
        let mut image = LinearImage::new(self.frame.width, self.frame.height);
        self.draw(Arch::new(), &Linear, &mut image.data);
        image
    }

    /// Draws codes into `pixels`: red, green, blue and an opaque alpha of every pixel, row by row from the top left,
    /// 4 · width · height bytes. A shorter slice gets the rows that fit; bytes beyond the picture stay unchanged.
    pub fn codes(&self, encoder: &Encoder, pixels: &mut [u8]) {
        self.draw(Arch::new(), encoder, pixels);
    }

    fn draw<T: Target>(&self, arch: Arch, target: &T, samples: &mut [T::Sample]) {
        let row = self.frame.width as usize * T::SAMPLES;
        if row == 0 {
            return;
        }
        let rows = (samples.len() / row).min(self.frame.height as usize);
        let bands = samples[..rows * row].par_chunks_mut(row * BAND_ROWS as usize).zip(&self.bands).enumerate();
        bands.for_each_init(Scratch::default, |scratch, (index, (samples, triangles))| {
            self.paint(index as u32, triangles, scratch, arch);
            let light = scratch.light.each_ref().map(|light| &light[..light.len().min(samples.len() / T::SAMPLES)]);
            arch.dispatch(
                #[inline(always)]
                || target.write(light, self.channels, samples),
            );
        });
    }

    fn paint(&self, index: u32, triangles: &[u32], scratch: &mut Scratch, arch: Arch) {
        let (frame, outlines, first) = (self.frame, &self.outlines[..], index * BAND_ROWS);
        let background = match self.channels {
            Channels::Color => self.channels.pick(frame.background),
            Channels::Gray(_) => [self.channels.pick::<f32, 1>(frame.background)[0]; 3],
        };
        let end = (first + BAND_ROWS).min(frame.height);
        let band = Band { frame, outlines, triangles, first, end, background };
        match &self.shading {
            Painter::Gray(corners, shading) => fast(band, corners, shading, scratch, arch),
            Painter::Color(corners, shading) => fast(band, corners, shading, scratch, arch),
            Painter::Exact(reference) => band.paint(*reference, scratch, arch),
        }
    }
}

/// `frame` with `shade` in linear light, drawn the fast way: within 1e-5 of [`Reference::image`].
#[must_use]
pub fn picture(frame: &Frame, shade: &Shade) -> LinearImage {
    Prepared::new(frame, shade).image()
}

impl Reference<'_> {
    /// The whole picture, every pixel at its center.
    #[must_use]
    pub fn image(&self) -> LinearImage {
        Prepared::with(self.frame(), Channels::Color, Painter::Exact(self)).image()
    }
}

/// Paints a band with code that is made for its shader.
fn fast<const C: usize>(
    band: Band<'_>,
    corners: &[Corners],
    shading: &Shading<f32, C>,
    scratch: &mut Scratch,
    arch: Arch,
) {
    if shading.corrections.is_some() {
        return band.paint(&Fast { corners, shader: shading }, scratch, arch);
    }
    with_shader!(&shading.plain, shader => band.paint::<C, _>(&Fast { corners, shader }, scratch, arch));
}

/// The planes of every triangle.
fn corners<const C: usize>(frame: &Frame, channels: Channels) -> Vec<Corners> {
    let planes = |t| {
        let corners = frame.corners(t);
        let values = [0, 1, 2].map(|k: usize| {
            let mut values = [0.0; 6];
            values[k] = 1.0;
            values[3..3 + C].copy_from_slice(&channels.pick::<f64, C>(corners[k].light));
            values
        });
        Corners::new(corners.map(|v| v.screen), values)
    };
    frame.each_triangle(planes)
}

/// Which channels are shaded: one where the lights of the vertices, and all that any shader may add to them, are gray.
fn channels(frame: &Frame) -> Channels {
    if frame.encoding.as_ref().is_some_and(|transfers| transfers.uniform().is_none()) {
        return Channels::Color;
    }
    let (lighting, material) = (&frame.lighting, &frame.lighting.material);
    let mut lights = vec![frame.background, lighting.ambient_light()];
    for lamp in &lighting.lamps {
        lights.push(lamp.intensity * material.color * material.diffuse);
        let highlight = lamp.intensity * material.specular_color * material.specular;
        lights.push(highlight);
        if let Specular::CookTorrance(facets) = material.specular_model {
            lights.push(highlight * facets.index);
        }
    }
    lights.extend(frame.vertices.iter().flat_map(|v| [v.light, v.ambient]));
    Channels::of(lights.into_iter())
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::{
        light::Depth,
        shading::{Correction, Lighting, Shader, Surface, View, shapes},
    };

    #[test]
    fn vectors_of_any_width_make_the_same_picture() {
        let mut machines = vec![("none", Arch::Scalar)];
        #[cfg(target_arch = "x86_64")]
        machines.extend(pulp::x86::V3::try_new().map(|v3| ("AVX2", Arch::V3(v3))));
        let lighting = Lighting::standard().with_color(DVec3::new(0.9, 0.6, 0.3));
        for mesh in [shapes::cube(), shapes::torus(16, 8), shapes::blob(200)] {
            let view = View { width: 190, height: 150, ..View::square(1).rotated([20.0, 40.0, 10.0]) };
            let frame = Frame::new(&Surface::new(mesh), &view, &lighting, DVec3::ZERO);
            for shader in Shader::ALL {
                for (n, vertex) in [(1, Correction::Off), (3, Correction::Repaired), (7, Correction::Printed)] {
                    let shade = Shade { depth: Depth::Finite(n), vertex, reweight: vertex, ..Shade::new(*shader) };
                    let prepared = Prepared::new(&frame, &shade);
                    let bits = |arch| {
                        let mut light = vec![0.0f32; 3 * 190 * 150];
                        prepared.draw(arch, &Linear, &mut light);
                        light.into_iter().map(f32::to_bits).collect::<Vec<_>>()
                    };
                    let own = bits(Arch::new());
                    for (name, arch) in &machines {
                        assert!(bits(*arch) == own, "{shade:?}, {name}");
                    }
                }
            }
        }
    }
}
