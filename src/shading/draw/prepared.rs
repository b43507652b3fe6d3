//! Prepares and draws a frame.

use pulp::{Arch, Simd, WithSimd};
use rayon::prelude::*;

use super::{
    band::{Band, Corners, Scratch},
    encoder::{Encoder, write_linear},
};
use crate::{
    light::LinearImage,
    shading::{
        frame::{Frame, Outline, coverage},
        lighting::Specular,
        number::Channels,
        shaders::{Shade, Shading, with_shader},
    },
    system::checkpoint,
};

/// The number of rows in a band.
const BAND_ROWS: u32 = 8;

/// Everything computed once per frame: the outline of every triangle, the shader's constants, and the triangles of each
/// band of rows.
#[derive(Clone, Debug)]
pub struct Prepared<'f> {
    frame: &'f Frame,
    outlines: Vec<Option<Outline>>,
    corners: Vec<Corners>,
    /// The triangles of each band, in the order of the frame.
    bands: Vec<Vec<u32>>,
    channels: Channels,
    shading: Painter,
}

/// The shader, for the number of channels that are shaded.
#[derive(Clone, Debug)]
enum Painter {
    Gray(Box<Shading<f32, 1>>),
    Color(Box<Shading<f32, 3>>),
}

impl<'f> Prepared<'f> {
    /// Prepares `frame` for drawing with `shade`.
    pub fn new(frame: &'f Frame, shade: &Shade) -> Self {
        let channels = channels(frame);
        let shading = match channels {
            Channels::Gray(_) => Painter::Gray(Box::new(Shading::new(frame, shade, channels))),
            Channels::Color => Painter::Color(Box::new(Shading::new(frame, shade, channels))),
        };
        let outlines = coverage::outlines(frame);
        let mut bands = vec![Vec::new(); frame.height.div_ceil(BAND_ROWS) as usize];
        for (t, outline) in (0..).zip(&outlines) {
            if let Some(Outline { first, end, .. }) = outline {
                let reached = (first / BAND_ROWS) as usize..=((end - 1) / BAND_ROWS) as usize;
                bands[reached].iter_mut().for_each(|triangles| triangles.push(t));
            }
        }
        let corners = frame.each_triangle(|t| corners(frame, t, channels));
        Prepared { frame, outlines, corners, bands, channels, shading }
    }

    /// Draws the picture in linear light.
    pub fn image(&self) -> LinearImage {
        self.image_on(Arch::new())
    }

    /// Draws the picture in linear light with the vectors of `arch`, which do not affect the result.
    pub fn image_on(&self, arch: Arch) -> LinearImage {
        let mut image = LinearImage::new(self.frame.width, self.frame.height);
        self.draw::<3, _>(arch, &mut image.data, write_linear);
        image
    }

    /// Draws codes into `pixels`: red, green, blue and an opaque alpha of every pixel, row by row from the top left,
    /// 4 · width · height bytes. A shorter slice gets the rows that fit; bytes beyond the picture stay unchanged.
    pub fn codes(&self, encoder: &Encoder, pixels: &mut [u8]) {
        self.draw::<4, _>(
            Arch::new(),
            pixels,
            #[inline(always)]
            |light, channels, samples| encoder.write(light, channels, samples),
        );
    }

    /// Draws into `samples`, with `N` samples per pixel.
    fn draw<const N: usize, T: Send>(
        &self,
        arch: Arch,
        samples: &mut [T],
        write: impl Fn([&[f32]; 3], Channels, &mut [T]) + Sync,
    ) {
        let row = self.frame.width as usize * N;
        if row == 0 {
            return;
        }
        let rows = (samples.len() / row).min(self.frame.height as usize);
        let bands = samples[..rows * row].par_chunks_mut(row * BAND_ROWS as usize).zip(&self.bands).enumerate();
        bands.for_each_init(Scratch::default, |scratch, (index, (samples, triangles))| {
            checkpoint();
            self.paint(index as u32, triangles, scratch, arch);
            let light = scratch.light.each_ref().map(|light| &light[..light.len().min(samples.len() / N)]);
            arch.dispatch(Write { write: &write, light, channels: self.channels, samples });
        });
    }

    fn paint(&self, index: u32, triangles: &[u32], scratch: &mut Scratch, arch: Arch) {
        let Prepared { frame, outlines, corners, .. } = self;
        let first = index * BAND_ROWS;
        let background = self.channels.pick(frame.background);
        let end = (first + BAND_ROWS).min(frame.height);
        let band = Band { frame, outlines, corners, triangles, first, end, background };
        match &self.shading {
            Painter::Gray(shading) => paint(band, shading, scratch, arch),
            Painter::Color(shading) => paint(band, shading, scratch, arch),
        }
    }
}

/// Writes the light of a band into its samples. A closure would not be compiled for the machine's vectors.
struct Write<'a, W, T> {
    write: &'a W,
    light: [&'a [f32]; 3],
    channels: Channels,
    samples: &'a mut [T],
}

impl<W: Fn([&[f32]; 3], Channels, &mut [T]), T> WithSimd for Write<'_, W, T> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) {
        (self.write)(self.light, self.channels, self.samples);
    }
}

/// Draws `frame` with `shade` in linear light with the fast method; the result is within 1e-5 of
/// [`Reference::image`](super::Reference::image).
pub fn picture(frame: &Frame, shade: &Shade) -> LinearImage {
    Prepared::new(frame, shade).image()
}

/// Draws a band with code specialized for its shader.
fn paint<const C: usize>(band: Band<'_>, shading: &Shading<f32, C>, scratch: &mut Scratch, arch: Arch) {
    if shading.corrections.is_some() || shading.paint.is_some() {
        return band.paint(shading, scratch, arch);
    }
    with_shader!(&shading.uncorrected, shader => band.paint::<C, _>(shader, scratch, arch));
}

/// Makes the planes of a triangle: its weights and its light.
fn corners(frame: &Frame, triangle: usize, channels: Channels) -> Corners {
    let corners = frame.corners(triangle);
    let values = [0, 1, 2].map(|k: usize| {
        let mut values = [0.0; 6];
        values[k] = 1.0;
        values[3..].copy_from_slice(&channels.pick::<f64, 3>(corners[k].light));
        values
    });
    Corners::new(corners.map(|v| v.screen), values)
}

/// Determines which channels must be shaded: only one if the light values of the vertices and everything that a shader
/// may add to them are gray.
fn channels(frame: &Frame) -> Channels {
    let differ = frame.encoding.as_ref().is_some_and(|transfers| transfers.uniform().is_none());
    if differ || frame.paint.is_some() {
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
