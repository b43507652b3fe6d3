//! What the slow parts cost. Results and how to repeat them: `benches/README.md`.
//!
//! `cargo bench`, or one of the modules: `cargo bench -- stimulus`

fn main() {
    divan::main();
}

/// Comparing two pictures, the bands of a definition's ramps, and choosing the next trial: QUEST+ with about 100,000 pairs of
/// levels and parameters, and adaptive pairs of ten items.
mod models {
    use divan::{Bencher, black_box};
    use machband::{
        experiment::task::{Curve, Grid, Quest, Ranking},
        stimulus::{Stimulus, ViewingConditions},
        store::definition,
        vision::{Eye, Judge},
    };

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
            let judge = Judge::of_pictures(size, px_per_deg, Eye::adapted_to(50.0)).expect("a judge");
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

    /// 23 levels, and 23 thresholds, 24 slopes and 8 lapse rates: 101,568 pairs.
    fn quest() -> Quest {
        let levels: Vec<f64> = (0..23).map(|i| -2.3 + 0.1 * f64::from(i)).collect();
        let grid = Grid {
            thresholds: levels.clone(),
            slopes: (0..24).map(|i| 1.0 + 0.4 * f64::from(i)).collect(),
            guesses: vec![0.5],
            lapses: (0..8).map(|i| 0.01 * f64::from(i)).collect(),
            gradients: vec![0.0],
        };
        Quest::new(Curve::Weibull, 1.0, &levels.iter().map(|x| (*x, 0.0)).collect::<Vec<_>>(), grid)
    }

    #[divan::bench]
    fn quest_plus(bencher: Bencher) {
        bencher.with_inputs(quest).bench_values(|mut quest| {
            let level = quest.choose();
            quest.learn(Some(black_box(level)), true);
            quest.choose()
        });
    }

    #[divan::bench]
    fn adaptive_pairs(bencher: Bencher) {
        let mut ranking = Ranking::new(10);
        (0..60).for_each(|i| ranking.learn((i * 7) % 10, (i * 7 + 1 + i % 8) % 10));
        bencher.with_inputs(|| ranking.clone()).bench_values(|mut ranking| {
            let [winner, loser] = ranking.choose(black_box(0.5));
            ranking.learn(winner, loser);
            ranking.choose(0.5)
        });
    }
}

/// One shaded frame: 1024 × 1024 pixels, 28 × 28 × 2 jittered triangles that cover the whole window.
mod shading {
    use std::fmt;

    use divan::counter::ItemsCount;
    use divan::{Bencher, black_box};
    use glam::DVec3;
    use machband::light::{Bits, Quantizer, Transfer};
    use machband::shading::{Field, Frame, Mesh, Patches, Scene, Shade, Shader, Surface, View, image};

    const SIZE: u32 = 1024;

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
}

/// One stimulus: 1024 × 1024 pixels, 8-bit RGB (3 MiB), sRGB, compared with filling the same amount of memory.
///
/// Peers, as reported and not measured here: stimupy 1.2.0 takes 62–100 ms for a step or Cornsweet image of this size (it has
/// no Mach-band ramp).
mod stimulus {
    use divan::counter::BytesCount;
    use divan::{Bencher, black_box};
    use machband::light::{Bits, Depth, Quantizer, Transfer};
    use machband::stimulus::{MachBand, ParameterValue, Stimulus, StimulusColor};

    const SIZE: u32 = 1024;
    const BYTES: usize = SIZE as usize * SIZE as usize * 3;

    fn quantizer() -> Quantizer {
        Quantizer::new(&Transfer::Srgb.into(), Bits::Eight)
    }

    /// The stimulus of the target, at several orientations.
    fn band(orientation_deg: f64) -> MachBand {
        MachBand { width: 0.4, depth: Depth::Finite(3), orientation_deg, ..MachBand::default() }
    }

    fn bench_codes(bencher: Bencher<'_, '_>, stimulus: impl Into<Stimulus>) {
        let (stimulus, quantizer) = (stimulus.into(), quantizer());
        bencher.counter(BytesCount::new(BYTES)).bench(|| black_box(&stimulus).codes(SIZE, &quantizer));
    }

    /// Memory allocated and freed every time, as for a stimulus.
    #[divan::bench_group(sample_count = 200, sample_size = 1)]
    mod codes {
        use super::*;

        /// The baseline for all others.
        #[divan::bench]
        fn fill(bencher: Bencher<'_, '_>) {
            bencher.counter(BytesCount::new(BYTES)).bench(|| vec![black_box(137u8); BYTES]);
        }

        /// The same in preallocated memory.
        #[divan::bench]
        fn fill_again(bencher: Bencher<'_, '_>) {
            let mut codes = vec![1u8; BYTES];
            bencher.counter(BytesCount::new(BYTES)).bench_local(|| black_box(&mut codes).fill(black_box(137)));
        }

        #[divan::bench(args = [0.0, 33.0, 45.0, 89.0, 89.9, 90.0])]
        fn orientation(bencher: Bencher<'_, '_>, orientation_deg: f64) {
            bench_codes(bencher, band(orientation_deg));
        }

        #[divan::bench(args = ["1", "32", "inf"])]
        fn depth_at_33(bencher: Bencher<'_, '_>, depth: &str) {
            let depth = depth.parse().expect("a depth");
            bench_codes(bencher, MachBand { depth, ..band(33.0) });
        }

        /// Three channels of different weight, full range: as many steps as there can be.
        #[divan::bench]
        fn most_steps_at_33(bencher: Bencher<'_, '_>) {
            let color = "1,0.9,0.8".parse::<StimulusColor>().expect("weights within 0…1");
            bench_codes(bencher, MachBand { low: 0.0, high: 1.0, color, ..band(33.0) });
        }

        /// From color to color.
        #[divan::bench(args = ["rgb", "hsv", "lab"])]
        fn two_colors_at_33(bencher: Bencher<'_, '_>, space: &str) {
            let color_high = Some("hsv:200,0.8,1".parse().expect("a color"));
            let space = space.parse().expect("a space");
            bench_codes(bencher, MachBand { color_high, space, ..band(33.0) });
        }

        #[divan::bench(args = ["chevreul", "cornsweet", "shaded-cylinder"])]
        fn other_kinds_at_33(bencher: Bencher<'_, '_>, kind: &str) {
            let mut stimulus = Stimulus::default_of(kind).expect("a kind");
            stimulus.set("orientation_deg", &ParameterValue::Number(33.0)).expect("an orientation");
            bench_codes(bencher, stimulus);
        }
    }

    /// Every pixel computed separately, as in the definition.
    #[divan::bench_group(sample_count = 20, sample_size = 1)]
    mod reference {
        use super::*;

        #[divan::bench]
        fn linear_at_33(bencher: Bencher<'_, '_>) {
            let band = Stimulus::from(band(33.0));
            bencher.bench(|| black_box(&band).linear(SIZE));
        }

        #[divan::bench]
        fn linear_and_quantize_at_33(bencher: Bencher<'_, '_>) {
            let (band, quantizer) = (Stimulus::from(band(33.0)), quantizer());
            bencher.counter(BytesCount::new(BYTES)).bench(|| quantizer.quantize(&black_box(&band).linear(SIZE)));
        }

        #[divan::bench(args = [Bits::Eight, Bits::Sixteen])]
        fn new_quantizer(bencher: Bencher<'_, '_>, bits: Bits) {
            bencher.bench(|| Quantizer::new(black_box(&Transfer::Srgb.into()), bits));
        }
    }
}
