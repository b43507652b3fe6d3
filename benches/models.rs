//! Cost of comparing two pictures, of the bands of a definition's ramps, and of choosing the next trial: QUEST+ with about
//! 100,000 pairs of levels and parameters, and adaptive pairs of ten items.
//!
//! `cargo bench --bench models`

use divan::{Bencher, black_box};
use machband::{
    experiment::task::{Curve, Grid, Quest, Ranking},
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
