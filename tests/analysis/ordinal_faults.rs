//! Tests of ordinal models on data that do not determine every parameter: the problem is named, and the rest is still
//! estimated.

use machband::analysis::{
    Link, Model, ModelError, ModelSpec, Note, Random,
    counts::{Counts, MeasuredBuilder},
    fit, fit_with_tests,
};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// One row: participant, width, depth, rating.
type Row = (String, &'static str, &'static str, u8);

const WIDTHS: [&str; 3] = ["0.1", "0.2", "0.4"];
const DEPTHS: [&str; 3] = ["1", "2", "inf"];

fn rows(subjects: usize, repetitions: usize, sd: f64, seed: u64) -> Vec<Row> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut rows = Vec::new();
    for subject in 0..subjects {
        // Uniform with this standard deviation; nothing here requires a normal distribution.
        let intercept = sd * 12.0_f64.sqrt() * (rng.random::<f64>() - 0.5);
        for (w, width) in WIDTHS.into_iter().enumerate() {
            for (d, depth) in DEPTHS.into_iter().enumerate() {
                for _ in 0..repetitions {
                    let p: f64 = rng.random();
                    let latent = intercept + 0.4 * w as f64 - 0.8 * d as f64 + (p / (1.0 - p)).ln();
                    let rating = [-2.0, -0.5, 1.0].iter().filter(|threshold| latent > **threshold).count() as u8;
                    rows.push((format!("S{subject}"), width, depth, rating));
                }
            }
        }
    }
    rows
}

fn counts(rows: &[Row]) -> Counts {
    let mut builder = MeasuredBuilder::new(&["width", "depth"]).with_categories(&["0", "1", "2", "3"]);
    for (subject, width, depth, rating) in rows {
        builder.add_counts(subject, &[width, depth], &rating.to_string(), 1).unwrap();
    }
    builder.finish().counts
}

fn spec(terms: &str, random: Random) -> ModelSpec {
    ModelSpec { random, ..ModelSpec::new(terms.parse().unwrap()) }
}

fn close(found: f64, expected: f64) {
    assert!((found - expected).abs() < 1e-5 * (1.0 + expected.abs()), "{found}, expected {expected}");
}

/// Checks that the finite estimates of a model and their standard errors equal the ones in another model.
fn same_finite_part(model: &Model, other: &Model) {
    for (threshold, expected) in model.thresholds.iter().zip(&other.thresholds) {
        close(threshold.estimate, expected.estimate);
        close(threshold.se.unwrap(), expected.se.unwrap());
    }
    for coefficient in model.coefficients.iter().filter(|coefficient| coefficient.estimate.is_finite()) {
        let expected = other.coefficients.iter().find(|other| other.name == coefficient.name).unwrap();
        close(coefficient.estimate, expected.estimate);
        close(coefficient.se.unwrap(), expected.se.unwrap());
    }
    close(model.loglik, other.loglik);
    if let (Some(random), Some(expected)) = (&model.random, &other.random) {
        close(random.sd, expected.sd);
        close(random.se.unwrap(), expected.se.unwrap());
    }
}

/// If all ratings at a level are in the same extreme category, the level predicts them perfectly, and all other results
/// are as if these ratings did not exist.
#[test]
fn separation_is_named_and_does_not_affect_the_other_estimates() {
    let links = [Link::Logit, Link::Probit].into_iter();
    for (link, random) in links.flat_map(|link| [(link, Random::None), (link, Random::Subject)]) {
        for (level, extreme, positive) in [("0.4", 3, true), ("0.2", 0, false)] {
            let mut rows = rows(8, 6, 1.0, 1);
            rows.iter_mut().filter(|row| row.1 == level).for_each(|row| row.3 = extreme);
            let spec = ModelSpec { link, ..spec("width,depth", random) };
            let model = fit(&counts(&rows), &spec).unwrap();
            let expected = Note::Separation { coefficient: format!("width{level}"), term: "width".into(), positive };
            assert_eq!(model.notes, [expected]);
            let separated = model.coefficients.iter().find(|c| c.name == format!("width{level}")).unwrap();
            assert_eq!(separated.estimate, if positive { f64::INFINITY } else { f64::NEG_INFINITY });
            assert_eq!((separated.se, separated.z, separated.p), (None, None, None));
            rows.retain(|row| row.1 != level);
            same_finite_part(&model, &fit(&counts(&rows), &spec).unwrap());
        }
    }
}

#[test]
fn a_separated_baseline_is_replaced_by_another_level() {
    for random in [Random::None, Random::Subject] {
        let mut rows = rows(8, 6, 1.0, 2);
        rows.iter_mut().filter(|row| row.1 == "0.1").for_each(|row| row.3 = 3);
        let spec = spec("width,depth", random);
        let report = fit_with_tests(&counts(&rows), &spec, None).unwrap();
        let rebased = Note::Rebased {
            factor: "width".into(),
            baseline: "0.2".into(),
            separated: "0.1".into(),
            category: "3".into(),
        };
        let separated = Note::Separation { coefficient: "width0.1".into(), term: "width".into(), positive: true };
        assert_eq!(report.model.notes, [rebased, separated]);
        assert!(report.terms.iter().all(|test| test.p.is_some_and(|p| p < 1e-6)), "{:?}", report.terms);
        // Numbers, so that later levels are larger.
        let number = |level: &str| level.parse::<f64>().unwrap();
        assert!(report.comparisons.iter().all(|c| number(&c.level) > number(&c.other)), "{:?}", report.comparisons);
        rows.retain(|row| row.1 != "0.1");
        same_finite_part(&report.model, &fit(&counts(&rows), &spec).unwrap());
    }
}

#[test]
fn empty_categories_are_dropped_and_named() {
    let mut rows = rows(6, 4, 0.5, 3);
    rows.iter_mut().filter(|row| row.3 == 1).for_each(|row| row.3 = 2);
    let model = fit(&counts(&rows), &spec("width", Random::Subject)).unwrap();
    assert_eq!(model.notes, [Note::EmptyCategory { category: "1".into() }]);
    assert_eq!(model.thresholds.iter().map(|t| t.name.as_str()).collect::<Vec<_>>(), ["0|2", "2|3"]);
    rows.iter_mut().filter(|row| row.3 == 2).for_each(|row| row.3 = 0);
    let notes = fit(&counts(&rows), &spec("width", Random::Subject)).unwrap().notes;
    assert!(notes.contains(&Note::EmptyCategory { category: "1 or 2".into() }), "{notes:?}");
}

#[test]
fn redundant_terms_are_named_and_dropped() {
    let counts = counts(&rows(8, 6, 1.5, 5));
    let model = fit(&counts, &spec("width,num:width,depth", Random::Subject)).unwrap();
    assert!(matches!(&model.notes[..], [Note::AliasedTerm { term, .. }] if term == "num:width"), "{:?}", model.notes);
    let other = fit(&counts, &spec("num:width,width", Random::None)).unwrap();
    assert_eq!(other.notes, [Note::Aliased { column: "width0.4".into() }]);
    let names: Vec<&str> = other.coefficients.iter().map(|c| c.name.as_str()).collect();
    assert_eq!(names, ["width", "width0.2"]);
    let tests = fit_with_tests(&counts, &spec("width,num:width,depth", Random::None), None).unwrap().terms;
    assert_eq!((tests[1].df, tests[1].p), (0, None));
}

#[test]
fn ratings_that_never_vary_are_an_error() {
    let error = |rows: &[Row], terms: &str| fit(&counts(rows), &spec(terms, Random::Subject)).unwrap_err();
    let mut rows = rows(3, 2, 0.0, 8);
    assert!(error(&rows, "widht").to_string().ends_with("expected one of width, depth; did you mean width?"));
    assert!(matches!(error(&rows, "num:depth"), ModelError::InfiniteDepth { .. }));
    rows.iter_mut().for_each(|row| row.3 = 2);
    assert_eq!(error(&rows, "width"), ModelError::NoVariation { category: "2".into() });
    assert_eq!(error(&[], "width"), ModelError::NoRatings);
}

/// Any small table of ratings gives a model or an error, and every number in a model is finite or explained by a note.
#[test]
fn no_small_table_breaks_a_model() {
    let mut rng = ChaCha8Rng::seed_from_u64(10);
    let (mut models, mut separated, mut boundary) = (0, 0, 0);
    for _ in 0..400 {
        let mut builder = MeasuredBuilder::new(&["width", "depth"]).with_categories(&["0", "1", "2", "3"]);
        let (subjects, categories) = (rng.random_range(1..5), rng.random_range(1..5_u32));
        for _ in 0..rng.random_range(1..25) {
            let values = [WIDTHS[rng.random_range(0..3)], DEPTHS[rng.random_range(0..3)]];
            let rating = rng.random_range(0..categories).to_string();
            let subject = rng.random_range(0..subjects).to_string();
            builder.add_counts(&subject, &values, &rating, rng.random_range(1..4)).unwrap();
        }
        let counts = builder.finish().counts;
        let link = if rng.random() { Link::Logit } else { Link::Probit };
        let terms = ["width", "width,depth", "num:width,num:inv_n", "width*depth", ""][rng.random_range(0..5)];
        let random = if rng.random() { Random::Subject } else { Random::None };
        let spec = ModelSpec { link, ..spec(terms, random) };
        let Ok(report) = fit_with_tests(&counts, &spec, None) else { continue };
        let model = &report.model;
        models += 1;
        let what = format!("{spec:?} {model:?} {counts:?}");
        let noted = !model.notes.is_empty();
        separated += usize::from(model.notes.iter().any(|note| matches!(note, Note::Separation { .. })));
        boundary += usize::from(model.random.as_ref().is_some_and(|random| random.sd == 0.0));
        assert!(model.loglik.is_finite() && model.converged(), "{what}");
        for coefficient in &model.coefficients {
            assert!(!coefficient.estimate.is_nan(), "{what}");
            assert!(coefficient.estimate.abs() < 1e3 && coefficient.se.is_some() || noted, "{what}");
            assert!(coefficient.se.is_none_or(|se| se.is_finite() && se > 0.0), "{what}");
        }
        assert!(report.terms.iter().all(|test| test.p.is_none_or(|p| (0.0..=1.0).contains(&p))), "{what}");
    }
    assert!(models > 250 && separated > 30 && boundary > 20, "{models} {separated} {boundary}");
}
