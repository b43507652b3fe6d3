//! Cost of the vision model for images, and for ramps that vary in one direction.
//!
//! `cargo bench --bench vision`

use divan::{Bencher, black_box};
use machband::{
    light::Depth,
    shading::{Reference, Scene, Shade, Shader, Surface, coverage, shapes},
    stimulus::{MachBand, Stimulus, ViewingConditions},
    vision::{Border, Eye, Line, LuminanceImage, luminance, luminances},
};

fn main() {
    divan::main();
}

/// A ramp across a picture of 512 × 512 pixels, 10° wide.
#[divan::bench(sample_count = 20)]
fn picture_of_a_ramp(bencher: Bencher) {
    let light = luminances(&Stimulus::from(MachBand { orientation_deg: 30.0, ..MachBand::default() }).linear(512));
    see(bencher, &light, None);
}

/// Gouraud shading of a blob, without outlines.
#[divan::bench(sample_count = 20)]
fn picture_of_a_mesh(bencher: Bencher) {
    let surface = Surface::new(shapes::mesh(shapes::Shape::Blob, 313).expect("a blob"));
    let frame = Scene::default().frame(&surface, 512, 512);
    let light = luminances(&Reference::new(&frame, &Shade::new(Shader::Gouraud)).image());
    see(bencher, &light, Some(&coverage::interior_mask(&frame)));
}

fn see(bencher: Bencher, light: &[f64], mask: Option<&[bool]>) {
    let picture = LuminanceImage { light, width: 512, height: 512, px_per_deg: 51.2, mask };
    bencher.bench_local(|| black_box(&picture).predict(&Eye::default()).expect("a picture"));
}

/// A thousand ramps of different widths, each for its own eye, as in `machband predict`; one thread.
#[divan::bench(sample_count = 5)]
fn thousand_conditions(bencher: Bencher) {
    let ramp = |i: u32| {
        let width = 0.01 + 0.00095 * f64::from(i);
        Stimulus::MachBand(MachBand { width, depth: Depth::Finite(1), ..MachBand::default() })
    };
    let ramps: Vec<Stimulus> = (0..1000).map(ramp).collect();
    let viewing = ViewingConditions::new(10.0);
    bencher.bench_local(|| {
        ramps.iter().map(|ramp| viewing.predict(ramp, 512).expect("a ramp").visibility().max()).fold(0.0, f64::max)
    });
}

/// A thousand profiles of 512 pixels; one thread.
#[divan::bench(sample_count = 5)]
fn thousand_profiles(bencher: Bencher) {
    let profile: Vec<f64> = Stimulus::MachBand(MachBand::default()).profile(512).into_iter().map(luminance).collect();
    let line = Line { light: &profile, px_per_deg: 51.2, border: Border::Continues };
    bencher.bench_local(|| {
        (0..1000).map(|_| black_box(&line).predict(&Eye::default()).expect("a view").visibility.max()).sum::<f64>()
    });
}
