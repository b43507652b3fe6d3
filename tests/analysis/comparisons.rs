//! Scales from comparisons, detection and settings: against `choix`, `statsmodels` and SciPy (the values are in
//! `tests/golden/tasks`, made by `scripts/golden_tasks.py`), and the coverage of their intervals.

use machband::{
    analysis::{
        comparisons::{Scaling, Triads, Wins},
        detection::Answers,
        settings::Settings,
        tasks::population::Mean,
    },
    statistics::Interval,
};
use rand_chacha::{ChaCha8Rng, rand_core::SeedableRng as _};

use crate::{
    common::number,
    tasks::{contains, normal, rows},
};

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

/// Returns the share of intervals that contain the truth.
fn covered(intervals: &[(Interval, f64)]) -> f64 {
    let inside = intervals.iter().filter(|(interval, truth)| contains(*interval, *truth));
    inside.count() as f64 / intervals.len() as f64
}

#[test]
fn intervals_of_scale_values_cover_people_with_scales_of_their_own() {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let truth = [-1.2, -0.4, 0.1, 0.5, 1.0];
    for people in [2, 3, 6, 12, 20] {
        let mut intervals = Vec::new();
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
            let Some(found) = Scaling::Thurstone.intervals(&all, 200, &mut rng) else {
                assert!(people < 5);
                continue;
            };
            // What the pooled model estimates: the noise of one comparison and the spread of people together.
            let shrink = 1.0 / (1.0 + 2.0 * 0.4_f64.powi(2)).sqrt() / Scaling::Thurstone.jnd();
            intervals.extend(found.into_iter().zip(truth.map(|value| value * shrink)));
        }
        let share = covered(&intervals);
        println!("{people} people: {share:.3}");
        // For two or three people, the comparisons themselves set the width, which is then too large.
        assert!((0.93..=if people < 5 { 0.995 } else { 0.985 }).contains(&share), "{people} people: {share}");
    }
    // Three people who agree say no more than their comparisons do.
    let wins = Wins::from_row_slice(3, 3, &[0.0, 6.0, 8.0, 4.0, 0.0, 6.0, 2.0, 4.0, 0.0]);
    let same = Scaling::Thurstone.intervals(&[wins.clone(), wins.clone(), wins], 200, &mut rng).unwrap();
    assert!(same.iter().all(|interval| (0.3..1.5).contains(&(interval.high - interval.low))), "{same:?}");
}

#[test]
fn settings_are_averaged_over_people() {
    let own = Settings::of(&[(1.0, Some(true)), (3.0, Some(false)), (2.0, Some(true))]).unwrap();
    assert_eq!((own.mean, own.sd, own.n, own.direction), (2.0, Some(1.0), 3, Some(-1.5)));
    let single = Settings::of(&[(2.0, None)]).unwrap();
    assert_eq!((single.sd, single.direction), (None, None));
    assert!(Settings::of(&[]).is_none());
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    let studies: Vec<(Interval, f64)> = (0..2000)
        .map(|_| {
            let values: Vec<f64> = (0..5).map(|_| 0.7 + 0.3 * normal(&mut rng)).collect();
            (Mean::new(&values).interval.unwrap(), 0.7)
        })
        .collect();
    assert!((0.93..=0.97).contains(&covered(&studies)), "{}", covered(&studies));
}
