//! What one shaded frame costs: 1024 × 1024 pixels, 28 × 28 × 2 jittered triangles that cover the whole window. Results
//! and how to repeat them: `benches/README.md`.

use std::fmt;

use divan::counter::ItemsCount;
use divan::{Bencher, black_box};
use glam::DVec3;
use machband::light::{Bits, Quantizer, Transfer};
use machband::shading::{Field, Frame, Mesh, Patches, Scene, Shade, Shader, Surface, View, image};

const SIZE: u32 = 1024;

fn main() {
    divan::main();
}

/// A jittered grid of `columns` × `rows` × 2 triangles over the whole window, with the normals of gentle hills.
fn grid(columns: usize, rows: usize) -> Frame {
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
    Frame::new(&Surface::new(mesh), &view, &Scene::default().lighting(), DVec3::ZERO)
}

#[derive(Clone, Copy)]
struct Case {
    shader: Shader,
    threads: usize,
}

impl fmt::Display for Case {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}, {} thr.", self.shader, self.threads)
    }
}

fn cases() -> Vec<Case> {
    Shader::ALL.iter().flat_map(|&shader| [1, 2].map(|threads| Case { shader, threads })).collect()
}

fn pool(threads: usize) -> rayon::ThreadPool {
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads")
}

/// From a frame to codes.
#[divan::bench(args = cases(), sample_count = 40, sample_size = 1)]
fn codes(bencher: Bencher<'_, '_>, case: Case) {
    let (frame, shade) = (grid(28, 28), Shade::new(case.shader));
    let (quantizer, pool) = (Quantizer::new(&Transfer::Srgb.into(), Bits::Eight), pool(case.threads));
    bencher
        .counter(ItemsCount::new(SIZE as usize * SIZE as usize))
        .bench_local(|| pool.install(|| quantizer.quantize(&image(black_box(&frame), &shade))));
}

/// What is done once per frame.
#[divan::bench_group(sample_count = 40, sample_size = 1)]
mod prepare {
    use super::*;

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
        let (frame, pool) = (grid(columns, rows), pool(threads));
        bencher.bench_local(|| pool.install(|| Patches::new(black_box(&frame), field)));
    }
}
