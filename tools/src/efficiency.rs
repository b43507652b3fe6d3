//! The tables of docs/tasks.md: how many trials each method needs.

use machband::{
    analysis::{
        comparisons::{Scaling, Wins},
        tasks::psychometric::{Guess, Model, Point, estimate},
    },
    experiment::task::{Common, Curve, Grid, Psychometric, Quest, Ranking, Staircase, Stairs},
};
use rand_chacha::{
    ChaCha8Rng,
    rand_core::{Rng as _, SeedableRng as _},
};
use rand_distr::{Distribution as _, StandardNormal};
use rayon::prelude::*;

/// Number of simulated sessions for each number.
const RUNS: u64 = 400;
/// The observer: Weibull, base-10 logarithms of the level.
const TRUTH: Psychometric = Psychometric { threshold: -1.4, slope: 3.0, guess: 0.5, lapse: 0.02 };
/// The numbers of trials at which the error is computed.
const TRIALS: [usize; 10] = [20, 30, 40, 50, 60, 80, 100, 130, 170, 220];

fn unit(rng: &mut ChaCha8Rng) -> f64 {
    ((rng.next_u64() >> 12) as f64 + 0.5) / (1u64 << 52) as f64
}

/// A method as a session runs it.
enum Run {
    Quest(Quest),
    Stairs(Stairs),
    Constant(Vec<f64>),
}

/// Returns the answers of one run by level, and the threshold (F = ½) that the analysis estimates from them.
fn estimated(mut run: Run, levels: &[f64], trials: usize, rng: &mut ChaCha8Rng) -> f64 {
    let mut points: Vec<Point> = Vec::new();
    for trial in 0..trials {
        let (x, index) = match &run {
            Run::Quest(quest) => {
                let index = quest.choose();
                (levels[index], index)
            }
            Run::Stairs(stairs) => (stairs.level.log10(), 0),
            Run::Constant(levels) => (levels[trial % levels.len()], 0),
        };
        let seen = unit(rng) < Curve::Weibull.probability(x, &TRUTH);
        match &mut run {
            Run::Quest(quest) => quest.learn(Some(index), seen),
            Run::Stairs(stairs) => stairs.answer(seen),
            Run::Constant(_) => {}
        }
        Point::add(&mut points, x, seen.into(), 1);
    }
    let range = Some([levels[0], levels[levels.len() - 1]]);
    let model = Model { curve: Curve::Weibull, guess: Guess::Fixed(0.5), falls: false, overdispersed: false, range };
    estimate(&points, &model).map_or(f64::NAN, |estimate| estimate.threshold)
}

/// Returns the root mean square error of the threshold after so many trials, in base-10 logarithms.
fn error(method: &str, trials: usize) -> f64 {
    let levels: Vec<f64> = (0..23).map(|i| -2.3 + 0.1 * f64::from(i)).collect();
    let grid = Grid {
        thresholds: levels.clone(),
        slopes: vec![1.0, 1.5, 2.2, 3.2, 4.6, 6.8, 10.0],
        guesses: vec![0.5],
        lapses: vec![0.0, 0.02, 0.04, 0.06],
        gradients: vec![0.0],
    };
    let grid = match method {
        "one slope" => Grid { slopes: vec![3.2], lapses: vec![0.02], ..grid },
        _ => grid,
    };
    let stimuli: Vec<(f64, f64)> = levels.iter().map(|x| (*x, 0.0)).collect();
    let quest = Quest::new(Curve::Weibull, 1.0, &stimuli, grid);
    let truth = TRUTH.threshold + Curve::Weibull.inverse(0.5) / TRUTH.slope;
    let squares: Vec<f64> = (0..RUNS)
        .into_par_iter()
        .map(|seed| {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            let run = match method {
                "quest-plus" | "one slope" => Run::Quest(quest.clone()),
                "staircase" => {
                    let staircase = Staircase { start: 0.5, low: 0.005, high: 0.8, ..Staircase::default() };
                    Run::Stairs(Stairs::new(&staircase, &Common::default()))
                }
                // Seven levels over the whole range, as where nothing is known; or around the threshold.
                "constant" => Run::Constant((0..7).map(|i| -2.3 + 0.366 * f64::from(i)).collect()),
                _ => Run::Constant((0..7).map(|i| TRUTH.threshold - 0.45 + 0.15 * f64::from(i)).collect()),
            };
            (estimated(run, &levels, trials, &mut rng) - truth).powi(2)
        })
        .collect();
    (squares.iter().sum::<f64>() / RUNS as f64).sqrt()
}

/// Returns the root mean square error of the scale values after so many comparisons, in JND.
fn scale_error(items: usize, comparisons: usize, adaptive: bool) -> f64 {
    let squares: Vec<f64> = (0..RUNS)
        .into_par_iter()
        .map(|seed| {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            let mut draw = || -> f64 { StandardNormal.sample(&mut rng) };
            let truth: Vec<f64> = (0..items).map(|_| 1.5 * draw()).collect();
            let mean = truth.iter().sum::<f64>() / items as f64;
            let pairs: Vec<[usize; 2]> = (0..items).flat_map(|i| (i + 1..items).map(move |j| [i, j])).collect();
            let (mut ranking, mut wins) = (Ranking::new(items), Wins::zeros(items, items));
            for trial in 0..comparisons {
                let [i, j] = if adaptive { ranking.choose(unit(&mut rng)) } else { pairs[trial % pairs.len()] };
                let noise: f64 = StandardNormal.sample(&mut rng);
                let (winner, loser) = if truth[i] - truth[j] + noise > 0.0 { (i, j) } else { (j, i) };
                wins[(winner, loser)] += 1.0;
                if adaptive {
                    ranking.learn(winner, loser);
                }
            }
            let Some(scale) = Scaling::Thurstone.fit(&wins) else { return f64::NAN };
            let error = |(value, truth): (&f64, &f64)| (value - (truth - mean) / Scaling::Thurstone.jnd()).powi(2);
            scale.values.iter().zip(&truth).map(error).sum::<f64>() / items as f64
        })
        .collect();
    (squares.iter().sum::<f64>() / RUNS as f64).sqrt()
}

/// Prints the tables.
pub fn print() {
    println!("Error of the threshold in log10 units, {RUNS} sessions, Weibull, slope 3, guess .5, lapse .02");
    println!("{:<12}{}", "trials", TRIALS.map(|n| format!("{n:>7}")).concat());
    for method in ["quest-plus", "one slope", "staircase", "constant", "known"] {
        println!("{method:<12}{}", TRIALS.map(|n| format!("{:>7.3}", error(method, n))).concat());
    }
    for items in [6, 10] {
        let rounds = [1, 2, 3, 4, 6];
        let counts = rounds.map(|round| round * items * (items - 1) / 2);
        println!("Error of the scale in JND, {items} items");
        println!("{:<12}{}", "comparisons", counts.map(|n| format!("{n:>7}")).concat());
        for (name, adaptive) in [("all", false), ("adaptive", true)] {
            println!("{name:<12}{}", counts.map(|n| format!("{:>7.2}", scale_error(items, n, adaptive))).concat());
        }
    }
}
