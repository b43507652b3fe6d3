//! Tests of inference with few people: each test and interval says no more than the data carry.

use machband::analysis::{
    Comparison, ModelSpec, Note, Options, Random, Slopes, Withheld, analyze,
    counts::{Measured, MeasuredBuilder},
    fit_with_tests,
    rank_tests::{SubjectMeans, friedman},
    summary::by_factor,
};
use machband::report::study::summary;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::{
    common::{golden_path, table},
    report::{page, source},
    studies::{self, options},
};

/// Ratings 0–3 of a latent value: thresholds at −1.5, 0 and 1.5, and logistic noise.
pub fn rate(latent: f64, rng: &mut ChaCha8Rng) -> String {
    let uniform: f64 = rng.random_range(1e-9..1.0 - 1e-9);
    let latent = latent + (uniform / (1.0 - uniform)).ln();
    [-1.5, 0.0, 1.5].iter().filter(|threshold| latent > **threshold).count().to_string()
}

/// A study of one factor with levels a, b, …: `shift` returns the latent value for a person and a level.
fn study(people: usize, levels: &[&str], ratings: usize, seed: u64, shift: impl Fn(usize, usize) -> f64) -> Measured {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut builder = MeasuredBuilder::new(&["level"]).with_categories(&["0", "1", "2", "3"]);
    for person in 0..people {
        for (index, level) in levels.iter().enumerate() {
            for _ in 0..ratings {
                let rating = rate(shift(person, index), &mut rng);
                builder.add_counts(&format!("S{person:02}"), &[*level], &rating, 1).unwrap();
            }
        }
    }
    builder.finish()
}

fn slopes(slopes: Slopes) -> ModelSpec {
    ModelSpec { random: Random::Subject, slopes, ..ModelSpec::new("level".parse().unwrap()) }
}

/// Complete enumerations by another program: tests/golden/ordinal/exact.csv.
#[test]
fn rank_tests_match_complete_enumeration() {
    let (_, rows) = table(&golden_path("ordinal").join("exact.csv"));
    for row in &rows {
        let number = |text: &str| text.parse::<f64>().unwrap();
        let values: Vec<Vec<f64>> = row[1].split(';').map(|one| one.split(' ').map(number).collect()).collect();
        let (statistic, p) = (number(&row[2]), number(&row[3]));
        let levels = (0..values[0].len()).map(|level| level.to_string()).collect();
        let people = values.into_iter().enumerate().map(|(person, row)| (person.to_string(), row)).collect();
        let means = SubjectMeans { levels, rows: people, incomplete: Vec::new(), tolerance: 1e-9 };
        let Some(test) = friedman(&means) else {
            assert_eq!(p, 1.0, "{row:?}");
            continue;
        };
        assert!((test.p - p).abs() < 1e-9 && test.is_exact, "{row:?} {test:?}");
        assert!((test.chi_squared - statistic).abs() < 1e-9, "{row:?} {test:?}");
    }
    assert_eq!(rows.len(), 28);
}

/// Level a was mostly rated on the easy side and c on the hard side. The side matters and the level does not: pooled
/// means differ, but means of cell means and the tests do not.
#[test]
fn unequal_numbers_of_ratings_are_no_effect() {
    let mut builder = MeasuredBuilder::new(&["level", "side"]).with_categories(&["0", "1", "2", "3"]);
    for subject in 0..8 {
        for (level, easy, hard) in [("a", 6, 2), ("b", 4, 4), ("c", 2, 6)] {
            for (side, number, ratings) in [("easy", easy, ["3", "2"]), ("hard", hard, ["0", "1"])] {
                let subject = subject.to_string();
                ratings.iter().for_each(|r| builder.add_counts(&subject, &[level, side], r, number / 2).unwrap());
            }
        }
    }
    let counts = builder.finish().counts;
    let means: Vec<f64> = by_factor(&counts, 0).iter().map(|group| group.summary.mean).collect();
    assert_eq!(means, [1.5, 1.5, 1.5]);
    assert_eq!(friedman(&SubjectMeans::new(&counts, 0)), None, "all levels are alike");
    assert!(friedman(&SubjectMeans::new(&counts, 1)).unwrap().p < 0.01);
}

/// Half of the people rate b higher and half lower. A model in which everyone has the same effect finds one where there
/// is none; with slopes, it does not.
#[test]
fn people_who_differ_are_not_an_effect() {
    let mut found = [0, 0];
    for seed in 0..20 {
        let mut rng = ChaCha8Rng::seed_from_u64(100 + seed);
        let own: Vec<f64> = (0..8).map(|_| rng.random_range(-1.2..1.2)).collect();
        let measured = study(8, &["a", "b"], 60, seed, |person, level| if level == 1 { own[person] } else { 0.0 });
        for (place, slopes_of) in [Slopes::None, Slopes::Independent].into_iter().enumerate() {
            let report = fit_with_tests(&measured.counts, &slopes(slopes_of), None).unwrap();
            found[place] += usize::from(report.terms[0].p.unwrap() < 0.05);
        }
    }
    assert!(found[0] >= 7 && found[1] <= 4, "of 20 studies: {found:?}");
}

/// Two people in each group cannot tell groups apart. Before, p was below 0.05 in 21 % of studies without an effect.
#[test]
fn tests_between_few_people_are_withheld() {
    for (people, withheld) in [(4, Some(Withheld::FewPerLevel)), (8, None)] {
        let mut rng = ChaCha8Rng::seed_from_u64(9);
        let mut builder = MeasuredBuilder::new(&["group"]).with_categories(&["0", "1", "2", "3"]);
        for person in 0..people {
            let own: f64 = rng.random_range(-2.0..2.0);
            for _ in 0..12 {
                let group = ["x", "y"][person % 2];
                builder.add_counts(&person.to_string(), &[group], &rate(own, &mut rng), 1).unwrap();
            }
        }
        let results = analyze(builder.finish(), &options(None));
        let report = results.model.as_ref().unwrap();
        assert_eq!(report.terms[0].withheld, withheld);
        assert_eq!(report.terms[0].p.is_none(), withheld.is_some());
        assert_eq!(report.model.coefficients[0].interval.is_none(), withheld.is_some());
        assert!(!results.factors[0].within && results.factors[0].friedman.is_none());
    }
}

/// With one rating of each person, ratings are independent: the model is R's `clm`, and its test is believed.
#[test]
fn one_rating_of_each_person_needs_no_random_intercept() {
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let mut builder = MeasuredBuilder::new(&["group"]).with_categories(&["0", "1", "2", "3"]);
    for person in 0..60 {
        let rating = rate([-1.0, 1.0][person % 2], &mut rng);
        builder.add_counts(&person.to_string(), &[["x", "y"][person % 2]], &rating, 1).unwrap();
    }
    let measured = builder.finish();
    for (random, notes) in [(None, &[Note::OneRatingEach][..]), (Some(Random::None), &[])] {
        let results = analyze(measured.clone(), &Options { random, ..options(None) });
        let model = &results.model.as_ref().unwrap().model;
        assert!(model.random.is_none() && model.notes == notes, "{:?}", model.notes);
        let summary = summary(&source(&[]), &results);
        let is_tested = summary.findings[0].contains("likelihood-ratio test");
        assert!(is_tested && summary.cautions.is_empty(), "{summary:?}");
    }
}

/// Level b is at the ceiling, so that no mixed model can be fitted; people differ, and the groups do not. A model without people
/// would find a difference of the groups in 38 of 100 such studies: nothing of it is a test.
#[test]
fn without_a_mixed_model_there_are_no_tests() {
    for seed in 0..12 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut builder = MeasuredBuilder::new(&["w", "grp"]).with_categories(&["0", "1", "2", "3"]);
        for person in 0..8 {
            let own: f64 = rng.random_range(-4.0..4.0);
            for repetition in 0..50 {
                let is_high = own + rng.random_range(-3.0..3.0) > 0.0;
                let (w, rating) = if repetition % 2 == 0 { ("b", "3") } else { ("a", if is_high { "1" } else { "0" }) };
                builder.add_counts(&format!("P{person}"), &[w, ["x", "y"][person % 2]], rating, 1).unwrap();
            }
        }
        let measured = builder.finish();
        let results = analyze(measured.clone(), &options(None));
        let report = results.model.as_ref().unwrap();
        assert!(report.model.notes.contains(&Note::NoMixedModel), "{:?}", report.model.notes);
        let reason = Some(Withheld::NoMixedModel);
        assert!(report.terms.iter().all(|test| (test.p, test.withheld) == (None, reason)), "{:?}", report.terms);
        let coefficients = &report.model.coefficients;
        assert!(coefficients.iter().all(|c| (c.se, c.p, c.interval) == (None, None, None)), "{coefficients:?}");
        assert!(report.comparisons.iter().all(|c| c.p.is_none() && c.interval.is_none() && c.withheld == reason));
        assert!(report.predictions.iter().all(|prediction| prediction.interval.is_none()));
        assert!(report.margins.iter().all(|margin| margin.interval.is_none()));
        let findings = summary(&source(&[]), &results).findings;
        let expected = "The effect of grp could not be tested: no mixed model could be fitted";
        assert!(findings.iter().any(|text| text.contains(expected)), "{findings:?}");
        let page = page(&source(&["w", "grp"]), &results);
        assert!(page.contains("No p for w and grp: no mixed model"));
    }
}

/// If the test of a term is withheld, nothing else about it is significant: before, comparisons and intervals rejected in 30 %
/// of studies without an effect. A slope is needed only where somebody rated a level twice.
#[test]
fn what_contradicts_a_withheld_test_is_withheld() {
    let mut builder = MeasuredBuilder::new(&["level"]);
    for (person, ratings) in [[1, 2], [2, 4], [0, 1], [3, 3], [1, 3], [2, 3]].iter().enumerate() {
        for (level, rating) in ["a", "b"].iter().zip(ratings) {
            builder.add_counts(&person.to_string(), &[*level], &rating.to_string(), 1).unwrap();
        }
    }
    let unsupported = study(10, &["a", "b"], 2, 4, |_, level| level as f64);
    for (measured, reason) in [(builder.finish(), Withheld::TooFew), (unsupported, Withheld::NoSlope)] {
        let results = analyze(measured, &options(None));
        let report = results.model.as_ref().unwrap();
        assert_eq!((report.terms[0].p, report.terms[0].withheld), (None, Some(reason)));
        let compared = &report.comparisons[0];
        assert_eq!((compared.p_holm, compared.interval, compared.withheld), (None, None, Some(reason)));
        assert!(report.model.coefficients[0].interval.is_none());
        let finding = &summary(&source(&[]), &results).findings[0];
        assert!(finding.contains("Friedman test") && !finding.contains("odds"), "{finding}");
        let excludes_0 = finding.contains("interval") && !finding.contains("interval −");
        assert!(!excludes_0 || results.factors[0].friedman.unwrap().p < 0.05, "{finding}");
    }
    let once = analyze(study(12, &["a", "b", "c"], 1, 4, |_, level| level as f64), &options(None));
    let report = once.model.as_ref().unwrap();
    assert!(report.model.random.as_ref().unwrap().slopes.is_empty() && report.terms[0].p.is_some());
    assert!(summary(&source(&[]), &once).findings[0].contains("likelihood-ratio test"));
}

/// An effect that differs along the scale shows in the proportions at its levels, and one that does not differ does not.
#[test]
fn the_checks_find_effects_that_differ_along_the_scale() {
    for (other, is_poor) in [([2, 10, 10, 2], true), ([4, 8, 8, 4], false)] {
        let mut builder = MeasuredBuilder::new(&["level"]).with_categories(&["0", "1", "2", "3"]);
        for person in 0..12 {
            for (level, tally) in [("a", [5, 7, 7, 5]), ("b", other)] {
                for (rating, count) in tally.into_iter().enumerate() {
                    builder.add_counts(&person.to_string(), &[level], &rating.to_string(), count).unwrap();
                }
            }
        }
        let results = analyze(builder.finish(), &options(None));
        assert_eq!(results.model.unwrap().checks.unwrap().is_poor(), is_poor, "{other:?}");
    }
}

/// Simulated p values are the same for the same seed, from a tail where no study reaches the ratio, and given below 41
/// people only.
#[test]
fn few_people_are_calibrated_by_simulation() {
    let strong = |people| study(people, &["a", "b"], 12, 2, |_, level| 2.5 * level as f64);
    let results = analyze(strong(5), &options(None));
    let test = &results.model.as_ref().unwrap().terms[0];
    assert!(test.draws == Some(99) && test.p.unwrap() < 0.01, "{test:?}");
    assert_eq!(analyze(strong(5), &options(None)).model, results.model);
    let many = analyze(strong(41), &options(None));
    let test = &many.model.as_ref().unwrap().terms[0];
    assert!(test.draws.is_none() && test.p.unwrap() < 1e-6, "{test:?}");
}

/// The test of a factor with two levels and the interval of its coefficient agree.
#[test]
fn intervals_agree_with_tests() {
    let mut excluded = 0;
    for seed in 0..16 {
        let results = analyze(study(5, &["a", "b"], 10, seed, |_, level| 0.5 * level as f64), &options(None));
        let report = results.model.as_ref().unwrap();
        let (p, interval) = (report.terms[0].p.unwrap(), report.model.coefficients[0].interval.unwrap());
        let excludes = interval.low > 0.0 || interval.high < 0.0;
        assert!(excludes == (p < 0.05) || (p - 0.05).abs() < 0.011, "seed {seed}: p {p}, {interval:?}");
        // A difference has one interval, wherever it is told.
        assert_eq!(report.comparisons[0].interval, Some(interval));
        excluded += usize::from(excludes);
    }
    assert!((1..16).contains(&excluded), "{excluded}");
}

/// In an interaction, each factor is compared at each level of the other, and Holm's correction never lowers p.
#[test]
fn interactions_have_simple_effects() {
    let rows = [["a", "l"], ["b", "l"], ["a", "r"], ["b", "r"]];
    let measured = studies::study(&["level", "side"], &rows, (10, 10, 12), |_, row| Some([0.0, 2.0, 0.0, 0.0][row]));
    let results = analyze(measured, &options(Some("level*side")));
    let comparisons = &results.model.as_ref().unwrap().comparisons;
    let at = |side: &str| {
        let found = |c: &&Comparison| c.factor == "level" && c.at == Some(("side".to_owned(), side.to_owned()));
        comparisons.iter().find(found).unwrap()
    };
    assert!(at("l").p_holm.unwrap() < 0.05 && at("r").p_holm.unwrap() > 0.05, "{comparisons:?}");
    assert!((at("l").estimate - 2.0).abs() < 0.8 && at("l").interval.unwrap().low > 0.0);
    assert!(comparisons.iter().all(|c| c.p_holm.unwrap() >= c.p.unwrap()) && comparisons.len() == 6);
    // The main effect is their mean.
    let average = comparisons.iter().find(|c| c.factor == "level" && c.average).unwrap();
    assert!((average.estimate - (at("l").estimate + at("r").estimate) / 2.0).abs() < 1e-9, "{comparisons:?}");
    // The effect at the baseline is a coefficient, too, and has one interval.
    let coefficients = &results.model.as_ref().unwrap().model.coefficients;
    let [one, other] = [coefficients[0].interval.unwrap(), at("l").interval.unwrap()];
    assert!((one.low - other.low).abs() < 1e-9 && (one.high - other.high).abs() < 1e-9, "{one:?} {other:?}");
}
