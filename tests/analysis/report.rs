//! `report.html`: its sentences are true of the results, it says no more than they do, and it is one page that asks
//! nothing of a network.

use std::path::PathBuf;

use machband::{
    analysis::{
        Options, Random, Results, analyze,
        bootstrap::Bootstrap,
        counts::{Measured, MeasuredBuilder},
        terms::Terms,
    },
    experiment::{Protocol, RatingRow},
    report::{
        Provenance, figures,
        prediction::StudyPrediction,
        skins,
        study::{self, Parts, Summary, document},
    },
    store::{
        FileFault, definition,
        ratings::{FileRead, Layout, SessionRead, Shape, Source},
        sidecar::{PreflightNote, Sidecar, Sitting},
    },
};
use proptest::prelude::*;

const WIDTHS: [&str; 3] = ["0.1", "0.2", "0.4"];
const DEPTHS: [&str; 5] = ["1", "2", "3", "4", "inf"];
const SHADERS: [&str; 3] = ["flat", "gouraud", "phong"];

/// A source without a definition.
fn source(factors: &[&str]) -> Source {
    let factors = factors.iter().map(|&name| name.to_owned()).collect();
    Source {
        shape: Shape {
            factors,
            subject: "subject_id".to_owned(),
            response: "rating".to_owned(),
            categories: None,
            guessed: false,
        },
        protocol: None,
        definition_sha256: None,
        files: Vec::new(),
        sessions: Vec::new(),
        faults: Vec::new(),
    }
}

/// A number in 0…1 that looks like chance and is the same everywhere.
fn noise(index: u64) -> f64 {
    let mut x = index.wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((x ^ (x >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
}

/// Ratings that fall with depth, rise with width and are the same for all shaders; or the reverse of each.
fn ratings(people: usize, depths: &[&str], reversed: bool) -> Measured {
    let mut builder =
        MeasuredBuilder::new(&["width", "depth", "shader"]).with_categories(&["0", "1", "2", "3"].map(str::to_owned));
    for person in 0..people {
        for (w, width) in WIDTHS.iter().enumerate() {
            for (d, depth) in depths.iter().enumerate() {
                for repetition in 1..=2 {
                    let index = ((person * 10 + w) * 10 + d) * 10 + repetition as usize;
                    let level = 1.6 + 0.35 * w as f64 - 0.45 * d as f64 + 2.0 * (noise(index as u64) - 0.5);
                    let rating = level.round().clamp(0.0, 3.0) as u8;
                    let rating = if reversed { 3 - rating } else { rating };
                    for shader in SHADERS {
                        let subject = format!("S{:03}", person + 1);
                        let row = RatingRow {
                            subject: &subject,
                            values: &[width, depth, shader],
                            rating: &rating.to_string(),
                            count: 1,
                            place: Some(("1", repetition)),
                            response_time_s: Some(1.0 + noise(index as u64)),
                        };
                        builder.add(&row).unwrap();
                    }
                }
            }
        }
    }
    builder.finish()
}

fn options() -> Options {
    Options { bootstrap: Bootstrap { replicates: 200, ..Bootstrap::default() }, ..Options::default() }
}

fn results(people: usize, depths: &[&str], reversed: bool) -> Results {
    analyze(ratings(people, depths, reversed), &options())
}

fn page(source: &Source, results: &Results) -> String {
    let provenance = Provenance::new("machband analyze data --out analysis", "2026-01-02T03:04:05Z".parse().unwrap());
    let predicted = StudyPrediction::of(source, &results.measured.counts);
    let mut drawn = figures::all(results);
    drawn.extend(predicted.iter().flat_map(|predicted| figures::predicted(results, &predicted.ratings)));
    let parts = Parts { figures: &drawn, prediction: Some(&predicted), provenance: Some(&provenance) };
    skins::html(&document(source, results, parts), &provenance)
}

fn summary(results: &Results) -> Summary {
    study::summary(&source(&["width", "depth", "shader"]), results)
}

/// The only finding that has these words.
fn finding<'a>(summary: &'a Summary, words: &str) -> &'a str {
    let found: Vec<&String> = summary.findings.iter().filter(|finding| finding.contains(words)).collect();
    assert_eq!(found.len(), 1, "{words}: {:?}", summary.findings);
    found[0]
}

/// The words of a page, without tags, style and drawings' insides.
fn words(page: &str) -> String {
    let mut text = String::new();
    let mut rest = page;
    while let Some(start) = rest.find('<') {
        text.push_str(&rest[..start]);
        let end = start + rest[start..].find('>').expect("a tag ends");
        let skipped = rest[start..].starts_with("<style").then(|| rest.find("</style>").unwrap());
        rest = &rest[skipped.unwrap_or(end + 1)..];
        text.push(' ');
    }
    text.push_str(rest);
    let marks = [("&lt;", "<"), ("&gt;", ">"), ("&quot;", "\""), ("&amp;", "&"), ("\u{a0}", " ")];
    marks.iter().fold(text, |text, (mark, character)| text.replace(mark, character))
}

/// Every element is closed in its order, and every attribute is quoted.
fn assert_well_formed(page: &str) {
    const VOID: [&str; 6] = ["meta", "br", "link", "img", "hr", "!DOCTYPE"];
    let mut open: Vec<&str> = Vec::new();
    let mut rest = page;
    while let Some(start) = rest.find('<') {
        assert!(!rest[..start].contains('>'), "a bracket in the text: {}", &rest[..start]);
        let end = start + rest[start..].find('>').expect("a tag ends");
        let tag = &rest[start + 1..end];
        rest = &rest[end + 1..];
        assert_eq!(tag.matches('"').count() % 2, 0, "<{tag}>");
        let name = tag.trim_start_matches('/').split([' ', '\n', '/']).next().unwrap();
        if tag.starts_with('/') {
            assert_eq!(open.pop(), Some(name), "</{name}> near {}", rest.chars().take(80).collect::<String>());
        } else if name == "style" && open.last() == Some(&"head") {
            rest = &rest[rest.find("</style>").unwrap() + "</style>".len()..];
        } else if !VOID.contains(&name) && !tag.ends_with('/') {
            open.push(name);
        }
    }
    assert!(open.is_empty(), "not closed: {open:?}");
}

/// Nothing that a browser would fetch or run.
fn assert_offline(page: &str) {
    let lower = page.to_lowercase();
    for forbidden in ["<script", " src=", "<link", "<iframe", "<object", "<embed", "@import", "srcset=", "<?xml"] {
        assert!(!lower.contains(forbidden), "{forbidden}");
    }
    for (at, _) in lower.match_indices("url(") {
        assert!(lower[at..].starts_with("url(#"), "{}", &page[at..at + 40]);
    }
    for (at, _) in lower.match_indices("href=\"") {
        let target = &lower[at + "href=\"".len()..];
        assert!(target.starts_with('#') || target.starts_with("https://"), "{}", &page[at..at + 60]);
    }
}

#[test]
fn words_follow_the_direction_of_the_data() {
    let forwards = summary(&results(8, &DEPTHS, false));
    let backwards = summary(&results(8, &DEPTHS, true));
    assert!(finding(&forwards, "falls with depth at every step").contains("p\u{a0}<\u{a0}.001"), "{forwards:?}");
    finding(&forwards, "rises with width at every step");
    finding(&backwards, "rises with depth at every step");
    finding(&backwards, "falls with width at every step");
    for summary in [&forwards, &backwards] {
        let same = finding(summary, "shader");
        assert!(same.contains("cannot tell the levels apart"));
        let cautions = summary.cautions.join(" ");
        assert!(
            cautions.contains("found no clear difference by shader. That does not show that there is none"),
            "{cautions}"
        );
        // The largest of many differences that chance can make is no estimate.
        assert!(!same.contains("The odds"), "{same}");
        assert!(!same.contains("rises") && !same.contains("falls"), "{same}");
    }
}

/// The reverse of the ratings has the same odds ratio, of the same two levels in the other order.
#[test]
fn odds_are_those_of_the_higher_level() {
    let sentence = |reversed| {
        let results = results(8, &DEPTHS, reversed);
        let text = finding(&summary(&results), "with depth").to_owned();
        let start = text.find("The odds").unwrap();
        text[start..].to_owned()
    };
    let (forwards, backwards) = (sentence(false), sentence(true));
    assert!(forwards.contains("at 1 are estimated as") && forwards.contains("times those at ∞"), "{forwards}");
    assert!(backwards.contains("at ∞ are estimated as") && backwards.contains("times those at 1"), "{backwards}");
    let number = |text: &str| {
        text.split("estimated as ").nth(1).unwrap().split(' ').next().unwrap().replace(',', "").parse::<f64>().unwrap()
    };
    assert!(number(&forwards) > 2.0);
    assert!((number(&forwards) / number(&backwards) - 1.0).abs() < 0.02);
}

/// Numbers in the order of a text, as printed.
fn numbers(text: &str) -> Vec<String> {
    let mut found = Vec::new();
    let mut number = String::new();
    // Digits of a name (`S001`) are none.
    let mut in_word = false;
    for c in text.chars().chain([' ']) {
        if !in_word && (c.is_ascii_digit() || (matches!(c, '.' | ',') && (c == '.' || !number.is_empty()))) {
            number.push(c);
            continue;
        }
        let text = number.trim_end_matches(['.', ',']).replace(',', "");
        if text.chars().any(|c| c.is_ascii_digit()) {
            found.push(text.strip_prefix("0.").map_or(text.clone(), |rest| format!(".{rest}")));
        }
        number.clear();
        in_word = c.is_alphanumeric();
    }
    found
}

/// Everything a summary may quote, by every number of decimals that it may have.
fn quotable(results: &Results) -> Vec<String> {
    let counts = &results.measured.counts;
    let mut values = vec![results.people() as f64, counts.total() as f64, counts.conditions.len() as f64];
    let interval = |values: &mut Vec<f64>, interval: Option<machband::analysis::bootstrap::Interval>| {
        values.extend(interval.into_iter().flat_map(|i| [i.low, i.high]));
    };
    let weighted: f64 = results.subjects.iter().map(|s| s.group.summary.mean * s.group.summary.n as f64).sum();
    values.push(weighted / counts.total() as f64);
    for factor in &results.factors {
        values.push(factor.levels.len() as f64);
        values.extend(factor.levels.iter().map(|level| level.summary.mean));
        values.extend(factor.friedman.iter().flat_map(|f| [f.chi_squared, f.df as f64, f.p]));
        values.extend(factor.pairs.iter().flat_map(|pairs| [pairs.least_p, pairs.pairs.len() as f64]));
    }
    values.extend(results.subjects.iter().map(|subject| subject.group.summary.mean));
    values.extend(results.alpha.iter().map(|alpha| alpha.alpha));
    interval(&mut values, results.alpha.and_then(|alpha| alpha.interval));
    values.extend(results.kappa.iter().map(|kappa| kappa.0));
    interval(&mut values, results.kappa.and_then(|kappa| kappa.1));
    let report = results.model.as_ref().unwrap();
    for test in report.terms.iter().chain(&report.proportional_odds) {
        values.extend([test.lr.unwrap(), test.df as f64, test.p.unwrap()]);
    }
    let model = &report.model;
    let offset = model.thresholds.len();
    for (i, one) in model.coefficients.iter().enumerate() {
        for other in std::iter::once(None).chain((0..model.coefficients.len()).filter(|&j| j != i).map(Some)) {
            let covariance = |a: usize, b: usize| model.covariance[(offset + a, offset + b)];
            let (difference, variance) = match other {
                None => (one.estimate, covariance(i, i)),
                Some(j) => (
                    one.estimate - model.coefficients[j].estimate,
                    covariance(i, i) + covariance(j, j) - 2.0 * covariance(i, j),
                ),
            };
            let reach = 1.959_963_985 * variance.sqrt();
            for sign in [1.0, -1.0] {
                values.extend([difference - reach, difference, difference + reach].map(|x| (sign * x).exp()));
            }
        }
    }
    let mut texts: Vec<String> = (values.iter())
        .flat_map(|value| (0..=4).map(move |decimals| format!("{value:.decimals$}")))
        .map(|text| text.strip_prefix("0.").map_or(text.clone(), |rest| format!(".{rest}")))
        .collect();
    texts.extend(counts.factors.iter().flat_map(|factor| factor.levels.clone()).map(|level| level.replace("0.", ".")));
    // The scale, the ends of probabilities, the level of intervals and tests, Krippendorff's marks.
    texts.extend(["0", "3", "95", ".001", ".99", ".667", ".800"].map(str::to_owned));
    texts
}

#[test]
fn every_number_of_the_summary_is_a_result() {
    for reversed in [false, true] {
        let results = results(8, &DEPTHS, reversed);
        let quotable = quotable(&results);
        let Summary { lead, findings, cautions } = summary(&results);
        let mut checked = 0;
        for sentence in lead.iter().chain(&findings).chain(&cautions) {
            for number in numbers(sentence) {
                assert!(quotable.contains(&number), "{number} in: {sentence}");
                checked += 1;
            }
        }
        assert!(checked > 40, "{checked}");
    }
}

#[test]
fn one_participant_gets_a_description_and_nothing_that_looks_like_inference() {
    let results = results(1, &DEPTHS, false);
    let page = page(&source(&["width", "depth", "shader"]), &results);
    let text = words(&page);
    for sign in ["p =", "p <", "p >", "χ²(", "significan", " interval ", "Friedman’s", "SE"] {
        assert!(
            !text.contains(sign),
            "{sign}: {}",
            text.split(sign).next().unwrap().chars().rev().take(80).collect::<String>()
        );
    }
    assert!(!page.contains(">p</th>") && !page.contains(">SE</th>"));
    assert!(text.contains("nothing follows from them for other people") && text.contains("machband plan"));
    assert!(text.contains("In these ratings the mean tends to fall with depth, from 1.83 at 1 to 0.00 at ∞"), "{text}");
    // With a second person the same words are there.
    let text = words(&self::page(&source(&["width", "depth", "shader"]), &self::results(2, &DEPTHS, false)));
    assert!(text.contains("p <") && text.contains(" interval ") && !text.contains("nothing follows from them"));
}

#[test]
fn holms_limit_is_told_where_it_binds_and_only_there() {
    let told = |people: usize, depths: &[&str]| {
        let results = results(people, depths, false);
        let summary = summary(&results);
        let text = words(&page(&source(&["width", "depth", "shader"]), &results));
        let cautions: Vec<String> =
            summary.cautions.into_iter().filter(|caution| caution.contains("Holm’s correction can give")).collect();
        for caution in &cautions {
            // Once, in the summary.
            assert_eq!(text.matches(&caution.replace('\u{a0}', " ")).count(), 1, "{caution}");
        }
        cautions
    };
    let eight = told(8, &DEPTHS);
    assert_eq!(eight.len(), 1);
    assert!(eight[0].contains("depth") && eight[0].contains("10 pairs") && eight[0].contains(".078"), "{eight:?}");
    assert!(told(8, &DEPTHS[..4]).is_empty());
    assert!(told(9, &DEPTHS).is_empty());
    // Three levels are three pairs, of which five people cannot tell any apart.
    assert_eq!(told(5, &DEPTHS[..3]).len(), 3);
}

fn session(protocol: &Protocol, subject: &str, sitting: Sitting) -> SessionRead {
    SessionRead {
        subject: subject.to_owned(),
        session: "1".to_owned(),
        path: PathBuf::from(format!("{subject}.csv")),
        planned: Some(90),
        rated: 90,
        dropped: Some(0),
        sidecar: Some(Sidecar::new(protocol, 1, sitting)),
    }
}

#[test]
fn what_is_wrong_with_the_data_is_told() {
    let protocol = definition::open("quick").unwrap();
    let results = results(2, &DEPTHS, false);
    let mut source = source(&["width", "depth", "shader"]);
    source.protocol = Some(protocol.clone());
    let viewing = |distance: f64| Some(serde_json::json!({ "distance_cm": distance }));
    let person = Sitting { viewing: viewing(50.0), ..Sitting::default() };
    source.sessions = vec![session(&protocol, "S001", person.clone()), session(&protocol, "S002", person.clone())];
    let text = words(&page(&source, &results));
    assert!(!text.contains("imulated") && text.contains("All 2 sessions are finished"));
    assert!(text.contains("all sittings were run alike") && text.contains("No fault was found"));

    let note = PreflightNote { check: "refresh".to_owned(), ok: false, sentence: "Frames are not steady.".to_owned() };
    let fine = PreflightNote { check: "scale".to_owned(), ok: true, sentence: "The scale is 1.".to_owned() };
    let other = Sitting {
        observer: Some(serde_json::json!({ "observer": "paper" })),
        viewing: viewing(70.0),
        preflight: vec![note, fine],
        incidents: vec!["the folder was moved".to_owned()],
        ..Sitting::default()
    };
    source.sessions[1] = SessionRead { rated: 60, dropped: Some(7), ..session(&protocol, "S002", other) };
    source.faults = vec![FileFault {
        file: "S002.csv".to_owned(),
        position: Some((3, 9)),
        message: "rating 4; expected 0…3".to_owned(),
    }];
    source.files = vec![FileRead {
        path: PathBuf::from("S002.csv"),
        layout: Layout::Results,
        rows: 1105,
        counted: 1096,
        ratings: 1096,
        practice: 4,
        superseded: 3,
        faulty: 2,
        unfinished: 0,
        sha256: Some("ab".repeat(32)),
    }];
    let text = words(&page(&source, &results));
    for told in [
        "Part of these data is simulated: a program gave the ratings of 1 of 2 participants (S002)",
        "1 of 2 sessions is unfinished",
        "unfinished, 30 missing",
        "In 7 of 150 trials",
        "Frames are not steady. (1 sitting)",
        "S002, session 1: the folder was moved",
        "Sittings differ in observer and viewing distance",
        "50 cm (1 sitting); 70 cm (1 sitting)",
        "S002.csv:3:9: rating 4; expected 0…3",
        "1,105",
        &"ab".repeat(32),
    ] {
        assert!(text.contains(told), "{told}");
    }
    assert!(!text.contains("The scale is 1.") && !text.contains("All 2 sessions"));

    for session in &mut source.sessions {
        session.sidecar.as_mut().unwrap().sittings[0].observer = Some(serde_json::json!({ "observer": "random" }));
    }
    let summary = study::summary(&source, &results);
    assert!(summary.cautions[0].contains("nothing here says anything about people"), "{:?}", summary.cautions);
    assert!(words(&page(&source, &results)).contains("2 simulated observers gave"));
}

#[test]
fn who_answers_all_alike_is_named() {
    let mut builder = MeasuredBuilder::new(&["width"]).with_categories(&["0", "1", "2", "3"].map(str::to_owned));
    for (subject, time) in [("ann", 1.0), ("ben", 1.1), ("cyd", 0.2), ("dot", 9.0)] {
        for width in WIDTHS {
            for repetition in 1..=10 {
                let rating = if subject == "ben" { "2" } else { ["0", "1", "2", "3"][repetition as usize % 4] };
                let place = Some(("1", repetition));
                let response_time_s = Some(time);
                builder
                    .add(&RatingRow { subject, values: &[width], rating, count: 1, place, response_time_s })
                    .unwrap();
            }
        }
    }
    let results = analyze(builder.finish(), &options());
    let cautions = study::summary(&source(&["width"]), &results).cautions;
    assert!(
        cautions.iter().any(|caution| caution == "ben used one category only: all 30 ratings are 2."),
        "{cautions:?}"
    );
    assert!(cautions.iter().any(|caution| caution.contains("answers of cyd came within 0.2")), "{cautions:?}");
    assert!(cautions.iter().any(|caution| caution.contains("dot answered unusually slowly")), "{cautions:?}");
    assert!(!cautions.iter().any(|caution| caution.contains("answered unusually fast")), "said already: {cautions:?}");
    // Their first ratings are 1 and their second 2, whatever the width: no better than chance.
    assert!(
        cautions
            .iter()
            .any(|caution| caution == "ann, cyd and dot agreed little with their own first ratings: κ = .00.")
    );
}

#[test]
fn what_a_model_leaves_open_is_told() {
    let sentences = |options: &Options| {
        let results = analyze(ratings(6, &DEPTHS, false), options);
        assert_well_formed(&page(&source(&["width", "depth", "shader"]), &results));
        summary(&results)
    };
    let independent = sentences(&Options { random: Some(Random::None), ..options() });
    assert!(independent.cautions.iter().any(|caution| caution.contains("treats all ratings as independent")));
    // Then the test is the one that does not.
    assert!(finding(&independent, "with depth").contains("Friedman’s test: χ²"));
    let mixed = sentences(&options());
    assert!(!mixed.cautions.iter().any(|caution| caution.contains("independent")));
    assert!(finding(&mixed, "with depth").contains("likelihood-ratio test: χ²"));
    let crossed = sentences(&Options { terms: Some(Terms::parse("width*depth").unwrap()), ..options() });
    finding(&crossed, "effects of width and depth depend on each other");
    assert!(!finding(&crossed, "with depth").contains("odds"), "an effect that is several has no one size");
    let probit = sentences(&Options { link: machband::analysis::Link::Probit, ..options() });
    assert!(finding(&probit, "with depth").contains("standard deviations above"));

    let mut builder = MeasuredBuilder::new(&["width"]);
    for subject in ["a", "b"] {
        let row = RatingRow { subject, values: &["1"], rating: "2", count: 5, place: None, response_time_s: None };
        builder.add(&row).unwrap();
    }
    let results = analyze(builder.finish(), &options());
    let caution = &study::summary(&source(&["width"]), &results).cautions[0];
    assert_eq!(caution, "There is no model: every rating is 2; expected at least two different ones.");
}

#[test]
fn names_are_text_and_never_markup() {
    let nasty = ["<script>alert(1)</script>", "a\"b'c&d", "</td><img src=x onerror=y>", "url(http://x)"];
    let mut builder = MeasuredBuilder::new(&[nasty[0], nasty[1]]);
    for subject in [nasty[2], nasty[3], "x"] {
        for (index, level) in nasty.iter().enumerate() {
            for repetition in 1..=3 {
                let rating = ["<low>", "&mid;", "\"high\""][(index + repetition as usize + subject.len()) % 3];
                let values = [*level, nasty[3 - index]];
                let place = Some(("<1>", repetition));
                let row = RatingRow { subject, values: &values, rating, count: 1, place, response_time_s: Some(1.0) };
                builder.add(&row).unwrap();
            }
        }
    }
    let results = analyze(builder.finish(), &options());
    let mut source = source(&[nasty[0], nasty[1]]);
    let mut protocol = definition::open("quick").unwrap();
    protocol.title = nasty[0].repeat(9);
    protocol.response.question = nasty[2].to_owned();
    source.faults = vec![FileFault { file: nasty[1].to_owned(), position: None, message: nasty[2].to_owned() }];
    source.sessions =
        vec![session(&protocol, nasty[2], Sitting { incidents: vec![nasty[0].to_owned()], ..Sitting::default() })];
    source.protocol = Some(protocol);
    let page = page(&source, &results);
    assert_well_formed(&page);
    assert!(!page.contains("<script") && !page.contains("<img"));
    assert!(page.contains("&lt;script&gt;alert(1)&lt;/script&gt;"));
}

/// Why nothing is predicted, in one sentence; and what is predicted where it can be.
#[test]
fn what_the_model_of_vision_predicts_or_why_it_predicts_nothing() {
    let results = results(3, &DEPTHS, false);
    let mut protocol = definition::open("bangay2003").unwrap();
    let told = |protocol: Option<&Protocol>, results: &Results| {
        let mut source = source(&["width", "depth", "shader"]);
        source.protocol = protocol.cloned();
        let page = page(&source, results);
        assert_well_formed(&page);
        let start = page.find("<section id=\"vision\">").unwrap();
        let section = &page[start..start + page[start..].find("</section>").unwrap()];
        (words(section), section.matches("<figure").count())
    };
    let why = |protocol: Option<&Protocol>, results: &Results, reason: &str| {
        let (text, figures) = told(protocol, results);
        assert!(text.contains("There is no prediction: ") && text.contains(reason), "{reason}: {text}");
        assert_eq!(figures, 0, "{reason}");
    };
    why(None, &results, "no definition");
    why(Some(&protocol), &results, "do not record orientation_deg");
    protocol.factors.retain(|factor| factor.name != "orientation_deg");
    let (text, figures) = told(Some(&protocol), &results);
    assert_eq!(figures, 4, "{text}");
    assert!(text.contains("window 10° wide") && text.contains("100 cd/m²"), "{text}");
    assert!(text.contains("Over 45 conditions and 270 ratings") && text.contains("The noise ceiling"), "{text}");
    // Of one person there is no ceiling; and what people saw in is what counts.
    let mut source = source(&["width", "depth", "shader"]);
    let seated = |deg: f64| Sitting { viewing: Some(serde_json::json!({ "stimulus_deg": deg })), ..Sitting::default() };
    source.sessions = vec![session(&protocol, "S001", seated(4.0)), session(&protocol, "S001", seated(5.0))];
    source.protocol = Some(protocol.clone());
    let text = words(&page(&source, &self::results(1, &DEPTHS, false)));
    assert!(text.contains("window 4.5° wide") && text.contains("takes the agreement of two participants"), "{text}");
    // What cannot be predicted.
    let rated = |rating: &str, categories: &[&str]| {
        let categories: Vec<String> = categories.iter().map(|&name| name.to_owned()).collect();
        let mut builder = MeasuredBuilder::new(&["width", "depth"]).with_categories(&categories);
        for values in [["0.1", "1"], ["0.2", "inf"]] {
            let row =
                RatingRow { subject: "S1", values: &values, rating, count: 3, place: None, response_time_s: None };
            builder.add(&row).unwrap();
        }
        analyze(builder.finish(), &options())
    };
    why(Some(&protocol), &rated("1", &["0", "1", "2"]), "the scale has 3 categories");
    why(Some(&protocol), &rated("1", &["1"]), "the scale has 1 category;");
    why(Some(&protocol), &rated("1", &["0", "1", "2", "3"]), "expected ratings that rise with visibility");
    let mut black = protocol.clone();
    for name in ["low", "high"] {
        black.stimulus.set(name, &0.0.into()).unwrap();
    }
    why(Some(&black), &results, "cannot see the stimuli: all black");
    let mut elsewhere = protocol.clone();
    elsewhere.factors[0].levels = vec![0.3.into(), 0.5.into()];
    why(Some(&elsewhere), &results, "none of the conditions predicted");
    let mut endless = protocol;
    endless.factors[0].levels = (1..=2000).map(|i| (f64::from(i) / 4000.0).into()).collect();
    why(Some(&endless), &results, "10000 conditions are more than the 5000");
}

#[test]
fn the_page_is_one_file_and_can_be_repeated() {
    let protocol = definition::open("bangay2003").unwrap();
    let results = results(8, &DEPTHS, false);
    let mut source = source(&["width", "depth", "shader"]);
    source.definition_sha256 = Some(definition::hash(&protocol));
    source.protocol = Some(protocol.clone());
    let page = page(&source, &results);
    assert_well_formed(&page);
    assert_offline(&page);
    assert!(page.starts_with("<!DOCTYPE html><html lang=\"en\">"));
    assert_eq!(page.matches("<h1").count(), 1);
    assert_eq!(page.matches("<figure").count(), figures::all(&results).len());
    for (at, _) in page.match_indices("href=\"#") {
        let id = page[at + 7..].split('"').next().unwrap();
        assert_eq!(page.matches(&format!("id=\"{id}\"")).count(), 1, "#{id}");
    }
    let text = words(&page);
    for needed in [
        "machband analyze data --out analysis",
        env!("CARGO_PKG_VERSION"),
        "2026-01-02 03:04:05 UTC",
        &definition::hash(&protocol),
    ] {
        assert!(text.contains(needed), "{needed}");
    }
    // The definition on the page is the definition.
    let start = page.find("schema = 1").unwrap();
    let toml = &page[start..start + page[start..].find("</code>").unwrap()];
    let toml = toml.replace("&quot;", "\"").replace("&lt;", "<").replace("&gt;", ">").replace("&amp;", "&");
    assert_eq!(definition::parse("page", &toml).unwrap(), protocol);
    // Equal inputs, equal page.
    assert_eq!(self::page(&source, &results), page);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]

    /// Whatever the ratings are: a page, no number that is none, and no inference from one person.
    #[test]
    fn any_ratings_make_a_page(
        rows in prop::collection::vec((0..4_usize, 0..4_usize, 0..4_usize, 0..4_usize, 1..4_u64), 0..40),
        people in 1..4_usize,
        texts in any::<bool>(),
    ) {
        let levels = if texts { ["", "a", "b", "c d"] } else { ["", "1", "2.5", "inf"] };
        let categories = if texts { ["low", "mid", "top", "x"] } else { ["0", "1", "2", "3"] };
        let mut builder = MeasuredBuilder::new(&["one", "two_deg"]);
        for (index, (subject, one, two, rating, count)) in rows.iter().enumerate() {
            let subject = format!("S{}", subject % people);
            let row = RatingRow {
                subject: &subject,
                values: &[levels[*one], levels[*two]],
                rating: categories[*rating],
                count: *count,
                place: (index % 3 > 0).then_some(("1", index as u32)),
                response_time_s: (index % 4 > 0).then_some(0.1 * index as f64),
            };
            builder.add(&row).unwrap();
        }
        let bootstrap = Bootstrap { replicates: 20, ..Bootstrap::default() };
        let results = analyze(builder.finish(), &Options { scale: true, bootstrap, ..Options::default() });
        let page = page(&source(&["one", "two_deg"]), &results);
        assert_well_formed(&page);
        assert_offline(&page);
        let text = words(&page);
        prop_assert!(!text.contains("NaN"), "{}", text);
        if results.people() < 2 {
            prop_assert!(!text.contains("p =") && !text.contains("p <") && !text.contains("p >"), "{}", text);
        }
    }
}
