//! From rows to counts, and the results that need no model: means, response times and intervals over participants.

use machband::{
    analysis::{
        counts::{Excluded, Exclusions, MeasuredBuilder, Part},
        summary::by_cell,
    },
    experiment::RatingRow,
};
use rand::{RngExt, SeedableRng};

const SCALE: [&str; 4] = ["0", "1", "2", "3"];

/// Participant, width and depth, rating, and repetition.
const ROWS: [(&str, [&str; 2], &str, u32); 6] = [
    ("S2", ["0.4", "1"], "3", 2),
    ("S2", ["0.4", "1"], "1", 1),
    ("S1", ["0.1", "1"], "0", 1),
    ("S10", ["0.1", "1"], "2.0", 1),
    ("S2", ["0.4", "1"], "2", 3),
    ("S1", ["0.1", "1"], "1", 2),
];

fn add<'a>(
    mut builder: MeasuredBuilder,
    rows: impl IntoIterator<Item = &'a (&'a str, [&'a str; 2], &'a str, u32)>,
) -> MeasuredBuilder {
    for (subject, values, rating, repetition) in rows {
        let (session, repetition, response_time_s) = ("1", Some(*repetition), Some(0.5 * f64::from(*repetition)));
        let row = RatingRow { subject, values, rating, count: 1, session, repetition, position: None, response_time_s };
        builder.add(&row).unwrap();
    }
    builder
}

fn empty() -> MeasuredBuilder {
    MeasuredBuilder::new(&["width", "depth"]).with_categories(&SCALE)
}

#[test]
fn counts_do_not_depend_on_the_order() {
    let whole = add(empty(), &ROWS).finish();
    assert_eq!(add(empty(), ROWS.iter().rev()).finish(), whole);
    // The first two ratings of S2 belong to repetitions 1 and 2.
    assert_eq!((whole.counts.total(), &whole.counts.subjects[..]), (6, &["S1", "S2", "S10"].map(String::from)[..]));
    assert_eq!(whole.retests(), [vec![[0, 1]], vec![[1, 3]], vec![]]);
    assert_eq!(whole.times_by(4, |row| Some(row.rating.into()))[3], Some(1.0));
}

/// An exclusion is the same as never having the ratings, except that it is recorded; each rating is counted once.
#[test]
fn exclusions_are_recorded_and_unknown_names_are_errors() {
    let mut builder = add(empty(), &ROWS);
    builder.add_counts("S1", &["", "2"], "3", 2).unwrap();
    let measured = builder.finish();
    let words = |words: &[&str]| words.iter().map(|word| (*word).to_owned()).collect::<Vec<_>>();
    let only = |factor: &str, levels: &[&str]| (factor.to_owned(), words(levels));
    let exclusions =
        Exclusions { exclude: words(&["S2", "S2"]), only: vec![only("width", &["0.1"]), only("depth", &["1"])] };
    let left = measured.narrowed(&exclusions).unwrap();
    let without = ROWS.iter().filter(|row| row.0 != "S2");
    assert_eq!(left.counts, add(empty(), without).finish().counts);
    let levels = |factor: &str, kept: &str, ratings, participants| {
        let what = Part::Levels { factor: factor.to_owned(), kept: words(&[kept]) };
        Excluded { what, ratings, participants }
    };
    let person = Excluded { what: Part::Participant("S2".to_owned()), ratings: 3, participants: 1 };
    assert_eq!(left.excluded, [person, levels("width", "0.1", 2, 1), levels("depth", "1", 0, 0)]);
    let missing =
        measured.narrowed(&Exclusions { only: vec![only("width", &["NA"])], ..Exclusions::default() }).unwrap();
    assert_eq!((missing.counts.total(), missing.excluded), (2, vec![levels("width", "NA", 6, 3)]));
    assert_eq!(measured.narrowed(&Exclusions::default()).unwrap(), measured);
}

#[test]
fn levels_are_in_natural_order_as_written() {
    for (texts, levels) in [
        (&["inf", "10", "2", "-1", "0.5", "2"][..], &["-1", "0.5", "2", "10", "inf"][..]),
        (&["b", "10", "2", "a10", "B", "a9"], &["2", "10", "B", "a9", "a10", "b"]),
        (&["0.10", "", "0.1", "1e-1", "3"], &["0.1", "0.10", "1e-1", "3"]),
    ] {
        let mut builder = MeasuredBuilder::new(&["width"]);
        texts.iter().for_each(|text| builder.add_counts("S1", &[text], "1", 1).unwrap());
        let counts = builder.finish().counts;
        assert_eq!(counts.factors[0].levels, levels);
        assert_eq!(
            counts.conditions.iter().filter(|condition| condition[0].is_none()).count(),
            usize::from(texts.contains(&""))
        );
    }
}

/// Uses times from 0.001 to 10 s in scrambled order, a time that does not belong to a single rating, and a participant
/// without times.
#[test]
fn medians_of_times_are_exact() {
    let mut builder = MeasuredBuilder::new(&["width"]);
    for (i, count) in (0..10_000).map(|i| (i, 1)).chain([(0, 2)]) {
        let seconds = f64::from(1 + i * 7919 % 10_000) / 1000.0;
        let (values, response_time_s) = (&["1"][..], Some(seconds));
        let row = RatingRow { subject: "S1", values, rating: "1", count, response_time_s, ..RatingRow::default() };
        builder.add(&row).unwrap();
    }
    let times = builder.finish().times_by(2, |row| Some(row.subject as usize));
    assert_eq!(times, [Some(5.0), None]);
}

/// Over many studies of four people, the interval of a mean covers it about as often as it claims, both in the middle of
/// the scale and near its end, where a plain t interval covers 87 % of the time.
#[test]
fn intervals_cover_the_mean() {
    let mut rng = rand_chacha::ChaCha8Rng::seed_from_u64(5);
    for (low, mean) in [(0.0, 1.5), (-1.5, 2.0 / 9.0)] {
        let (mut covered, mut given) = (0, 0);
        for _ in 0..600 {
            let mut builder = MeasuredBuilder::new(&["width"]).with_categories(&["0", "1", "2", "3"]);
            for subject in 0..4 {
                let bias: f64 = rng.random();
                for _ in 0..8 {
                    let rating = (low + 3.0 * (0.5 * bias + 0.5 * rng.random::<f64>()) + 0.5).floor().max(0.0);
                    builder.add_counts(&subject.to_string(), &["1"], &rating.to_string(), 1).unwrap();
                }
            }
            let Some(interval) = by_cell(&builder.finish().counts)[0].summary.interval else { continue };
            given += 1;
            covered += usize::from(interval.low <= mean && mean <= interval.high);
        }
        let share = f64::from(covered as u32) / f64::from(given);
        assert!((0.925..0.99).contains(&share) && given > 500, "{low}: {share} of {given}");
    }
}

/// Codes for missing answers are found beside every usual scale, and no scale has numbers that look like codes.
#[test]
fn codes_are_found_and_scales_are_not_taken_for_codes() {
    let found = |ratings: &mut dyn Iterator<Item = (String, u64)>| {
        let mut builder = MeasuredBuilder::new::<&str>(&[]);
        ratings.for_each(|(rating, n)| builder.add_counts::<&str>("S1", &[], &rating, n).unwrap());
        let counts = builder.finish().counts;
        counts.codes().into_iter().map(|(code, n)| format!("{code}:{n}")).collect::<Vec<_>>().join(" ")
    };
    let codes = |values: &[i32]| found(&mut values.iter().map(|value| (value.to_string(), 2)));
    for (scale, code) in [
        (vec![-9, 0, 1, 2, 3], "-9:2"),
        (vec![1, 2, 3, 4, 5, 99], "99:2"),
        (vec![0, 1, 2, 3, 88, 99, 999], "88:2 99:2 999:2"),
        (vec![0, 25, 50, 75, 100, 999], "999:2"),
    ] {
        assert_eq!(codes(&scale), code, "{scale:?}");
    }
    // Rare values outside the run of whole numbers, or between them, are mistakes; a next number and half points are not.
    for (each, others, expected) in [
        (20, &[("33", 1)][..], "33:1"),
        (20, &[("6", 1)], "6:1"),
        (60, &[("-7", 1), ("12", 1), ("13", 1)], "-7:1 12:1 13:1"),
        (20, &[("5", 1)], ""),
        (20, &[("2.5", 1)], "2.5:1"),
        (60, &[("1.5", 2), ("2.5", 2)], "1.5:2 2.5:2"),
        (20, &[("0.5", 9), ("2.5", 9)], ""),
        (20, &[("inf", 9), ("-inf", 9)], "-inf:9 inf:9"),
    ] {
        let others = others.iter().map(|(value, n)| ((*value).to_owned(), *n));
        let mut all = (0..=4).map(|value| (value.to_string(), each)).chain(others);
        assert_eq!(found(&mut all), expected);
    }
    let every = |step: usize| (0..=100).step_by(step).collect::<Vec<i32>>();
    let negative = |most: i32| (-most..=most).collect::<Vec<i32>>();
    for scale in [
        [every(1), every(5), every(10), every(20), every(25), every(50), every(100), (0..=1).collect()].to_vec(),
        [negative(1), negative(3), negative(10), negative(100)].to_vec(),
        (2..=11).map(|most| (1..=most).collect()).collect(),
        // Scales of which only a part was used.
        [vec![-9, 0, 9], vec![-1, 1], vec![0, 1, 3, 9], vec![-3, 0, 1, 2, 3], vec![70, 77, 88, 99], vec![-1]].to_vec(),
    ]
    .concat()
    {
        assert_eq!(codes(&scale), "", "{scale:?}");
    }
}
