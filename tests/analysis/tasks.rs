//! Compares psychometric functions with psignifit, and scales from comparisons and detection with `choix`, `statsmodels` and
//! SciPy (`tests/golden/tasks`, made by `scripts/golden_tasks.py`); checks on simulated studies that intervals and tests
//! are calibrated.

use std::collections::BTreeMap;

use machband::{
    analysis::{
        comparisons::{Scaling, Triads, Wins},
        tasks::{
            person::{Answers, Settings},
            population::{self, Mean},
            psychometric::{Estimate, Guess, Model, Point, fit, goodness_of_fit},
        },
    },
    experiment::task::curve::Curve,
    statistics::Interval,
};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Beta, Distribution, StandardNormal};
use rayon::prelude::*;

use crate::common::{Record, golden_path, number, records};

pub fn rows(name: &str) -> Vec<Record> {
    records(&golden_path("tasks").join(name))
}

fn point(row: &Record) -> Point {
    Point { x: number(row, "level"), correct: number(row, "correct"), total: number(row, "total") }
}

const MODEL: Model =
    Model { curve: Curve::Normal, guess: Guess::Fixed(0.5), falls: false, overdispersed: true, range: None };

pub fn normal(rng: &mut ChaCha8Rng) -> f64 {
    StandardNormal.sample(rng)
}

fn binomial(total: u32, chance: f64, rng: &mut ChaCha8Rng) -> u32 {
    (0..total).filter(|_| rng.random::<f64>() < chance).count() as u32
}

/// Answers at equidistant levels from −3 to 3.
fn study(model: &Model, truth: &Estimate, levels: u32, total: u32, rng: &mut ChaCha8Rng) -> Vec<Point> {
    let function = model.parameters(truth);
    let mut point = |level: u32| {
        let x = -3.0 + 6.0 * f64::from(level) / f64::from(levels - 1);
        let mut chance = model.curve.probability(x, &function);
        if truth.overdispersion > 0.0 {
            let nu = truth.overdispersion.powi(-2) - 1.0;
            // Beyond, the distribution has no mass that a number could represent.
            chance = chance.clamp(1e-9, 1.0 - 1e-9);
            chance = Beta::new(chance * nu, (1.0 - chance) * nu).unwrap().sample(rng);
        }
        Point { x, correct: binomial(total, chance, rng), total }
    };
    (0..levels).map(&mut point).collect()
}

/// Checks that 95 % of the studies are covered, to 2.5 standard errors of the number of studies.
#[track_caller]
fn assert_covers(covered: usize, studies: usize) {
    let (share, se) = (covered as f64 / studies as f64, (0.95 * 0.05 / studies as f64).sqrt());
    assert!((share - 0.95).abs() < 2.5 * se, "{covered} of {studies}");
}

#[test]
fn estimates_and_intervals_match_psignifit() {
    let mut data: BTreeMap<String, Vec<Point>> = BTreeMap::new();
    rows("psignifit_data.csv").iter().for_each(|row| data.entry(row["dataset"].clone()).or_default().push(point(row)));
    let expected = rows("psignifit.csv");
    for row in &expected {
        let curve = row["sigmoid"].parse().unwrap_or(Curve::Normal);
        let guess = match row["experiment"].as_str() {
            "2AFC" => Guess::Fixed(0.5),
            "4AFC" => Guess::Fixed(0.25),
            _ => Guess::Free,
        };
        let mut points = data[&row["dataset"]].clone();
        if curve == Curve::Weibull {
            points.iter_mut().for_each(|point| point.x = point.x.log10());
        }
        let fit = fit(&points, &Model { curve, guess, ..MODEL }).unwrap();
        let value = |column: &str| number::<f64>(row, column);
        let width = value("width");
        let near = |found: f64, expected: &str, most: f64| {
            let difference = (found - value(expected)).abs();
            assert!(difference <= most, "{} {expected}: {found}, not {}", row["dataset"], row[expected]);
        };
        // psignifit's search ends early; the others are the same maximum to more digits.
        near(fit.estimate.threshold, "threshold", 0.01 * width);
        near(fit.slope, "slope", 0.03 * fit.slope);
        near(fit.estimate.threshold, "tight_threshold", 1e-4 * width);
        near(fit.estimate.width, "tight_width", 1e-4 * width);
        near(fit.estimate.lapse, "tight_lapse", 1e-4);
        near(fit.estimate.guess, "tight_guess", 1e-4);
        near(fit.estimate.overdispersion, "tight_eta", 1e-3);
        // The limits of psignifit are about half a step of its grid, 3 % of an interval, too low.
        let [threshold, widths] =
            ["threshold", "width"].map(|name| value(&format!("{name}_high")) - value(&format!("{name}_low")));
        near(fit.threshold.low, "threshold_low", 0.1 * threshold);
        near(fit.threshold.high, "threshold_high", 0.1 * threshold);
        near(fit.width.low, "width_low", 0.1 * widths);
        near(fit.width.high, "width_high", 0.1 * widths);
    }
    assert_eq!(expected.len(), 51);
}

#[test]
fn a_falling_curve_is_the_mirror_image() {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    for curve in [Curve::Normal, Curve::Logistic, Curve::Weibull] {
        let rising = Model { curve, ..MODEL };
        let truth = Estimate { threshold: 0.4, width: 2.0, lapse: 0.02, guess: 0.5, overdispersion: 0.0 };
        let points = study(&rising, &truth, 9, 40, &mut rng);
        let mirrored: Vec<Point> = points.iter().map(|point| Point { x: -point.x, ..*point }).collect();
        let [up, down] = [(&points, rising), (&mirrored, Model { falls: true, ..rising })];
        let (up, down) = (fit(up.0, &up.1).unwrap(), fit(down.0, &down.1).unwrap());
        let near = |l: f64, r: f64| assert!((l - r).abs() < 1e-4 * (1.0 + l.abs()), "{curve}: {up:?} {down:?}");
        near(up.estimate.threshold, -down.estimate.threshold);
        near(up.estimate.width, down.estimate.width);
        near(up.slope, -down.slope);
        near(up.threshold.low, -down.threshold.high);
        near(up.slope_interval.low, -down.slope_interval.high);
        assert!(down.slope < 0.0 && down.slope_interval.contains(down.slope));
    }
}

/// A threshold and a width from the priors of psignifit for levels from −3 to 3 at distances of 1.
fn from_priors(guess: Guess, rng: &mut ChaCha8Rng) -> Estimate {
    let mut draw = |low: f64, high: f64, density: &dyn Fn(f64) -> f64| {
        loop {
            let x = rng.random_range(low..high);
            if rng.random::<f64>() < density(x) {
                return x;
            }
        }
    };
    let fall = |share: f64| (1.0 + (std::f64::consts::PI * share.clamp(0.0, 1.0)).cos()) / 2.0;
    let threshold = draw(-6.0, 6.0, &|x| fall((x.abs() - 3.0) / 3.0));
    let width = draw(1.0, 18.0, &|x| if x < 2.0 { fall(2.0 - x) } else { fall((x - 6.0) / 12.0) });
    let mut share = || Beta::new(1.0, 10.0).unwrap().sample(rng);
    let [lapse, free, overdispersion] = [share(), share(), share()];
    let guess = if let Guess::Fixed(guess) = guess { guess } else { free };
    Estimate { threshold, width, lapse: lapse.min(0.49), guess: guess.min(0.5), overdispersion }
}

/// Counts, for each of several checks, the studies that pass it; each study has its own random numbers.
fn passed<const N: usize>(studies: u64, study: impl Fn(&mut ChaCha8Rng) -> [bool; N] + Sync) -> [usize; N] {
    let one = |seed: u64| study(&mut ChaCha8Rng::seed_from_u64(seed)).map(usize::from);
    let sum = |l: [usize; N], r: [usize; N]| std::array::from_fn(|i| l[i] + r[i]);
    (0..studies).into_par_iter().map(one).reduce(|| [0; N], sum)
}

#[test]
fn intervals_cover_parameters_from_the_priors() {
    for guess in [Guess::Fixed(0.5), Guess::Free] {
        let model = Model { guess, ..MODEL };
        let covered = passed(300, |rng| {
            let truth = from_priors(guess, rng);
            let fit = fit(&study(&model, &truth, 7, 20, rng), &model).unwrap();
            let function = model.parameters(&truth);
            let [below, above] = [-1e-4, 1e-4].map(|by| model.curve.probability(truth.threshold + by, &function));
            let pairs = [(fit.threshold, truth.threshold), (fit.width, truth.width)];
            let [threshold, width] = pairs.map(|(interval, value)| interval.contains(value));
            [threshold, width, fit.slope_interval.contains((above - below) / 2e-4)]
        });
        covered.into_iter().for_each(|covered| assert_covers(covered, 300));
    }
}

/// Single trials at many levels, as adaptive procedures give them, and studies that say nothing.
#[test]
fn any_answers_have_a_fit() {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let truth = Estimate { threshold: 0.0, width: 2.0, lapse: 0.02, guess: 0.5, overdispersion: 0.0 };
    let single = study(&MODEL, &truth, 60, 1, &mut rng);
    let adaptive = fit(&single, &Model { range: Some([-3.0, 3.0]), ..MODEL }).unwrap();
    assert!(adaptive.threshold.contains(0.0) && adaptive.estimate.overdispersion == 0.0, "{adaptive:?}");
    assert!(!adaptive.is_steep, "{adaptive:?}");
    for [below, above] in [[20, 20], [0, 0], [10, 10], [10, 20], [20, 10]] {
        let point = |x: i32| Point { x: x.into(), correct: if x < 0 { below } else { above }, total: 20 };
        let points: Vec<Point> = (-3..=3).map(point).collect();
        for guess in [Guess::Fixed(0.5), Guess::Fixed(0.0), Guess::Fixed(0.99), Guess::Free] {
            let fit = fit(&points, &Model { guess, ..MODEL }).unwrap();
            for interval in [fit.threshold, fit.width, fit.slope_interval] {
                assert!(interval.low < interval.high && interval.high.is_finite(), "{guess:?} {points:?} {fit:?}");
            }
            // Between two levels, only the prior says how steeply it rises.
            assert!(below >= above || guess != Guess::Fixed(0.5) || fit.determined_slopes().is_none(), "{fit:?}");
        }
    }
}

#[test]
fn the_test_of_the_fit_is_calibrated_and_finds_overdispersion() {
    let mut rng = ChaCha8Rng::seed_from_u64(6);
    let mut rejected = |overdispersion: f64, total: u32| {
        let truth = Estimate { threshold: 0.3, width: 3.0, lapse: 0.02, guess: 0.5, overdispersion };
        let one =
            |_| goodness_of_fit(&study(&MODEL, &truth, 7, total, &mut rng), &MODEL, 59, &mut rng).unwrap().p <= 0.1;
        (0..200).map(one).filter(|is_rejected| *is_rejected).count()
    };
    let few = rejected(0.0, 30);
    assert!((10..=30).contains(&few), "{few} of 200");
    let many = rejected(0.2, 100);
    assert!(many > 140, "{many} of 200");
}

/// The people of a simulated study: their points in each condition.
fn people() -> BTreeMap<String, Vec<Vec<Point>>> {
    let mut conditions: BTreeMap<String, BTreeMap<String, Vec<Point>>> = BTreeMap::new();
    for row in rows("people.csv") {
        let own = conditions.entry(row["condition"].clone()).or_default();
        own.entry(row["person"].clone()).or_default().push(point(&row));
    }
    conditions.into_iter().map(|(condition, people)| (condition, people.into_values().collect())).collect()
}

/// Integrates over each person's threshold by the midpoint rule.
#[test]
fn the_likelihood_of_a_population_is_the_integral() {
    for (name, own) in people() {
        let fit = population::fit(&own, &MODEL).unwrap();
        let steps = 4000;
        let person = |points: &Vec<Point>| {
            let density = |step: u32| {
                let z = -8.0 + 16.0 * (f64::from(step) + 0.5) / f64::from(steps);
                let threshold = fit.function.threshold + fit.sd * z;
                let at = Estimate { threshold, ..fit.function };
                let function = MODEL.parameters(&at);
                let ln = |point: &Point| {
                    let chance = MODEL.curve.probability(point.x, &function);
                    f64::from(point.correct) * chance.ln()
                        + f64::from(point.total - point.correct) * (1.0 - chance).ln()
                };
                (points.iter().map(ln).sum::<f64>() - z * z / 2.0).exp()
            };
            let sum: f64 = (0..steps).map(density).sum();
            (sum * 16.0 / f64::from(steps) / (2.0 * std::f64::consts::PI).sqrt()).ln()
        };
        let expected: f64 = own.iter().map(person).sum();
        assert!((fit.log_likelihood - expected).abs() < 1e-6, "{name}: {} {expected}", fit.log_likelihood);
    }
}

#[test]
fn means_and_differences_of_populations_are_covered() {
    for people in [3, 6] {
        let covered = passed(200, |rng| {
            let shifts: Vec<f64> = (0..people).map(|_| 0.7 * normal(rng)).collect();
            let [first, second] = [0.0, 0.5].map(|mean| {
                let mut own = |shift: &f64| {
                    let threshold = mean + shift + 0.3 * normal(rng);
                    let truth = Estimate { threshold, width: 4.0, lapse: 0.03, guess: 0.5, overdispersion: 0.0 };
                    study(&MODEL, &truth, 7, 15, rng)
                };
                population::fit(&shifts.iter().map(&mut own).collect::<Vec<_>>(), &MODEL).unwrap()
            });
            let pairs = second.contributions.iter().zip(&first.contributions);
            let difference = Mean::new(&pairs.map(|(second, first)| second - first).collect::<Vec<_>>());
            [first.interval.unwrap().contains(0.0), difference.interval.unwrap().contains(0.5)]
        });
        covered.into_iter().for_each(|covered| assert_covers(covered, 200));
    }
}

/// Where all functions rise between the same two levels, nothing says where. A guess rate of 0 with a low threshold is a
/// maximum of its own: 8 people whose rate is ½ and whose thresholds are about 0.
#[test]
fn what_answers_do_not_determine_is_not_told() {
    let own = |right: u32| -> Vec<Point> {
        (0..7).map(|level| Point { x: level.into(), correct: if level < 3 { right } else { 60 }, total: 60 }).collect()
    };
    let model = Model { range: Some([0.0, 6.0]), ..MODEL };
    let population = population::fit(&[30, 33, 27, 30].map(own), &model).unwrap();
    assert!(population.interval.is_none() && (2.0..3.0).contains(&population.function.threshold), "{population:?}");
    let model = Model { guess: Guess::Free, overdispersed: false, range: Some([-0.602, 0.903]), ..MODEL };
    let right = "14 10 13 20 23 24|11 10 21 23 23 24|10 17 12 19 24 23|10 14 20 22 24 23|14 12 21 23 24 24|11 20 20 23 24 22|\
                 10 18 21 23 23 22|11 11 13 19 23 24";
    let own = |right: &str| -> Vec<Point> {
        let right = right.split(' ').map(|count| count.parse().unwrap());
        let x = [-0.602, -0.301, 0.0, 0.301, 0.602, 0.903].into_iter();
        x.zip(right).map(|(x, correct)| Point { x, correct, total: 24 }).collect()
    };
    let people: Vec<Vec<Point>> = right.split('|').map(own).collect();
    let function = population::fit(&people, &model).unwrap().function;
    assert!(function.guess > 0.3 && function.threshold.abs() < 0.1, "{function:?}");
}

/// Without them, the levels of an adaptive method, most of which are seen, say next to nothing about the guess rate.
#[test]
fn catch_trials_tell_the_guess_rate() {
    for falls in [false, true] {
        let model = Model { guess: Guess::Free, falls, overdispersed: false, range: Some([-3.0, 3.0]), ..MODEL };
        let truth = Estimate { threshold: 0.0, width: 2.0, lapse: 0.02, guess: 0.35, overdispersion: 0.0 };
        let mut rng = ChaCha8Rng::seed_from_u64(8);
        let side = if falls { -1.0 } else { 1.0 };
        let mut person = |catches: u32| -> Vec<Point> {
            let function = model.parameters(&truth);
            let mut points: Vec<Point> = [0.0, 0.5, 1.0, 2.0]
                .map(|x| {
                    let chance = model.curve.probability(side * x, &function);
                    Point { x: side * x, correct: binomial(30, chance, &mut rng), total: 30 }
                })
                .to_vec();
            Point::add(&mut points, model.unseen(), binomial(catches, truth.guess, &mut rng), catches);
            points
        };
        let people: Vec<Vec<Point>> = (0..8).map(|_| person(40)).collect();
        let own: Vec<f64> = people.iter().map(|points| fit(points, &model).unwrap().estimate.guess).collect();
        let mean = own.iter().sum::<f64>() / own.len() as f64;
        assert!((mean - truth.guess).abs() < 0.06, "{own:?}");
        let population = population::fit(&people, &model).unwrap();
        assert!(
            (population.function.guess - truth.guess).abs() < 0.06 && population.interval.unwrap().contains(0.0),
            "{population:?}"
        );
        assert!(goodness_of_fit(&people[0], &model, 19, &mut rng).unwrap().deviance.is_finite());
    }
}

#[test]
fn scale_values_are_those_of_other_programs() {
    let (data, expected) = (rows("pairs_data.csv"), rows("pairs.csv"));
    let mut sets = 0;
    for rows in expected.chunk_by(|a, b| a["dataset"] == b["dataset"]) {
        let mut wins = Wins::zeros(rows.len(), rows.len());
        for row in data.iter().filter(|row| row["dataset"] == rows[0]["dataset"]) {
            wins[(number(row, "winner"), number(row, "loser"))] += number::<f64>(row, "count");
        }
        for (scaling, column) in [(Scaling::BradleyTerry, "bradley_terry"), (Scaling::Thurstone, "thurstone")] {
            let scale = scaling.fit(&wins).unwrap();
            assert!(!scale.is_limited);
            for (row, value) in rows.iter().zip(&scale.values) {
                let expected = number::<f64>(row, column) / scaling.jnd();
                assert!((value - expected).abs() < 1e-6, "{} {column}: {value}, expected {expected}", row["dataset"]);
            }
        }
        sets += 1;
    }
    assert_eq!(sets, 13);
}

#[test]
fn an_item_that_always_wins_is_limited_and_told() {
    let wins = Wins::from_row_slice(3, 3, &[0.0, 9.0, 9.0, 0.0, 0.0, 5.0, 0.0, 4.0, 0.0]);
    let scale = Scaling::Thurstone.fit(&wins).unwrap();
    assert!(scale.is_limited && scale.values.iter().all(|value| value.is_finite()), "{scale:?}");
    assert!(scale.values[0] > scale.values[1] + 1.0 && scale.values[1] > scale.values[2], "{scale:?}");
    assert!(Scaling::Thurstone.fit(&Wins::zeros(3, 3)).is_none());
}

#[test]
fn circular_triads_are_counted() {
    // a > b > c > a, and all three over d.
    let mut wins = Wins::zeros(4, 4);
    for place in [(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)] {
        wins[place] = 2.0;
    }
    assert_eq!(Triads::of(&wins), Triads { circular: 1, all: 4 });
    wins[(3, 2)] = 2.0;
    assert_eq!(Triads::of(&wins), Triads { circular: 1, all: 2 });
}

#[test]
fn detection_is_that_of_another_program() {
    let rows = rows("detection.csv");
    for row in &rows {
        let count = |column: &str| number(row, column);
        let answers = Answers {
            hits: count("hits"),
            misses: count("misses"),
            false_alarms: count("false_alarms"),
            correct_rejections: count("correct_rejections"),
        };
        let found = answers.detection().unwrap();
        assert!((found.d_prime - number::<f64>(row, "d_prime")).abs() < 1e-9, "{row:?}");
        assert!((found.criterion - number::<f64>(row, "criterion")).abs() < 1e-9, "{row:?}");
    }
    assert!(rows.len() >= 20);
    assert!(Answers { hits: 3, misses: 1, ..Answers::default() }.detection().is_none());
}

/// The effect of the direction is the mean of the settings that began above, minus that of those that began below.
#[test]
fn settings_have_a_mean_a_spread_and_an_effect_of_their_start() {
    let own = Settings::of(&[(1.0, Some(true)), (3.0, Some(false)), (2.0, Some(true))]).unwrap();
    assert_eq!((own.mean, own.sd, own.n, own.direction), (2.0, Some(1.0), 3, Some(-1.5)));
    assert!(Settings::of(&[]).is_none());
}

/// Returns the share of intervals that contain the truth.
fn covered(intervals: &[(Interval, f64)]) -> f64 {
    let inside = intervals.iter().filter(|(interval, truth)| interval.contains(*truth));
    inside.count() as f64 / intervals.len() as f64
}

#[test]
fn intervals_of_scale_values_cover_people_with_scales_of_their_own() {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let truth = [-1.2, -0.4, 0.1, 0.5, 1.0];
    for people in [2, 3, 6, 12, 20] {
        let (mut intervals, mut differences) = (Vec::new(), Vec::new());
        for _ in 0..120 {
            let person = |rng: &mut ChaCha8Rng| {
                let own: Vec<f64> = truth.iter().map(|value| value + 0.4 * normal(rng)).collect();
                let mut wins = Wins::zeros(5, 5);
                for (i, j) in (0..5).flat_map(|i| (i + 1..5).map(move |j| (i, j))) {
                    for _ in 0..4 {
                        let first = own[i] - own[j] + normal(rng) > 0.0;
                        wins[if first { (i, j) } else { (j, i) }] += 1.0;
                    }
                }
                wins
            };
            let all: Vec<Wins> = (0..people).map(|_| person(&mut rng)).collect();
            // Two or three people whose own comparisons do not determine a scale say too little about others.
            let Some(found) = Scaling::Thurstone.drawn(&all, 200, &mut rng) else {
                assert!(people < 5);
                continue;
            };
            // What the pooled model estimates: the noise of one comparison and the spread of people together.
            let shrink = 1.0 / (1.0 + 2.0 * 0.4_f64.powi(2)).sqrt() / Scaling::Thurstone.jnd();
            intervals.extend((0..5).map(|item| (found.mean(item, None).interval.unwrap(), truth[item] * shrink)));
            differences.push((found.mean(1, Some(3)).interval.unwrap(), (truth[1] - truth[3]) * shrink));
        }
        let share = covered(&intervals);
        println!("{people} people: {share:.3}");
        // For two or three people, the comparisons themselves set the width, which is then too large.
        assert!((0.93..=if people < 5 { 0.995 } else { 0.985 }).contains(&share), "{people} people: {share}");
        assert!(covered(&differences) >= 0.89, "{people} people: {}", covered(&differences));
    }
    // Three people who agree say no more than their comparisons do.
    let wins = Wins::from_row_slice(3, 3, &[0.0, 6.0, 8.0, 4.0, 0.0, 6.0, 2.0, 4.0, 0.0]);
    let same = Scaling::Thurstone.drawn(&[wins.clone(), wins.clone(), wins], 200, &mut rng).unwrap();
    let same = (0..3).map(|item| same.mean(item, None).interval.unwrap());
    assert!(same.clone().all(|interval| (0.3..1.5).contains(&(interval.high - interval.low))), "{same:?}");
}
