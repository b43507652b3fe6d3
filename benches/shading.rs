//! What one shaded frame costs: 1024 × 1024 pixels as 8-bit RGBA in sRGB, 28 × 28 × 2 jittered triangles that cover the
//! whole window.
//!
//! Compared with Mesa's llvmpipe, measured by `benches/shading_llvmpipe.py`. Others, as reported and not measured here:
//! euc 0.5.3, one thread, Gouraud 50 and Phong 29 Mpix/s. Results and how to repeat them: `benches/README.md`.

use std::fmt;

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use glam::DVec3;
use machband::light::Transfer;
use machband::shading::{
    Encoder, Field, Frame, Gradients, Lighting, Mesh, Patches, Prepared, Shade, Shader, Surface, View,
};

const SIZE: u32 = 1024;
const PIXELS: usize = SIZE as usize * SIZE as usize;

fn main() {
    divan::main();
}

/// A jittered grid of `columns` × `rows` × 2 triangles over the whole window, with the normals of gentle hills.
fn grid(columns: usize, rows: usize, color: DVec3) -> Frame {
    // −1…1, without pattern.
    let noise = |i: usize| (i as u64 + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15) as i64 as f64 / (1u64 << 63) as f64;
    let along = |step: usize, steps: usize, noise: f64| {
        let moved = if step == 0 || step == steps { 0.0 } else { 0.24 * noise };
        (step as f64 + moved) / steps as f64 * 2.0 - 1.0
    };
    let place = |i: usize| {
        let (column, row) = (i % (columns + 1), i / (columns + 1));
        DVec3::new(along(column, columns, noise(2 * i)), along(row, rows, noise(2 * i + 1)), 0.0)
    };
    let places: Vec<DVec3> = (0..(columns + 1) * (rows + 1)).map(place).collect();
    let cells = (0..rows).flat_map(|row| (0..columns).map(move |column| (row * (columns + 1) + column) as u32));
    let above = columns as u32 + 1;
    let triangles: Vec<[u32; 3]> =
        cells.flat_map(|a| [[a, a + 1, a + above + 1], [a, a + above + 1, a + above]]).collect();
    let mesh = Mesh::new(&places, &triangles, 180.0).expect("a grid");
    let mesh = mesh.with_normals(|p| DVec3::new(0.5 * (4.0 * p.x).sin(), 0.5 * (3.0 * p.y + p.x).sin(), 1.0));
    // The square's corners are on the bounding sphere.
    let view = View { fill: std::f64::consts::SQRT_2, ..View::square(SIZE) };
    let mut lighting = Lighting::standard();
    lighting.material.color = color;
    Frame::new(&Surface::new(mesh), &view, &lighting, DVec3::ZERO)
}

const GRAY: DVec3 = DVec3::ONE;
const COLOR: DVec3 = DVec3::new(0.9, 0.6, 0.3);

#[derive(Clone, Copy)]
struct Case {
    shader: Shader,
    threads: usize,
    color: DVec3,
}

impl fmt::Display for Case {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Case { shader, threads, color } = self;
        write!(f, "{shader}, {}, {threads} thr.", if *color == GRAY { "gray" } else { "color" })
    }
}

fn cases() -> Vec<Case> {
    let shaders = Shader::ALL.iter();
    shaders
        .flat_map(|&shader| [GRAY, COLOR].map(|color| [1, 2].map(|threads| Case { shader, threads, color })))
        .flatten()
        .collect()
}

fn pool(threads: usize) -> rayon::ThreadPool {
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads")
}

fn bench_codes(bencher: Bencher<'_, '_>, frame: &Frame, shade: &Shade, threads: usize) {
    let prepared = Prepared::new(frame, shade);
    let encoder = Encoder::new(&Transfer::Srgb);
    let mut pixels = vec![1; 4 * PIXELS];
    let pool = pool(threads);
    bencher.counter(ItemsCount::new(PIXELS)).bench_local(|| {
        pool.install(|| black_box(&prepared).codes(&encoder, black_box(&mut pixels)));
    });
}

/// Everything that is done once per pixel, into preallocated memory.
#[divan::bench_group(sample_count = 100, sample_size = 1)]
mod pixels {
    use super::*;

    #[divan::bench(args = cases())]
    fn rgba8(bencher: Bencher<'_, '_>, case: Case) {
        bench_codes(bencher, &grid(28, 28, case.color), &Shade::new(case.shader), case.threads);
    }

    #[divan::bench(args = [1, 2])]
    fn linear_f32_gouraud(bencher: Bencher<'_, '_>, threads: usize) {
        let frame = grid(28, 28, COLOR);
        let prepared = Prepared::new(&frame, &Shade::new(Shader::Gouraud));
        let pool = pool(threads);
        bencher.counter(ItemsCount::new(PIXELS)).bench_local(|| pool.install(|| black_box(&prepared).image()));
    }
}

/// Gouraud and *fixed* from huge triangles to those of a few pixels.
#[divan::bench_group(sample_count = 40, sample_size = 1)]
mod triangles {
    use super::*;

    const GRIDS: [(usize, usize); 7] = [(3, 2), (6, 6), (14, 14), (28, 28), (70, 70), (160, 160), (316, 316)];

    #[divan::bench(args = GRIDS)]
    fn gouraud(bencher: Bencher<'_, '_>, (columns, rows): (usize, usize)) {
        bench_codes(bencher, &grid(columns, rows, GRAY), &Shade::new(Shader::Gouraud), 1);
    }

    #[divan::bench(args = GRIDS)]
    fn fixed(bencher: Bencher<'_, '_>, (columns, rows): (usize, usize)) {
        bench_codes(bencher, &grid(columns, rows, GRAY), &Shade::new(Shader::Fixed), 1);
    }
}

/// Everything that is done once per frame: the constants of 1568 triangles.
#[divan::bench_group(sample_count = 40, sample_size = 1)]
mod prepare {
    use super::*;

    #[divan::bench(args = Shader::ALL)]
    fn gray(bencher: Bencher<'_, '_>, shader: Shader) {
        let frame = grid(28, 28, GRAY);
        bencher.bench_local(|| Prepared::new(black_box(&frame), &Shade::new(shader)));
    }

    /// The coefficients of 1568 and 99,904 triangles: of the light for *patch*, of the normals for *c1-phong*.
    #[divan::bench(args = [(28, 28, 1), (28, 28, 2), (224, 223, 1), (224, 223, 2)])]
    fn coefficients_of_light(bencher: Bencher<'_, '_>, (columns, rows, threads): (usize, usize, usize)) {
        bench_coefficients(bencher, Field::Light, columns, rows, threads);
    }

    #[divan::bench(args = [(28, 28, 1), (28, 28, 2), (224, 223, 1), (224, 223, 2)])]
    fn coefficients_of_normals(bencher: Bencher<'_, '_>, (columns, rows, threads): (usize, usize, usize)) {
        bench_coefficients(bencher, Field::Normal, columns, rows, threads);
    }

    fn bench_coefficients(bencher: Bencher<'_, '_>, field: Field, columns: usize, rows: usize, threads: usize) {
        let (frame, pool) = (grid(columns, rows, GRAY), pool(threads));
        bencher.bench_local(|| pool.install(|| Patches::new(black_box(&frame), field, Gradients::Curvature)));
    }

    #[divan::bench]
    fn encoder(bencher: Bencher<'_, '_>) {
        bencher.bench_local(|| Encoder::new(black_box(&Transfer::Srgb)));
    }
}
