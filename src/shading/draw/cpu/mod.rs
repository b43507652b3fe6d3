//! Every shader, fast: one traversal of the triangles, row by row in bands over threads, with the shaders as functions
//! of a row.
//!
//! ```text
//! Frame → Prepared (constants of every triangle: once a frame) → bands of rows: spans → light (f32) → picture
//! ```
//!
//! Coverage is exactly that of [`coverage`](super::coverage), hidden surfaces are found by depth in f64, and the light
//! is within 1e-5 of the [`Reference`](super::Reference)'s. The picture is the same to the last bit for any number of
//! threads, any height of the bands, and any machine: vectors are those that the machine has, found when the program
//! runs, and no operation is fused or approximate.

mod band;
mod channels;
mod cubic;
mod curve;
mod encoder;
mod gouraud;
mod lanes;
mod outline;
mod phong;
mod pixels;
mod plane;
mod prepared;
mod printed;
mod quadratic;
mod strips;
mod target;
mod weights;

use std::sync::{Mutex, PoisonError};

pub use encoder::Encoder;
pub use prepared::Prepared;
use pulp::Arch;

use self::{
    band::{Band, Scratch, Work, paint},
    prepared::{Kind, Kinds},
    target::{Linear, Target, finish},
};
use crate::light::LinearImage;

/// Draws prepared frames. Keeps its threads and their memory: make one and use it for every frame.
#[derive(Debug)]
pub struct Rasterizer {
    /// `None` for a single thread.
    pool: Option<rayon::ThreadPool>,
    scratches: Vec<Scratch>,
    /// The vectors of this machine.
    arch: Arch,
}

impl Rasterizer {
    /// A rasteriser that draws on `threads` threads, at least 1; on the calling thread alone where the system has no
    /// others to give.
    #[must_use]
    pub fn new(threads: usize) -> Rasterizer {
        let pool = (threads > 1).then(|| rayon::ThreadPoolBuilder::new().num_threads(threads).build().ok()).flatten();
        let count = if pool.is_some() { threads } else { 1 };
        Rasterizer { pool, scratches: (0..count).map(|_| Scratch::default()).collect(), arch: Arch::new() }
    }

    /// Draws linear light into `image`, which takes the size of the frame.
    pub fn draw_linear(&mut self, prepared: &Prepared<'_>, image: &mut LinearImage) {
        let (width, height) = (prepared.width(), prepared.height());
        if (image.width, image.height) != (width, height) || image.data.len() != 3 * width as usize * height as usize {
            *image = LinearImage::new(width, height);
        }
        self.draw(prepared, &Linear, &mut image.data);
    }

    /// Draws codes into `pixels`: red, green, blue and an opaque alpha of every pixel, row by row from the top left,
    /// 4 · width · height bytes. Of a shorter slice, the rows that fit; bytes beyond are left as they are.
    pub fn draw_codes(&mut self, prepared: &Prepared<'_>, encoder: &Encoder, pixels: &mut [u8]) {
        self.draw(prepared, encoder, pixels);
    }

    fn draw<T: Target>(&mut self, prepared: &Prepared<'_>, target: &T, samples: &mut [T::Sample]) {
        let row = prepared.width() as usize * T::SAMPLES;
        if row == 0 {
            return;
        }
        let rows = (samples.len() / row).min(prepared.height() as usize);
        let bands = Mutex::new(samples[..rows * row].chunks_mut(row * prepared.band_rows as usize).enumerate());
        let next = || bands.lock().unwrap_or_else(PoisonError::into_inner).next();
        let arch = self.arch;
        let work = |scratch: &mut Scratch| {
            while let Some((index, samples)) = next() {
                let first = index as u32 * prepared.band_rows;
                let band = Band { first, end: (first + prepared.band_rows).min(prepared.height()) };
                let work = Work { prepared, band, triangles: prepared.triangles(index), arch };
                draw_band(work, target, scratch, samples);
            }
        };
        match &self.pool {
            None => self.scratches.iter_mut().for_each(work),
            Some(pool) => pool.scope(|scope| {
                for scratch in &mut self.scratches {
                    scope.spawn(|_| work(scratch));
                }
            }),
        }
    }
}

fn draw_band<T: Target>(work: Work<'_>, target: &T, scratch: &mut Scratch, samples: &mut [T::Sample]) {
    let prepared = work.prepared;
    match &prepared.kind {
        Kinds::Gray(kind) => shade(kind, work, scratch),
        Kinds::Color(kind) => shade(kind, work, scratch),
        Kinds::Pixels(shader) => paint(&**shader, work, scratch),
    }
    finish(work.arch, target, scratch.light.each_ref().map(|light| &light[..]), prepared.channels, samples);
}

fn shade<const C: usize, const Q: usize>(kind: &Kind<C, Q>, work: Work<'_>, scratch: &mut Scratch) {
    match kind {
        Kind::Flat(shader) => paint(shader, work, scratch),
        Kind::Gouraud(shader) => paint(shader, work, scratch),
        Kind::Phong(shader) => paint(shader, work, scratch),
        Kind::Quadratic(shader) => paint(shader, work, scratch),
        Kind::Printed(shader) => paint(shader, work, scratch),
        Kind::Exact(shader) => paint(shader, work, scratch),
        Kind::Cut(shader) => paint(shader, work, scratch),
        Kind::Cubics(shader) => paint(shader, work, scratch),
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::{
        light::Depth,
        shading::{Frame, Lighting, Shade, Shader, Surface, View, shapes},
    };

    /// The bits of a picture drawn with the vectors of `arch`.
    fn bits(frame: &Frame, shade: &Shade, arch: Arch) -> Vec<u32> {
        let mut image = LinearImage::new(0, 0);
        let mut rasterizer = Rasterizer { arch, ..Rasterizer::new(1) };
        rasterizer.draw_linear(&Prepared::new(frame, shade), &mut image);
        image.data.iter().map(|light| light.to_bits()).collect()
    }

    #[test]
    fn vectors_of_any_width_make_the_same_picture() {
        let mut machines = vec![("none", Arch::Scalar)];
        #[cfg(target_arch = "x86_64")]
        machines.extend(pulp::x86::V3::try_new().map(|v3| ("AVX2", Arch::V3(v3))));
        let lighting = Lighting::standard().with_color(DVec3::new(0.9, 0.6, 0.3));
        for mesh in [shapes::cube(), shapes::torus(16, 8), shapes::blob(200).unwrap()] {
            let view = View { width: 190, height: 150, ..View::square(1).rotated([20.0, 40.0, 10.0]) };
            let frame = Frame::new(&Surface::new(mesh), &view, &lighting, DVec3::ZERO);
            for shader in Shader::ALL {
                for depth in [Depth::Finite(1), Depth::Finite(3), Depth::Finite(7), Depth::Infinite] {
                    for boundary in [0.05, 0.25] {
                        let shade = Shade { depth, boundary, ..Shade::new(*shader) };
                        let own = bits(&frame, &shade, Arch::new());
                        for (name, arch) in &machines {
                            assert!(bits(&frame, &shade, *arch) == own, "{shade:?}, {name}");
                        }
                    }
                }
            }
        }
    }
}
