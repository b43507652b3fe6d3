//! Cost of comparing two pictures, and of the bands of a definition's ramps.
//!
//! `cargo bench --bench vision`

use divan::{Bencher, black_box};
use machband::{
    stimulus::{Stimulus, ViewingConditions},
    store::definition,
    vision::{Eye, Judge},
};

fn main() {
    divan::main();
}

/// A picture with waves, in cd/m², and the same with noise.
fn pictures([width, height]: [usize; 2]) -> [Vec<f64>; 2] {
    let waves = |i: usize| 50.0 + 30.0 * ((i % width) as f64 / 40.0).sin() * ((i / width) as f64 / 60.0).cos();
    let noise = |i: usize| (i * 7919 % 1000) as f64 / 500.0 - 1.0;
    let reference: Vec<f64> = (0..width * height).map(waves).collect();
    [reference.iter().enumerate().map(|(i, light)| light + noise(i)).collect(), reference]
}

/// A pair of pictures of 512 × 512 pixels, 10° wide, and one of 3840 × 2160, 60° wide; all threads.
#[divan::bench(args = [512, 3840], sample_count = 5, sample_size = 1)]
fn pair(bencher: Bencher, width: usize) {
    let (size, px_per_deg) = if width == 512 { ([512; 2], 51.2) } else { ([3840, 2160], 64.0) };
    let [shown, reference] = pictures(size);
    bencher.bench_local(|| {
        let judge = Judge::of_pictures(size, px_per_deg, Eye::default()).expect("a judge");
        let difference = judge.difference(black_box(&shown), &reference, None).expect("a difference");
        difference.map().largest()
    });
}

/// The bands of the 120 conditions of bangay2003; all threads.
#[divan::bench(sample_count = 5, sample_size = 1)]
fn bangay2003(bencher: Bencher) {
    let protocol = definition::open(std::path::Path::new("bangay2003")).expect("a definition");
    let stimuli: Vec<&Stimulus> = protocol.conditions().iter().map(|condition| &condition.stimulus).collect();
    let viewing = ViewingConditions::new(10.0);
    bencher.bench_local(|| viewing.visible(black_box(&stimuli), None).expect("bands"));
}
