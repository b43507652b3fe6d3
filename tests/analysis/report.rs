//! Tests of `report.html`: its sentences are true and claim no more than the results do, and it is a single page that
//! needs no network.

use std::{path::PathBuf, sync::Arc};

use machband::{
    analysis::{
        Options, Resampling, Results, analyze,
        counts::{Exclusions, Measured, MeasuredBuilder},
    },
    experiment::{OrderedLogit, Protocol, RatingRow},
    report::{
        Provenance,
        document::numbers::{NBSP, count},
        figures, skins,
        study::{self, Summary, document},
    },
    stimulus::MachBand,
    store::{
        FileError, definition,
        ratings::{SessionRead, Shape, Source},
        sidecar::{Geometry, PreflightNote, Sidecar, SimulatedObserver, Sitting},
    },
};
use proptest::prelude::*;
use resvg::usvg::roxmltree;

const FACTORS: [&str; 3] = ["width", "depth", "shader"];
const WIDTHS: [&str; 3] = ["0.1", "0.2", "0.4"];
const DEPTHS: [&str; 5] = ["1", "2", "3", "4", "inf"];
const SHADERS: [&str; 3] = ["flat", "gouraud", "phong"];
const SCALE: [&str; 4] = ["0", "1", "2", "3"];

/// Creates a source without a definition.
pub fn source(factors: &[&str]) -> Source {
    let factors = factors.iter().map(|&name| name.to_owned()).collect();
    let (subject, response) = ("subject_id".to_owned(), "rating".to_owned());
    Source {
        shape: Shape { factors, subject, response, ..Shape::default() },
        protocol: None,
        definition_sha256: None,
        files: Vec::new(),
        sessions: Vec::new(),
        errors: Vec::new(),
        warnings: Vec::new(),
    }
}

/// Returns a number in 0…1 that looks random but is the same on every machine.
fn noise(index: u64) -> f64 {
    let mut x = index.wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    ((x ^ (x >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
}

/// Adds a rating by a participant at some levels, with the repetition and the response time if they are known.
pub fn add(
    builder: &mut MeasuredBuilder,
    who: (&str, &[&str]),
    rating: &str,
    repetition: Option<u32>,
    time: Option<f64>,
) {
    let ((subject, values), session, response_time_s) = (who, "1", time);
    let row = RatingRow { subject, values, rating, count: 1, session, repetition, position: None, response_time_s };
    builder.add(&row).unwrap();
}

/// Creates ratings that fall with depth, rise with width and are the same for all shaders, or, if `reversed`, the
/// opposite ratings.
fn ratings(people: usize, depths: &[&str], reversed: bool) -> Measured {
    let mut builder = MeasuredBuilder::new(&FACTORS).with_categories(&SCALE);
    for person in 0..people {
        for (w, width) in WIDTHS.iter().enumerate() {
            for (d, depth) in depths.iter().enumerate() {
                for repetition in 1..=2 {
                    let chance = noise((((person * 10 + w) * 10 + d) * 10 + repetition as usize) as u64);
                    let level = 1.6 + 0.35 * w as f64 - 0.45 * d as f64 + 2.0 * (chance - 0.5);
                    let rating = level.round().clamp(0.0, 3.0) as usize;
                    let rating = SCALE[if reversed { 3 - rating } else { rating }];
                    for shader in SHADERS {
                        let subject = format!("S{:03}", person + 1);
                        let levels = [*width, *depth, shader];
                        add(&mut builder, (&subject, &levels), rating, Some(repetition), Some(1.0 + chance));
                    }
                }
            }
        }
    }
    builder.finish()
}

fn options() -> Options {
    Options {
        resampling: Resampling { draws: 59, seed: 2 },
        parameters: Some(MachBand::PARAMETERS),
        ..Options::default()
    }
}

fn results(people: usize, depths: &[&str], reversed: bool) -> Results {
    analyze(ratings(people, depths, reversed), &options())
}

pub fn page(source: &Source, results: &Results) -> String {
    let provenance = Provenance::new("machband analyze data --out analysis", "2026-01-02T03:04:05Z".parse().unwrap());
    skins::html(&document(source, results, &figures::all(results), Some(&provenance)), &provenance)
}

/// Returns the text of a page after checking that the page is well-formed and has nothing that a browser would fetch or
/// run.
fn text(page: &str) -> String {
    let (head, body) = page.split_at(page.find("<body").unwrap());
    for forbidden in ["<script", "<link", "@import", "src=", "url("] {
        assert!(!head.contains(forbidden), "{forbidden}");
    }
    let body = roxmltree::Document::parse(body.strip_suffix("</html>").unwrap());
    let body = body.unwrap_or_else(|error| panic!("{error}\n{page}"));
    let mut text = String::new();
    for node in body.descendants() {
        let name = node.tag_name().name();
        assert!(!["script", "link", "iframe", "object", "embed", "img", "image", "use"].contains(&name), "<{name}>");
        for attribute in node.attributes() {
            let value = attribute.value();
            let fetches = match attribute.name() {
                "href" => !value.starts_with('#') && !value.starts_with("https://"),
                "src" | "srcset" => true,
                _ => value.contains("url("),
            };
            assert!(!fetches, "{attribute:?}");
        }
        if node.is_text() {
            text += &node.text().unwrap_or_default().replace(NBSP, " ");
            text.push(' ');
        }
    }
    text
}

fn summary(results: &Results) -> Summary {
    study::summary(&source(&FACTORS), results)
}

/// Returns the only finding that contains this text.
fn finding<'a>(summary: &'a Summary, part: &str) -> &'a str {
    let found: Vec<&String> = summary.findings.iter().filter(|finding| finding.contains(part)).collect();
    assert_eq!(found.len(), 1, "{part}: {:?}", summary.findings);
    found[0]
}

#[track_caller]
fn assert_parts(text: &str, parts: &[&str]) {
    for part in parts {
        assert!(text.contains(part), "{part:?} is not in: {text}");
    }
}

/// Reversed ratings have the reverse trends. A pair of levels is the later one and the earlier one in every sentence, table and
/// comparison, whichever is rated higher, so that the odds ratio of reversed ratings is the reciprocal.
#[test]
fn sentences_follow_the_direction_of_the_data() {
    let (forwards, backwards) = (summary(&results(8, &DEPTHS, false)), summary(&results(8, &DEPTHS, true)));
    assert!(finding(&forwards, "falls with depth at every step").contains("p\u{a0}<\u{a0}.001"), "{forwards:?}");
    finding(&forwards, "rises with width at every step");
    finding(&backwards, "rises with depth at every step");
    finding(&backwards, "falls with width at every step");
    for summary in [&forwards, &backwards] {
        let same = finding(summary, "shader");
        assert!(same.contains("cannot distinguish the levels"));
        let caution = "found no clear effect of shader. This does not show that there is none";
        assert_parts(&summary.cautions.join(" "), &[caution]);
        // The largest of many chance differences is not an estimate.
        for part in ["The odds", "rises", "falls"] {
            assert!(!same.contains(part), "{same}");
        }
    }
    for reversed in [false, true] {
        let results = results(8, &DEPTHS, reversed);
        for pair in &results.model.as_ref().unwrap().comparisons {
            let levels = &results.measured.counts.factor(&pair.factor).unwrap().1.levels;
            let place = |level: &String| levels.iter().position(|known| known == level);
            assert!(place(&pair.level) > place(&pair.other), "{pair:?}");
            let signs = [pair.estimate < 0.0, (pair.factor == "depth") != reversed];
            assert!(pair.factor == "shader" || signs[0] == signs[1], "{pair:?}");
        }
        assert!(text(&page(&source(&FACTORS), &results)).contains("∞ – 1"));
    }
    let odds = |summary: &Summary| -> f64 {
        let text = finding(summary, "with depth");
        assert_parts(text, &["at ∞ are an estimated", "times those at 1 (", "at ∞ exceeds that at 1 in"]);
        assert!(![" 0\u{a0}%", "100\u{a0}%"].iter().any(|rounded| text.contains(rounded)), "{text}");
        text.split("an estimated ").nth(1).unwrap().split(' ').next().unwrap().replace(',', "").parse().unwrap()
    };
    let (forwards, backwards) = (odds(&forwards), odds(&backwards));
    assert!(forwards < 0.5 && (forwards * backwards - 1.0).abs() < 0.1, "{forwards} {backwards}");
}

#[test]
fn what_is_said_of_one_participant_is_not_said_of_people() {
    let page = |people| page(&source(&FACTORS), &results(people, &DEPTHS, false));
    let (one, two) = (text(&page(1)), text(&page(2)));
    for sign in ["significan", "Friedman", "between participants is"] {
        assert!(!one.contains(sign), "{sign}: {one}");
    }
    let alone = "about this participant’s repeated trials and say nothing about other people";
    assert_parts(&one, &[alone, "machband plan", "if width made no difference to this participant"]);
    assert_parts(&one, &["In these ratings, the mean tends to fall with depth, from 1.83 at 1 to 0.00 at ∞"]);
    // With a second participant, the report draws inferences.
    assert_parts(&two, &[" interval ", "With only 2 participants, intervals are wide"]);
    assert!(!two.contains(alone));
}

fn session(protocol: &Protocol, subject: &str, sitting: Sitting) -> SessionRead {
    SessionRead {
        subject: subject.to_owned(),
        session: "1".to_owned(),
        path: PathBuf::from(format!("{subject}.csv")),
        planned: Some(90),
        rated: 90,
        skipped: 0,
        sidecar: Some(Sidecar::new(protocol, 1, sitting).into()),
    }
}

#[test]
fn problems_with_the_data_are_reported() {
    let protocol = definition::open("quick").unwrap();
    let results = results(2, &DEPTHS, false);
    let viewing = |distance: f64| Some(Geometry { distance_cm: distance, ..Geometry::default() });
    let person = Sitting { viewing: viewing(50.0), ..Sitting::default() };
    let mut source = Source { protocol: Some(protocol.clone()), ..source(&FACTORS) };
    source.sessions = ["S001", "S002"].map(|subject| session(&protocol, subject, person.clone())).to_vec();
    let fine = text(&page(&source, &results));
    let expected = [
        "All planned trials of 2 sessions are rated",
        "all sittings were run in the same way",
        "No errors were found",
        "Figure 1. Mean rating",
    ];
    assert_parts(&fine, &expected);
    assert!(!fine.contains("are simulated"));

    let note = |ok, sentence: &str| PreflightNote { check: "refresh".to_owned(), ok, sentence: sentence.to_owned() };
    let other = Sitting {
        observer: Some(SimulatedObserver::Paper { ordered_logit: OrderedLogit::default() }),
        viewing: viewing(70.0),
        preflight: vec![note(false, "Frames are not steady."), note(true, "The scale is 1.")],
        incidents: vec!["the folder was moved".to_owned()],
        ..Sitting::default()
    };
    source.sessions[1] = SessionRead { rated: 60, ..session(&protocol, "S002", other) };
    let message = "rating 4; expected 0…3".to_owned();
    source.errors = vec![FileError {
        file: "S002.csv".to_owned(),
        position: Some((3, 9)),
        key: String::new(),
        message,
        rows: Vec::new(),
    }];
    let wrong = text(&page(&source, &results));
    let expected = [
        "Some of these data are simulated: 60 of 60 ratings of 1 of 2 participants (S002) come from a program",
        "Of 2 sessions, 1 is known to be finished",
        "Frames are not steady. (1 sitting)",
        "S002, session 1: the folder was moved",
        "sittings differ in observer and viewing distance",
        "S002.csv:3:9: rating 4; expected 0…3",
    ];
    assert_parts(&wrong, &expected);
    assert!(!wrong.contains("The scale is 1.") && !wrong.contains("All planned trials"));

    for session in &mut source.sessions {
        Arc::make_mut(session.sidecar.as_mut().unwrap()).sittings[0].observer = Some(SimulatedObserver::Random);
    }
    assert_parts(&study::summary(&source, &results).cautions[0], &["the results say nothing about people"]);
    assert_parts(&text(&page(&source, &results)), &["2 simulated observers gave"]);

    // An exclusion is named in Summary, Data quality and Methods, and everything is about the rest.
    let exclusions = Exclusions { exclude: vec!["S002".to_owned()], ..Exclusions::default() };
    let left = analyze(results.measured.narrowed(&exclusions).unwrap(), &options());
    let [total, n] = [&results, &left].map(|results| results.measured.counts.total());
    let left = text(&page(&source, &left));
    let excluded = format!("{} by participant S002 were left out.", count(total - n, "rating"));
    let rest = format!("All numbers are about the remaining {} by 1 participant.", count(n, "rating"));
    assert_eq!((left.matches(&excluded).count(), left.matches(&rest).count()), (3, 3), "{left}");
    assert_parts(&left, &["1 simulated observer gave", "all ratings come from a program"]);
    assert!(!left.contains("the folder was moved"));
}

#[test]
fn participants_with_unusual_answers_are_named() {
    let mut builder = MeasuredBuilder::new(&["width"]).with_categories(&SCALE);
    for (subject, time) in [("ann", 1.0), ("ben", 1.1), ("cyd", 0.2), ("dot", 1.2)] {
        for width in 1..=30 {
            for repetition in 1..=10 {
                let rating = if subject == "ben" { "2" } else { SCALE[repetition as usize % 4] };
                add(&mut builder, (subject, &[&width.to_string()]), rating, Some(repetition), Some(time));
            }
        }
    }
    let numbers = Options { terms: Some("num:width".parse().unwrap()), ..options() };
    let cautions = study::summary(&source(&["width"]), &analyze(builder.finish(), &numbers)).cautions.join("\n");
    let ben = "\nParticipant ben used one category for at least 90\u{a0}% of their ratings.\n";
    assert_parts(&cautions, &[ben, "Participant cyd gave half of the answers within 0.3"]);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]

    /// Any ratings give a page, which has no NaN and no inferences from a single person.
    #[test]
    fn any_ratings_give_a_page(
        rows in prop::collection::vec((0..4_usize, 0..4_usize, 0..4_usize, 0..4_usize, 1..4_u64), 0..40),
        people in 1..4_usize,
        texts in any::<bool>(),
    ) {
        let levels = if texts { ["", "a", "b", "c d"] } else { ["", "1", "2.5", "inf"] };
        let categories = if texts { ["low", "mid", "top", "x"] } else { SCALE };
        let mut builder = MeasuredBuilder::new(&["one", "two_deg"]);
        for (index, (subject, one, two, rating, count)) in rows.iter().enumerate() {
            let row = RatingRow {
                subject: &format!("S{}", subject % people),
                values: &[levels[*one], levels[*two]],
                rating: categories[*rating],
                count: *count,
                session: "1",
                repetition: (index % 3 > 0).then_some(index as u32),
                response_time_s: (index % 4 > 0).then_some(0.1 * index as f64),
                ..RatingRow::default()
            };
            builder.add(&row).unwrap();
        }
        let resampling = Resampling { draws: 19, seed: 1 };
        let results = analyze(builder.finish(), &Options { resampling, ..Options::default() });
        let text = text(&page(&source(&["one", "two_deg"]), &results));
        prop_assert!(!text.contains("NaN"), "{}", text);
        if results.people() < 2 {
            prop_assert!(!text.contains("Friedman"), "{}", text);
        }
    }
}
