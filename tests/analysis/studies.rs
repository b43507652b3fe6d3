//! Studies as people bring them: crossed effects, people who lack levels, numbers in any unit, and covariates. Every sentence
//! agrees with every other one.

use machband::{
    analysis::{
        Comparison, Options, Resampling, Results, Withheld, analyze,
        counts::{Measured, MeasuredBuilder},
    },
    experiment::RatingRow,
    report::study::{Summary, summary},
};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use crate::{
    inference::rate,
    report::{page, source},
};

/// Simulates a study: every person rates every row of `design` `ratings` times. `latent` returns the latent value for a
/// person and a row, or `None` if this person does not rate it.
pub fn study<'a>(
    factors: &[&str],
    design: &[impl AsRef<[&'a str]>],
    (people, ratings, seed): (usize, usize, u64),
    latent: impl Fn(usize, usize) -> Option<f64>,
) -> Measured {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut builder = MeasuredBuilder::new(factors).with_categories(&["0", "1", "2", "3"]);
    for person in 0..people {
        let own: f64 = rng.random_range(-1.0..1.0);
        for (index, row) in design.iter().enumerate() {
            for _ in 0..ratings {
                if let Some(latent) = latent(person, index) {
                    let rating = rate(latent + own, &mut rng);
                    builder.add_counts(&format!("S{person:02}"), row.as_ref(), &rating, 1).unwrap();
                }
            }
        }
    }
    builder.finish()
}

pub fn options(terms: Option<&str>) -> Options {
    let terms = terms.map(|terms| terms.parse().unwrap());
    Options { terms, resampling: Resampling { draws: 99, seed: 1 }, ..Options::default() }
}

/// The options of tests of sentences, whose p need not be exact.
fn fewer_draws(terms: Option<&str>) -> Options {
    Options { resampling: Resampling { draws: 39, seed: 1 }, ..options(terms) }
}

fn said(results: &Results) -> Summary {
    summary(&source(&[]), results)
}

/// Three of twelve people rate both levels, and two of them rate b far higher; nine rate one level. Without a slope, p is
/// below .001, and below .05 in 4 of 10 studies of people who differ in an effect that is 0 on average.
#[test]
fn people_who_cross_are_few_people() {
    let mut builder = MeasuredBuilder::new(&["c"]).with_categories(&["0", "1", "2", "3"]);
    for person in 0..12 {
        for (place, level) in ["a", "b"].into_iter().enumerate().filter(|(own, _)| person < 3 || person % 2 == *own) {
            let middle = [[0, 2], [0, 2], [1, 0]].get(person).map_or(person % 3, |own| own[place]);
            for (rating, count) in [(middle, 8), (middle + 1, 12)] {
                builder.add_counts(&format!("P{person}"), &[level], &rating.to_string(), count).unwrap();
            }
        }
    }
    let model = analyze(builder.finish(), &options(None)).model.unwrap();
    assert!(model.model.random.as_ref().is_some_and(|random| random.slopes.len() == 1), "{:?}", model.model.random);
    assert!(model.terms[0].p.is_some_and(|p| p > 0.05), "{:?}", model.terms);
}

/// One rating that was filed under the other group neither withholds the test of the groups nor makes a group of two large
/// enough for one.
#[test]
fn a_slip_changes_no_group() {
    for (people, in_b, is_tested) in [(24, 12, true), (12, 2, false)] {
        let mut builder = MeasuredBuilder::new(&["group"]).with_categories(&["0", "1", "2", "3"]);
        for (person, place) in (0..2 * people).map(|i| (i / 2, i % 2)) {
            let group = person < in_b;
            let level = if (group, (person, place) == (0, 1)) == (true, false) { "b" } else { "a" };
            let rating = ((person * 5 + place) % 3 + usize::from(group)).to_string();
            builder.add_counts(&format!("P{person}"), &[level], &rating, 1).unwrap();
        }
        let test = analyze(builder.finish(), &options(None)).model.unwrap().terms.remove(0);
        assert!(test.withheld.is_none() == is_tested && test.p.is_some_and(|p| p < 0.1) == is_tested, "{test:?}");
    }
}

const CROSSED: [[&str; 2]; 4] = [["p", "x"], ["p", "z"], ["q", "x"], ["q", "z"]];

/// An effect that is turned round by another factor is no missing effect. Today's sentence was "found no clear effect of a
/// and b".
#[test]
fn a_crossed_interaction_leads() {
    for people in [1, 3, 10] {
        let crossed = |_: usize, row: usize| Some([1.5, -1.5, -1.5, 1.5][row]);
        for terms in [None, Some("a*b")] {
            let results = analyze(study(&["a", "b"], &CROSSED, (people, 12, 5), crossed), &options(terms));
            let Summary { findings, cautions, .. } = said(&results);
            let (found, first) = (format!("{people} people, {terms:?}: {findings:?} {cautions:?}"), &findings[0]);
            assert!(first.contains("effects of a and b depend on each other"), "{found}");
            assert!(first.contains("At b x, the mean rating is") && first.contains("; at b z, it is"), "{found}");
            assert!(!findings.iter().chain(&cautions).any(|text| text.contains("no clear effect of a")), "{found}");
            assert!(!findings.iter().any(|text| text.contains("if a made no difference")), "{found}");
            // The numbers of the summary are those of the table.
            let comparisons = &results.model.as_ref().unwrap().comparisons;
            let simple = comparisons.iter().find(|c| c.factor == "a" && c.at.is_some());
            assert_eq!(simple.is_some(), terms.is_some(), "{found}");
            if let Some(p) = simple.and_then(|c| c.p_holm) {
                let told = machband::report::document::numbers::p_is(p).replace(' ', "\u{a0}");
                assert!(first.replace(' ', "\u{a0}").contains(&told), "{told}: {found}");
            }
            let additive = cautions.iter().any(|text| text.contains("The model is additive"));
            assert_eq!(additive, terms.is_none(), "{found}");
            let checks = results.model.as_ref().unwrap().checks.as_ref().unwrap();
            let far = checks.proportions.iter().filter(|p| p.is_outside()).count();
            assert!(people < 10 || (far > 4) == terms.is_none(), "{far} cells; {found}");
        }
    }
}

/// Nobody rated q at 3, so that there is no mean effect over all levels, and one of those that were rated would depend on their
/// order. The interaction and the simple effects do not.
#[test]
fn an_empty_cell_makes_no_test_depend_on_the_order_of_levels() {
    let of = |levels: [&str; 3]| {
        let mut rng = ChaCha8Rng::seed_from_u64(7);
        let order = [("a".to_owned(), levels.map(str::to_owned).to_vec())];
        let mut builder = MeasuredBuilder::new(&["a", "b"]).with_categories(&["0", "1", "2", "3"]);
        builder.levels = order.to_vec();
        for (person, (a, b, latent)) in (0..12).flat_map(|person| {
            let cells = [("1", "p", 0.0), ("1", "q", 1.6), ("2", "p", 0.8), ("2", "q", 0.0), ("3", "p", 0.4)];
            cells.map(|cell| (person, cell))
        }) {
            for _ in 0..8 {
                let rating = rate(latent + 0.2 * f64::from(person) - 1.5, &mut rng);
                builder.add_counts(&format!("S{person:02}"), &[a, b], &rating, 1).unwrap();
            }
        }
        analyze(builder.finish(), &options(Some("a*b")))
    };
    let simple = |results: &Results| {
        let comparisons = results.model.as_ref().unwrap().comparisons.iter();
        let mut all: Vec<_> = comparisons
            .map(|c| {
                let mut pair = [c.level.clone(), c.other.clone()];
                pair.sort();
                (c.factor.clone(), pair, c.at.clone(), (c.estimate.abs() * 1e3).round(), c.p.is_some())
            })
            .collect();
        all.sort_by(|one, other| format!("{one:?}").cmp(&format!("{other:?}")));
        all
    };
    let (first, second) = (of(["1", "2", "3"]), of(["3", "1", "2"]));
    for results in [&first, &second] {
        let report = results.model.as_ref().unwrap();
        let withheld: Vec<_> = report.terms.iter().map(|test| (test.p.is_some(), test.withheld)).collect();
        let none = (false, Some(Withheld::EmptyCells));
        assert_eq!(withheld, [none, none, (true, None)], "{:?}", report.terms);
        assert!(report.comparisons.iter().all(|c| c.at.is_some()), "{:?}", report.comparisons);
        let html = page(&source(&["a", "b"]), results);
        assert!(html.contains("for a factor in an interaction, over those in which all of its levels were rated"));
        assert!(html.contains("No p for a and b: it is an average over the factors with which it interacts"));
    }
    assert_eq!(simple(&first), simple(&second));
    let lr = |results: &Results| results.model.as_ref().unwrap().terms[2].chi_squared.unwrap();
    assert!((lr(&first) - lr(&second)).abs() < 1e-4);
}

/// Means and contrasts of R's emmeans 1.8.4 (`emmeans(m, ~dose, mode = "mean.class")`, and `pairs(emmeans(m, ~group))`) of
/// clmm(y ~ dose * group + age + (1 | s) + (1 | s:dose)) and of its additive form, with ordinal 2022.11-16. Each age is that of
/// one person, and most people lack a dose.
#[test]
fn a_covariate_has_its_mean_in_marginal_means() {
    let mut builder = MeasuredBuilder::new(&["group", "age", "dose"]).with_categories(&["0", "1", "2", "3"]);
    for (person, dose, repetition) in (0_usize..12 * 18).map(|i| (i / 18, i / 6 % 3, i % 6)) {
        let is_patient = person % 3 == 0;
        if is_patient || dose + 1 != person % 4 {
            let effect = if is_patient { 2 + 2 * dose } else { 6 - 3 * dose };
            let noise = (person * 7 + dose * 5 + repetition * 11 + repetition * repetition * person * 3) % 9;
            let rating = ((person * 5 % 7 + effect + noise).saturating_sub(4) / 5).min(3);
            let values = [if is_patient { "pat" } else { "ctrl" }, &(20 + 3 * person).to_string(), &dose.to_string()];
            builder.add_counts(&format!("S{person:02}"), &values, &rating.to_string(), 1).unwrap();
        }
    }
    let measured = builder.finish();
    for (terms, doses, groups, difference) in [
        ("dose*group,age", [0.902_068, 0.869_772, 0.760_095], [0.964_628, 0.723_329], -0.800_989),
        ("dose,group,age", [0.942_149, 0.907_977, 0.711_741], [0.973_935, 0.733_977], -0.772_988),
    ] {
        let results = analyze(measured.clone(), &options(Some(terms)));
        let report = results.model.as_ref().unwrap();
        let of = |margin: &machband::analysis::Margin| (margin.factor.clone(), margin.level.clone(), margin.mean);
        let found: Vec<_> = report.margins.iter().map(of).collect();
        let expected = doses.iter().zip(["0", "1", "2"]).map(|(mean, level)| ("dose", level, *mean));
        let expected = groups.iter().zip(["ctrl", "pat"]).map(|(mean, level)| ("group", level, *mean)).chain(expected);
        assert_eq!(found.len(), 5, "{found:?}");
        for (expected, found) in expected.zip(&found) {
            assert_eq!((expected.0, expected.1), (&*found.0, &*found.1));
            assert!((expected.2 - found.2).abs() < 2e-3, "{terms}: {found:?}, expected {expected:?}");
        }
        let own = report.comparisons.iter().find(|c| c.factor == "group" && c.at.is_none()).unwrap();
        assert!((own.estimate - difference).abs() < 5e-3 && own.average == (terms.contains('*')), "{own:?}");
        // The interval is that of the test.
        let (p, interval) =
            (report.terms.iter().find(|test| test.term.to_string() == "group").unwrap().p, own.interval.unwrap());
        assert!(own.p == p && p.unwrap() > 0.05 && interval.contains(0.0), "{own:?} {p:?}");
    }
}

/// With all ratings of a cell in the lowest category, an interaction has no finite estimate in some codings, and simulated
/// studies would say that it is clear. R's glm gives p = .26.
#[test]
fn a_cell_at_the_floor_is_no_interaction() {
    for levels in [["A", "B"], ["B", "A"]] {
        let order = ("a".to_owned(), levels.map(str::to_owned).to_vec());
        let mut builder = MeasuredBuilder::new(&["a", "c"]).with_categories(&["0", "1"]);
        builder.levels = vec![order.clone()];
        for person in 1..=6 {
            let ones = [0, usize::from(person % 2 == 0), usize::from(person < 3), 1];
            for (cell, ones) in [["A", "X"], ["A", "Y"], ["B", "X"], ["B", "Y"]].iter().zip(ones) {
                for rating in 0..3 {
                    builder.add_counts(&format!("S{person}"), cell, if rating < ones { "1" } else { "0" }, 1).unwrap();
                }
            }
        }
        let tests = analyze(builder.finish(), &options(Some("a*c"))).model.unwrap().terms;
        let p = tests.iter().find(|test| test.term.to_string() == "a:c").unwrap().p;
        assert!(p.is_none_or(|p| p > 0.1), "{order:?}: {tests:?}");
    }
}

/// Contact lowers ratings, but it exists only at the action that raises them, so that its raw means rise: the means beside p
/// are those of the model, or those in the same conditions if the model has no such effects.
#[test]
fn simple_effects_have_the_direction_of_their_test() {
    let rows = [["0", "f", "0"], ["1", "f", "0"], ["0", "f", "1"], ["0", "m", "0"], ["1", "m", "0"], ["0", "m", "1"]];
    let latent = |_: usize, row: usize| Some([2.5, 2.2, -2.5, 2.5, 0.6, -2.5][row]);
    let measured = study(&["contact", "group", "action"], &rows, (10, 10, 5), latent);
    for (terms, what) in [
        ("contact*group,action", "At group f, the rating that the model expects is "),
        ("contact,group,action", "At group f, the mean rating in the same conditions is "),
    ] {
        let results = analyze(measured.clone(), &options(Some(terms)));
        let findings = said(&results).findings;
        let finding = findings.iter().find(|text| text.contains("of contact and group depend")).unwrap();
        assert!(finding.contains(what) && finding.contains("by contact are not comparable"), "{finding}");
        let (_, at_m) = finding.split_once("; at group m, it is ").unwrap();
        let numbers: Vec<f64> = at_m.split(' ').filter_map(|word| word.parse().ok()).collect();
        let [none, 0.0, contact, 1.0, ..] = numbers[..] else { panic!("{finding}") };
        assert!(none > contact + 0.3, "{finding}");
    }
}

/// Half of the people rate levels 1 and 2, and half rate 2 and 3; the second half rates everything higher. Within people,
/// ratings fall with the level, and the raw means rise. A slope has no highest level.
#[test]
fn words_and_numbers_have_one_direction() {
    let latent = |person: usize, level: usize| {
        let second = person % 2;
        (second..second + 2).contains(&level).then(|| [-0.6, 3.2][second] - 1.2 * level as f64)
    };
    let results = analyze(study(&["l"], &[["1"], ["2"], ["3"]], (24, 12, 3), latent), &options(None));
    let finding = &said(&results).findings[0];
    assert!(finding.starts_with("The raw means by l mislead") && !finding.contains("rises"), "{finding}");
    assert!(finding.contains("falls with l at every step") && finding.contains("at 3 are an estimated"), "{finding}");
    let bent = |_: usize, row: usize| Some([0.0, 2.3, 1.9][row]);
    let results = analyze(study(&["x"], &[["1"], ["2"], ["3"]], (8, 8, 5), bent), &options(Some("num:x")));
    let finding = &said(&results).findings[0];
    assert!(finding.contains("From x 1 to 3, the odds") && !finding.contains(" at 2"), "{finding}");
}

/// Nothing depends on the unit of a number or on its origin: the same z and p, and intervals that scale.
#[test]
fn units_and_origins_do_not_matter() {
    let levels = ["1", "1.5", "2", "2.5", "3", "4", "5.5", "7"];
    let scaled = |power: i32, origin: f64| -> Vec<String> {
        levels
            .iter()
            .map(|level| format!("{:e}", origin + level.parse::<f64>().unwrap() * 10_f64.powi(power)))
            .collect()
    };
    for (people, is_complete) in [(1, true), (5, true), (5, false)] {
        let of = |power: i32, origin: f64| {
            let mut levels = scaled(power, origin);
            // Ratings without the number are not in the model.
            levels.extend((!is_complete).then(String::new));
            let rows: Vec<[&str; 1]> = levels.iter().map(|level| [level.as_str()]).collect();
            let latent = |_: usize, level: usize| Some(0.4 * level as f64 - 1.5);
            let results = analyze(study(&["x"], &rows, (people, 8, 4), latent), &options(Some("num:x")));
            let finding = said(&results).findings[0].clone();
            let report = results.model.unwrap();
            let (coefficient, unit) = (&report.model.coefficients[0], 10_f64.powi(power));
            let interval = coefficient.interval.unwrap();
            let numbers = [coefficient.estimate, coefficient.se.unwrap(), interval.low, interval.high];
            let multiplied = finding.split("multiplied by ").nth(1).unwrap().to_owned();
            (numbers.map(|number| number * unit), report.terms[0].p, report.terms[0].chi_squared.unwrap(), multiplied)
        };
        let (numbers, p, lr, text) = of(0, 0.0);
        assert!(numbers.iter().all(|number| number.is_finite()) && p.unwrap() < 0.05, "{numbers:?} {p:?}");
        for (power, origin) in
            [(-12, 0.0), (-6, 0.0), (-3, 0.0), (3, 0.0), (9, 0.0), (0, 273.15), (0, 2019.0), (0, 1e6), (-2, 1e6)]
        {
            let (other, other_p, other_lr, other_text) = of(power, origin);
            for (number, other) in numbers.iter().zip(other) {
                assert!(
                    (number - other).abs() < 1e-3 * number.abs(),
                    "{people}, 1e{power} from {origin}: {numbers:?} {other:?}"
                );
            }
            assert!(
                (lr - other_lr).abs() < 1e-6 && (p.unwrap() - other_p.unwrap()).abs() < 1e-6,
                "{people}, 1e{power} from {origin}: {p:?} {other_p:?}"
            );
            assert_eq!(text, other_text, "{people}, 1e{power} from {origin}");
        }
    }
}

/// An age has a slope, not a mean for each year, whether a term names it or not; without covariates, its values are levels.
#[test]
fn an_age_is_no_condition() {
    let ages: Vec<String> = (0..20).map(|person| format!("{}.304818901934", 20 + 3 * person)).collect();
    let rows: Vec<[&str; 2]> = ages.iter().flat_map(|age| [[age.as_str(), "a"], [age.as_str(), "b"]]).collect();
    let latent =
        |person: usize, row: usize| (row / 2 == person).then_some(0.15 * person as f64 + (row % 2) as f64 - 2.0);
    let measured = study(&["age", "cond"], &rows, (20, 8, 6), latent);
    let results = analyze(measured.clone(), &options(None));
    assert_eq!((results.cells.len(), results.factors.len(), &results.covariates[..]), (2, 1, &["age".to_owned()][..]));
    let Summary { lead, findings, .. } = said(&results);
    assert!(
        lead[0].contains("of 2 conditions") && lead.concat().contains("The model has the covariate age"),
        "{lead:?}"
    );
    let of_age = findings.iter().find(|text| text.starts_with("Ratings depend on age")).expect("a finding");
    assert!(of_age.contains("From age 20.3 to 77.3, the odds"), "{of_age}");
    assert_eq!(analyze(measured.clone(), &options(Some("age,cond"))).spec.terms.to_string(), "num:age,cond");
    let none = Options { covariates: Some(Vec::new()), ..options(Some("age,cond")) };
    let by_level = analyze(measured.clone(), &none);
    assert!(by_level.covariates.is_empty() && by_level.cells.len() == 40);
    // A covariate that was asked for is in the model, whatever the other terms are; one that no term uses is not said to be.
    let asked = Options { covariates: Some(vec!["age".to_owned()]), ..options(Some("cond")) };
    assert_eq!(analyze(measured.clone(), &asked).spec.terms.to_string(), "cond,num:age");
    assert!(!said(&analyze(measured, &options(Some("cond")))).lead.concat().contains("covariate"));
}

/// Ages of 20 to 29 in one group and 50 to 59 in the other leave the group's effect to a straight line between them.
#[test]
fn groups_whose_ages_do_not_overlap_are_named() {
    for (first, is_named) in [(50, true), (25, false)] {
        let age = |person: usize| if person < 10 { 20 + person } else { first + person - 10 };
        let ages: Vec<String> = (0..20).map(|person| age(person).to_string()).collect();
        let rows: Vec<[&str; 3]> = (0..40).map(|i| [&*ages[i / 2], ["y", "o"][i / 20], ["a", "b"][i % 2]]).collect();
        let latent = |person: usize, row: usize| (row / 2 == person).then_some((row % 2) as f64);
        let results = analyze(study(&["age", "group", "cond"], &rows, (20, 8, 6), latent), &fewer_draws(None));
        let cautions = said(&results).cautions.concat();
        let named = "Every value of age at o is above those at y: the effects of group and age";
        assert_eq!(cautions.contains(named), is_named, "{cautions}");
        assert_eq!(cautions.matches("extrapolation").count(), usize::from(is_named));
    }
}

/// The order of the factors and of the terms decides nothing, where people rated once or often: not which slopes there are,
/// and no p.
#[test]
fn the_order_of_terms_does_not_matter() {
    let of = |names: [&str; 2], terms: &str, ratings: usize| {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let mut builder = MeasuredBuilder::new(&names).with_categories(&["0", "1", "2", "3"]);
        for (person, a, b) in (0..36).map(|i| (i / 6, ["p", "q"][i / 3 % 2], ["x", "y", "z"][i % 3])) {
            let values = if names[0] == "a" { [a, b] } else { [b, a] };
            for _ in 0..ratings {
                let rating = rate(0.3 * person as f64 + if a == "p" { 0.0 } else { 0.6 }, &mut rng);
                builder.add_counts(&person.to_string(), &values, &rating, 1).unwrap();
            }
        }
        let report = analyze(builder.finish(), &options(Some(terms))).model.unwrap();
        let slopes = report.model.random.into_iter().flat_map(|random| random.slopes);
        let mut slopes: Vec<String> = slopes.map(|slope| slope.term.to_string()).collect();
        let mut tests: Vec<_> = report.terms.into_iter().map(|test| (test.term.to_string(), test.p)).collect();
        slopes.sort();
        tests.sort_by(|one, other| one.0.cmp(&other.0));
        (slopes, tests, (report.model.loglik * 1e6).round())
    };
    for ratings in [1, 2] {
        let expected = of(["a", "b"], "a,b", ratings);
        assert_eq!(of(["a", "b"], "b,a", ratings), expected);
        assert_eq!(of(["b", "a"], "b,a", ratings), expected);
    }
}

/// In studies of all kinds, no two sentences contradict each other: a factor has an effect, has no clear one, or depends on
/// another one, and everything that is said of it says the same.
#[test]
fn sentences_agree() {
    (0..300_u64).into_par_iter().for_each(|seed| {
        let (people, ratings) = ([1, 3, 6, 9][seed as usize % 4], [1, 3, 8][seed as usize % 3]);
        let (a, b, both) =
            ([0.0, 1.0, -2.0][seed as usize % 3], [0.0, 1.5][seed as usize / 3 % 2], [0.0, 2.0][seed as usize / 6 % 2]);
        let missing = seed % 5 == 4;
        let latent = |person: usize, row: usize| {
            let (own_a, own_b) = ((row / 2) as f64, (row % 2) as f64);
            let is_rated = !missing || !(person + row).is_multiple_of(4);
            is_rated.then_some(a * own_a + b * own_b + both * own_a * own_b)
        };
        let terms = [None, Some("a*b"), Some("a")][seed as usize / 2 % 3];
        let results = analyze(
            study(&["a", "b"], &CROSSED, (people, ratings, seed), latent),
            &Options { unchecked: true, ..fewer_draws(terms) },
        );
        let Summary { findings, cautions, .. } = said(&results);
        let all = format!("seed {seed}: {findings:#?} {cautions:#?}");
        for factor in ["a", "b"] {
            let is_own = |text: &&String| {
                let starts = [
                    format!("By {factor},"),
                    format!(" with {factor} "),
                    format!(" with {factor},"),
                    format!("levels of {factor}"),
                    format!("raw means by {factor} "),
                ];
                starts.iter().any(|start| text.contains(start))
            };
            let own: String = findings.iter().filter(is_own).cloned().collect();
            let is = |parts: &[&str]| parts.iter().filter(|part| own.contains(&part.replace('#', factor))).count();
            let kinds = [
                is(&["if # made no difference", "Ratings depend on # ("]),
                is(&["cannot distinguish the levels (", "whether ratings depend on # ("]),
                is(&["effect of # could not be tested", "draws no conclusion"]),
                findings.iter().filter(|text| text.starts_with("The effects of a and b depend on each other")).count(),
            ];
            assert_eq!(kinds.iter().sum::<usize>(), 1, "{factor}: {kinds:?}; {all}");
            let unclear = kinds[1] == 1;
            let of = |text: &String| {
                text.split("no clear effect of ").nth(1).map(|rest| rest.split('.').next().unwrap().to_owned())
            };
            let none = cautions.iter().filter_map(of).any(|named| named.split(' ').any(|word| word == factor));
            assert!(!none || unclear, "{factor}; {all}");
        }
        for text in findings.iter().filter(|text| text.starts_with("By ")) {
            // The means at two levels, and the odds at the second one relative to the first.
            let means = text.split(" at ").filter_map(|part| part.rsplit(' ').next()?.parse::<f64>().ok());
            let odds = text.split("are an estimated ").nth(1).and_then(|rest| rest.split(' ').next());
            if let ([first, second, ..], Some(Ok(odds))) = (&means.collect::<Vec<_>>()[..], odds.map(str::parse::<f64>))
            {
                assert!((second - first) * odds.ln() >= 0.0, "{text}");
            }
        }
        for text in findings.iter().chain(&cautions) {
            assert!(!["NaN", "..", "  ", " ,"].iter().any(|wrong| text.contains(wrong)), "{text}");
        }
    });
}

/// Eight items of each of two styles, which differ between themselves and not by style: without the items, the style seems to
/// matter; with them, it does not. Its own effect is found.
#[test]
fn items_are_a_sample_too() {
    let names: Vec<String> = (0..16).map(|item| format!("picture {item}")).collect();
    let rows: Vec<[&str; 2]> = (0..16).map(|item| [["old", "new"][item % 2], names[item].as_str()]).collect();
    // The items of the second style happen to be rated higher.
    let own = [-1.4, 1.9, 0.9, -0.6, -0.8, 1.2, 0.4, -0.9, -1.1, -0.3, 0.7, 1.6, -0.2, -0.9, 0.1, 0.4];
    let with = |effect: f64, items: Option<&str>| {
        let latent = |_: usize, row: usize| Some(own[row] + effect * (row % 2) as f64);
        let options = Options { items: items.map(str::to_owned), ..options(Some("style")) };
        let results = analyze(study(&["style", "item"], &rows, (12, 2, 9), latent), &options);
        let p = results.model.as_ref().unwrap().terms[0].p.unwrap();
        (p, results)
    };
    let (ignored, _) = with(0.0, None);
    let (p, results) = with(0.0, Some("item"));
    assert!(ignored < 0.05 && p > 0.1, "{ignored} {p}");
    let Summary { lead, findings, .. } = said(&results);
    assert!(lead.iter().any(|text| text.contains("The 16 levels of item are a sample of items")), "{lead:?}");
    assert!(findings[0].contains("cannot distinguish"), "{findings:?}");
    assert_eq!((results.cells.len(), results.factors.len(), results.factors[0].friedman), (2, 1, None));
    assert!(results.model.as_ref().unwrap().model.random.as_ref().unwrap().items.as_ref().unwrap().sd > 0.5);
    let (p, results) = with(3.0, Some("item"));
    assert!(p < 0.05, "{p}");
    assert!(page(&source(&["style"]), &results).contains("of a participant and an item with average random effects"));
}

/// Ratings that drift and ratings that follow the one before are found, and those in an order that does not matter are not.
#[test]
fn the_order_of_trials_is_examined() {
    const TRIALS: usize = 40;
    let of = |people: usize, drift: f64, follow: f64, is_blocked: bool| {
        let mut rng = ChaCha8Rng::seed_from_u64(31);
        let mut builder = MeasuredBuilder::new(&["level"]).with_categories(&["0", "1", "2", "3"]);
        for person in 0..people {
            let mut noise = 0.0;
            for trial in 0..TRIALS {
                noise = follow * noise + rng.random_range(-1.5..1.5);
                let latent = drift * (trial as f64 / (TRIALS - 1) as f64 - 0.5) + noise;
                // One person rates one condition.
                let random = rng.random_range(0..people.min(2));
                let level = if is_blocked { 2 * trial / TRIALS } else { random };
                let (subject, values) = (format!("S{person:02}"), [["a", "b"][level]]);
                let (rating, position) = (rate(latent, &mut rng), Some(trial as f64));
                let row = RatingRow {
                    subject: &subject,
                    values: &values,
                    rating: &rating,
                    count: 1,
                    session: "1",
                    position,
                    ..RatingRow::default()
                };
                builder.add(&row).unwrap();
            }
        }
        let results = analyze(builder.finish(), &options(None));
        let order = results.model.as_ref().unwrap().order.clone().unwrap();
        (order, said(&results).cautions.join(" "))
    };
    let (none, cautions) = of(8, 0.0, 0.0, false);
    assert!(!none.is_dependent() && !none.is_drifting() && !cautions.contains("Successive"), "{none:?} {cautions}");
    // Conditions in blocks take nothing from a drift within them.
    for is_blocked in [false, true] {
        let (drift, cautions) = of(8, -2.5, 0.0, is_blocked);
        assert!(drift.is_drifting() && drift.drift.is_some_and(|by| by < -1.5), "{drift:?}");
        assert!(cautions.contains("Ratings fall during a session"), "{cautions}");
    }
    for people in [1, 8] {
        let (order, cautions) = of(people, 0.0, 0.8, false);
        assert!(order.is_dependent() && order.lag_one > 0.2, "{people}: {order:?}");
        assert!(cautions.contains("Successive ratings are related"), "{cautions}");
        assert_eq!(order.drift_p.is_some(), people > 5);
        assert_eq!(order.ratings, (people * TRIALS) as u64);
    }
}

/// Ratings rise with age in one condition only. The sentences follow the interaction, and tables have no level for each age.
#[test]
fn a_covariate_has_a_slope_at_each_level() {
    let ages: Vec<String> = (0..12).map(|person| (20 + 4 * person).to_string()).collect();
    let rows: Vec<[&str; 2]> = ages.iter().flat_map(|age| [[age.as_str(), "a"], [age.as_str(), "b"]]).collect();
    let latent = |person: usize, row: usize| (row / 2 == person).then_some((row % 2) as f64 * (person as f64 - 5.5));
    let measured = study(&["age", "cond"], &rows, (12, 8, 6), latent);
    for (terms, term) in [(None, "num:age,cond"), (Some("age*cond"), "num:age,cond,num:age:cond")] {
        let results = analyze(measured.clone(), &options(terms));
        assert_eq!(results.spec.terms.to_string(), term);
        let Summary { findings, cautions, .. } = said(&results);
        let all = format!("{findings:#?} {cautions:#?}");
        assert!(findings[0].starts_with("The effects of age and cond depend on each other"), "{all}");
        assert!(!all.contains("Ratings depend on age"), "{all}");
        assert_eq!(findings[0].contains("From age 20 to 64, the odds"), terms.is_some(), "{all}");
        assert_eq!(
            findings[0].contains("at cond a and ") && findings[0].contains("at cond b."),
            terms.is_some(),
            "{all}"
        );
        assert_eq!(all.contains("A term such as num:age*cond"), terms.is_none(), "{all}");
        let report = results.model.as_ref().unwrap();
        let slope = |level: &str| {
            let has = |own: &&Comparison| own.at.as_ref().is_some_and(|(_, at)| at == level);
            report
                .comparisons
                .iter()
                .find(has)
                .filter(|own| own.factor == "age" && own.level == "64" && own.other == "20")
        };
        assert_eq!(slope("a").is_some(), terms.is_some());
        for (level, used) in [("a", 1), ("b", 2)] {
            let Some(Comparison { estimate, interval, .. }) = slope(level) else { continue };
            let own = report.model.coefficients.iter().filter(|c| c.name.contains("age")).take(used);
            let expected: f64 = own.map(|c| 44.0 * c.estimate).sum();
            assert!((estimate - expected).abs() < 1e-9, "{level}: {estimate}, {expected}");
            let interval = interval.unwrap();
            assert!(
                interval.low < *estimate && *estimate < interval.high && (interval.low > 0.0) == (level == "b"),
                "{interval:?}"
            );
        }
    }
}

/// The effects of three factors cancel in every pair of them. The check of the additive model says so, and the full model
/// leads with the three-way interaction and tests every part of it.
#[test]
fn an_interaction_of_three_is_seen() {
    let all: Vec<[&str; 3]> = (0..8).map(|i| [["p", "q"][i / 4], ["x", "z"][i / 2 % 2], ["l", "r"][i % 2]]).collect();
    let rows: Vec<&[&str]> = all.iter().map(|row| &row[..]).collect();
    let sign = |row: usize| if row.count_ones().is_multiple_of(2) { 1.5 } else { -1.5 };
    let measured = study(&["a", "b", "c"], &rows, (8, 8, 5), |_, row| Some(sign(row)));
    let additive = analyze(measured.clone(), &options(None));
    let cautions = said(&additive).cautions.join(" ");
    assert!(cautions.contains("does not describe the ratings"), "{cautions}");
    let full = analyze(measured, &fewer_draws(Some("a*b*c")));
    let report = full.model.as_ref().unwrap();
    assert!(report.terms.len() == 7 && report.terms.iter().all(|test| test.p.is_some()), "{:?}", report.terms);
    let Summary { findings, cautions, .. } = said(&full);
    assert!(findings[0].starts_with("The effects of a, b and c depend on each other"), "{findings:?}");
    assert!(findings[0].contains("analyze each level of one of them"), "{findings:?}");
    let all = format!("{findings:?} {cautions:?}");
    assert!(!all.contains("cannot tell") && !all.contains("no clear effect") && !all.contains("not describe"), "{all}");
}
