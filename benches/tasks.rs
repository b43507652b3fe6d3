//! Choosing the next trial: QUEST+ with about 100,000 pairs of levels and parameters, and adaptive pairs of ten items.

use divan::{Bencher, black_box};
use machband::experiment::task::{Curve, Grid, Quest, Ranking};

fn main() {
    divan::main();
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
