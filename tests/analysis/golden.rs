//! Compares ordinal models with R's `ordinal` and `statsmodels`, and agreement with `krippendorff` and scikit-learn. The
//! values are in `tests/golden/ordinal`; the scripts that made them, with versions, are `scripts/golden_ordinal.*`.

use std::fs;

use machband::analysis::{
    Link, Model, ModelSpec, Note, Random, Slopes,
    agreement::{kappa, mean_kappa, ordinal_alpha},
    counts::{Counts, MeasuredBuilder},
    fit, fit_with_tests,
    terms::Terms,
};
use machband::statistics::{Interval, holm};

use crate::common::{self, Record, golden_path, number, table};

fn records(name: &str) -> Vec<Record> {
    common::records(&golden_path("ordinal").join(name))
}

/// Reads the ratings of a data set: participant, factors, rating and count.
fn counts(name: &str) -> Counts {
    // A name that ends with `.binary` stands for the same data, analyzed by `lme4`.
    let name = name.trim_end_matches(".binary");
    let file = if name.starts_with("slopes") { "data_slopes.csv" } else { "data.csv" };
    let text = fs::read_to_string(golden_path("ordinal").join(file)).unwrap();
    let section = text.split("## ").find_map(|section| section.strip_prefix(&format!("{name}: "))).unwrap();
    let mut rows = section.lines().skip(1).map(|row| row.split(',').collect::<Vec<_>>());
    let header = rows.next().unwrap();
    let last = header.len() - 2;
    let mut builder = MeasuredBuilder::new(&header[1..last]);
    for row in rows {
        builder.add_counts(row[0], &row[1..last], row[last], row[last + 1].parse().unwrap()).unwrap();
    }
    builder.finish().counts
}

fn spec(record: &Record) -> ModelSpec {
    let independent = record.get("nodes").is_none_or(|nodes| nodes == "0");
    ModelSpec {
        link: record["link"].parse::<Link>().unwrap(),
        random: if independent && !record.contains_key("slopes") { Random::None } else { Random::Subject },
        items: record.get("items").filter(|items| !items.is_empty()).cloned(),
        slopes: record.get("slopes").map_or(Slopes::None, |slopes| slopes.parse().unwrap()),
        ..ModelSpec::new(record["terms"].parse().unwrap())
    }
}

fn value(model: &Model, quantity: &str, name: &str) -> f64 {
    let threshold = || model.thresholds.iter().find(|t| t.name == name).unwrap();
    let coefficient = || model.coefficients.iter().find(|own| own.name == name).expect(name);
    // The standard deviation of an effect, and its error.
    let effect = || {
        let random = model.random.as_ref().unwrap();
        if ["", "(Intercept)"].contains(&name) {
            return (random.sd, random.se);
        }
        let mut effects = random.slopes.iter().chain(&random.items);
        let own = effects.find(|own| own.name.replace("num:", "") == name).unwrap();
        (own.sd, own.se)
    };
    match quantity {
        "loglik" => model.loglik,
        "threshold" => threshold().estimate,
        "threshold_se" => threshold().se.unwrap(),
        "coefficient" => coefficient().estimate,
        "coefficient_se" => coefficient().se.unwrap(),
        // A slope that the design does not support is left out; in these data sets, its standard deviation is 0.
        "sd" if model.notes.iter().any(|note| matches!(note, Note::NoSlope { term, .. } if term == name)) => 0.0,
        "sd" => effect().0,
        "sd_se" => effect().1.unwrap_or_else(|| panic!("{name}: {:?}", model.random)),
        "correlation" => {
            let random = model.random.as_ref().unwrap();
            let place = |name: &str| random.slopes.iter().position(|slope| slope.name.replace("num:", "") == name);
            let [i, j] = [0, 1].map(|part| place(name.split(',').nth(part).unwrap()).map_or(0, |place| place + 1));
            random.correlations.as_ref().unwrap()[i][j]
        }
        other => panic!("{other}"),
    }
}

/// Groups the records by fit.
fn fits(records: &[Record]) -> impl Iterator<Item = &[Record]> {
    let key = |record: &Record| {
        ["data", "link", "terms", "nodes", "slopes", "items"].map(|name| record.get(name).cloned().unwrap_or_default())
    };
    records.chunk_by(move |l, r| key(l) == key(r))
}

/// Compares every value of three files: `slopes.csv` has random slopes for factors, numbers and both, independent and correlated,
/// and items crossed with participants; `binary` is from `lme4`.
#[test]
fn estimates_errors_and_likelihoods_match_other_programs() {
    for (file, fewest) in [("models.csv", 370), ("slopes.csv", 320), ("statsmodels.csv", 60)] {
        let records = records(file);
        let mut compared = 0;
        for records in fits(&records) {
            let first = &records[0];
            let model = fit(&counts(&first["data"]), &spec(first)).unwrap();
            let label = format!("{} {:?}", first["data"], spec(first));
            let mut coefficients = 0;
            for record in records.iter().filter(|record| record["quantity"] != "gradient") {
                let expected: f64 = number(record, "value");
                let quantity = record["quantity"].as_str();
                let difference = (value(&model, quantity, &record["name"]) - expected).abs();
                let most = match quantity {
                    "loglik" => 1e-5,
                    // The likelihood is flat in a small standard deviation.
                    "sd_se" => 1e-3 * (1.0 + expected.abs()),
                    _ => 1e-4,
                };
                assert!(difference < most, "{label}: {quantity} {} differs by {difference:e}", record["name"]);
                coefficients += usize::from(quantity == "coefficient");
                compared += 1;
            }
            assert!(model.gradient < 1e-6, "{label}");
            assert_eq!(coefficients, model.coefficients.len(), "{label}: {:?}", model.coefficients);
        }
        assert!(compared >= fewest, "only {compared} values of {file}");
    }
}

/// `log(pnorm(-10) - pnorm(-11))` of R 4.2.2, and log(F(800) − F(799)) = −799 + log(1 − 1/e) of the logistic F.
#[test]
fn the_far_tails_of_a_link_keep_their_digits() {
    for (link, upper, lower, expected) in [
        (Link::Probit, 11.0, 10.0, 7.619_661_958_203_077e-24_f64.ln()),
        (Link::Logit, 800.0, 799.0, -799.0 + (1.0 - (-1.0_f64).exp()).ln()),
    ] {
        for (a, b) in [(upper, lower), (-lower, -upper)] {
            let found = link.cell(a, b).log_p;
            assert!((found - expected).abs() < 1e-9, "{link} {a} {b}: {found}, expected {expected}");
        }
        for p in [1e-12, 0.2, 0.975] {
            assert!((link.cdf(link.quantile(p)) / p - 1.0).abs() < 1e-9, "{link} {p}");
        }
    }
}

#[test]
fn likelihood_ratio_tests_match_r() {
    let records = records("tests.csv");
    for records in fits(&records) {
        let (counts, spec) = (counts(&records[0]["data"]), spec(&records[0]));
        let report = fit_with_tests(&counts, &spec, None).unwrap();
        for record in records {
            let what = format!("{record:?}");
            let test = report.terms.iter().find(|test| test.term.to_string() == record["term"]);
            let test = test.unwrap_or_else(|| panic!("{what}: {:?}", report.terms));
            assert_eq!(test.df.to_string(), record["df"], "{what}");
            if test.df == 0 {
                assert_eq!((test.chi_squared, test.p), (None, None), "{what}");
                continue;
            }
            let number = |name: &str| number::<f64>(record, name);
            let (lr, p) = (test.chi_squared.unwrap() - number("lr"), test.p.unwrap() - number("p"));
            assert!(lr.abs() < 1e-4 * (1.0 + number("lr")) && p.abs() < 1e-4, "{what}: {test:?}");
        }
    }
}

/// A model without terms reproduces the proportions of the ratings and the standard error of their mean. A model with a
/// term follows the levels.
#[test]
fn predictions_reproduce_the_observed_proportions() {
    let mut builder = MeasuredBuilder::new(&["width"]);
    for (width, tally) in [("0.1", [5, 3, 2, 1]), ("0.4", [2, 4, 6, 3]), ("0.8", [1, 1, 5, 9])] {
        for (rating, count) in tally.into_iter().enumerate() {
            builder.add_counts("S1", &[width], &rating.to_string(), count).unwrap();
        }
    }
    let counts = builder.finish().counts;
    for link in [Link::Logit, Link::Probit] {
        let spec = ModelSpec { link, ..ModelSpec::new(Terms::default()) };
        let prediction = &fit_with_tests(&counts, &spec, None).unwrap().predictions[0];
        let expected = [8.0, 8.0, 13.0, 13.0].map(|n| n / 42.0);
        let moment = |power: i32| (0..).zip(expected).map(|(k, p)| f64::from(k).powi(power) * p).sum::<f64>();
        assert!(prediction.probabilities.iter().zip(expected).all(|(found, p)| (found - p).abs() < 1e-9));
        assert!((prediction.mean - moment(1)).abs() < 1e-9);
        let interval = prediction.interval.unwrap();
        // The interval is symmetric on the logit of the mean's place on the scale.
        let logit = |mean: f64| (mean / (3.0 - mean)).ln();
        let half = (logit(interval.high) - logit(interval.low)) / 2.0;
        let error = half / 1.959_963_984_540_054 * moment(1) * (3.0 - moment(1)) / 3.0;
        assert!((error - ((moment(2) - moment(1).powi(2)) / 42.0).sqrt()).abs() < 1e-9, "{error}");
    }
}

fn close(found: f64, expected: &str, what: &[String]) {
    let expected: f64 = expected.parse().unwrap();
    assert!((found - expected).abs() < 1e-9 * (1.0 + expected.abs()), "{what:?}: {found}");
}

#[test]
fn agreement_matches_krippendorff_and_scikit_learn() {
    let (_, rows) = table(&golden_path("ordinal/ranks.csv"));
    let (mut alphas, mut intervals) = (0, 0);
    for row in rows.iter().filter(|row| row[0].starts_with("alpha")) {
        let counts = counts(&row[1]);
        let alpha = ordinal_alpha(&counts).unwrap();
        close(alpha.alpha, &row[3], row);
        let inside = |interval: Interval| interval.low < alpha.alpha && alpha.alpha < interval.high;
        assert!(alpha.interval.is_none_or(inside), "{row:?} {alpha:?}");
        intervals += usize::from(alpha.interval.is_some());
        alphas += 1;
    }
    assert!(alphas == 4 && intervals > 0, "{alphas} {intervals}");
    let pair = |i: u32| {
        let first = (i * 7 + i * i) % 5;
        [first as u8, (first + (i * 5) % 3).saturating_sub(1).min(4) as u8]
    };
    let pairs: Vec<[u8; 2]> = (0..60).map(pair).collect();
    for row in rows.iter().filter(|row| row[0] == "kappa" && row[2] == "quadratic") {
        close(kappa(&pairs).unwrap(), &row[3], row);
    }
    // κ of one pair is 0 whatever its ratings, and that of a few is far too low.
    assert_eq!([0, 1, 4].map(|pairs| kappa(&vec![[0, 1]; pairs])), [None; 3]);
    assert_eq!(kappa(&[[0, 0], [1, 1], [2, 2], [0, 0], [3, 3]]), Some(1.0));
    assert_eq!(mean_kappa(&[0.9, 1.0, 0.5]).unwrap().1.unwrap().high, 1.0);
}

/// `p.adjust(c(0.01, 0.04, 0.03, 0.005), "holm")`, R 4.2.2.
#[test]
fn holm_matches_r() {
    let corrected = holm(&[0.01, 0.04, 0.03, 0.005].map(Some)).into_iter().flatten().zip([0.03, 0.06, 0.06, 0.02]);
    assert!(corrected.map(|(found, expected)| (found - expected).abs()).fold(0.0, f64::max) < 1e-15);
}
