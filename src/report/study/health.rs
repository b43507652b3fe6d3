//! Data quality: errors, what was excluded on request, sessions, and what differs between their sittings according to the
//! sidecars: who rated, and on which screen.

use std::collections::{BTreeMap, BTreeSet};

use serde_json::json;

use super::names;
use crate::{
    analysis::{
        Results,
        counts::{Excluded, Part},
    },
    report::document::{Section, Shown, TableOf, count, list, whole},
    store::{
        ratings::{FileRead, Reason, SessionRead, Source},
        sidecar::SimulatedObserver,
    },
};

pub(super) fn section(source: &Source, results: &Results) -> Section {
    let mut section = Section::new("health", "Data quality");
    let sum = |of: fn(&FileRead) -> u64| whole(source.files.iter().map(of).sum());
    let facts = [
        ("Files", whole(source.files.len() as u64)),
        ("Rows below the headers", sum(|file| file.rows)),
        ("Excluded: practice", sum(|file| file.practice)),
        ("Excluded: corrected ratings", sum(|file| file.superseded)),
        ("Excluded: rows with errors", sum(|file| file.erroneous)),
        ("Ratings read", sum(|file| file.ratings)),
        ("Ratings analyzed", whole(results.measured.counts.total())),
    ];
    section.facts("Rows read and excluded", facts);
    if let Some(sentence) = exclusions(source, results) {
        section.text(sentence);
        TableOf::new("What was left out, and why", &left_out(source, results))
            .text("Left out", |own| format!("{}s {}", own.noun, own.why))
            .number("Number", |own| whole(own.number))
            .number("Participants", |own| whole(own.participants))
            .add_to(&mut section);
    }
    section.heading("Errors");
    if source.errors.is_empty() {
        section.text("No errors were found in the files.");
    }
    section.problems(&source.errors, &source.warnings);
    let unfinished = sessions(source, results).filter(|session| session.is_unfinished()).map(|session| {
        let planned = count(session.planned.unwrap_or_default(), "planned trial");
        format!("{}, session {}: {} of {planned} are rated.", session.subject, session.session, session.rated)
    });
    section.list(unfinished.collect());
    screens(&mut section, source, results);
    section
}

/// Says how many of the sessions that were not excluded are known to be finished; `None` if there are none.
pub(super) fn finished_sentence(source: &Source, results: &Results) -> Option<String> {
    let (all, is_finished) =
        (sessions(source, results), |own: &&SessionRead| own.planned.is_some_and(|n| own.rated >= n));
    let (number, finished) = (all.clone().count() as u64, all.filter(is_finished).count() as u64);
    let are = if finished == 1 { "is" } else { "are" };
    (number > 0).then(|| match number - finished {
        0 => format!("All planned trials of {} are rated.", count(number, "session")),
        _ => format!("Of {}, {finished} {are} known to be finished.", count(number, "session")),
    })
}

/// Lists what happened according to the sidecars, and in what the sittings differ.
fn screens(section: &mut Section, source: &Source, results: &Results) {
    let sessions = sessions(source, results);
    let mut sittings =
        sessions.flat_map(|session| session.sittings().map(move |sitting| (session, sitting))).peekable();
    if sittings.peek().is_none() {
        return;
    }
    section.heading("Screens and incidents");
    // What was noted, and in how many sittings.
    let mut noted: BTreeMap<String, u64> = BTreeMap::new();
    let mut settings: BTreeMap<&str, BTreeSet<String>> = BTreeMap::new();
    for (session, sitting) in sittings {
        let problems = sitting.preflight.iter().filter(|note| !note.ok).map(|note| note.sentence.clone());
        let of_session = |text| format!("{}, session {}: {text}", session.subject, session.session);
        for text in problems.chain(sitting.incidents.iter().map(of_session)) {
            *noted.entry(text).or_default() += 1;
        }
        for (name, value) in [
            ("program", json!(sitting.program)),
            ("observer", json!(sitting.observer.as_ref().map(SimulatedObserver::name))),
            ("display profile", json!(sitting.display)),
            ("monitor", json!(sitting.monitor.as_ref().map(|own| (own.title(), own.refresh_hz.map(f64::round))))),
            ("viewing distance", json!(sitting.viewing.as_ref().map(|viewing| viewing.distance_cm))),
        ] {
            settings.entry(name).or_default().insert(value.to_string());
        }
    }
    section.list(noted.iter().map(|(text, n)| format!("{text} ({})", count(*n, "sitting"))).collect());
    // Differences between sittings may be confounded with differences between people.
    let different: Vec<&str> = settings.iter().filter(|(_, values)| values.len() > 1).map(|(name, _)| *name).collect();
    if different.is_empty() {
        section.text("According to their sidecars, all sittings were run in the same way.");
    } else {
        section.warning(format!(
            "According to their sidecars, sittings differ in {}, which may explain differences between participants.",
            list(&different)
        ));
    }
}

/// A part of the rows or ratings that can be read and was left out.
struct LeftOut {
    noun: &'static str,
    why: String,
    number: u64,
    participants: u64,
}

/// Returns everything that was left out and can be read.
fn left_out(source: &Source, results: &Results) -> Vec<LeftOut> {
    let (least, most) = source.shape.time_limits;
    let limited = |than: &str, limit: Option<f64>| format!("answered in {than} than {} s", limit.unwrap_or_default());
    let of_reason = |reason: &Reason| {
        let why = match reason {
            Reason::TooFast => limited("less", least),
            Reason::TooSlow => limited("more", most),
            _ => reason.to_string(),
        };
        let (number, participants) = source.left_out(*reason);
        LeftOut { noun: "row", why, number, participants: participants as u64 }
    };
    let requests = results.measured.excluded.iter().map(|Excluded { what, ratings, participants }| {
        let why = match what {
            Part::Participant(id) => format!("by participant {id}"),
            Part::Levels { factor, kept } => {
                let kept: Vec<Shown> = kept.iter().map(|level| names::level(results, factor, level)).collect();
                format!("at levels of {} other than {}", names::factor(results, factor), list(&kept))
            }
            Part::Missing(factor) => format!("without a value of {}", names::factor(results, factor)),
        };
        LeftOut { noun: "rating", why, number: *ratings, participants: *participants }
    });
    Reason::ALL.iter().map(of_reason).filter(|own| own.number > 0).chain(requests).collect()
}

/// Says what was left out, and how many ratings were analyzed; `None` if nothing was.
pub(super) fn exclusions(source: &Source, results: &Results) -> Option<String> {
    let left_out = left_out(source, results);
    let parts: Vec<String> =
        left_out.iter().map(|own| format!("{} {}", count(own.number, own.noun), own.why)).collect();
    let were = if matches!(left_out[..], [LeftOut { number: 1, .. }]) { "was" } else { "were" };
    (!parts.is_empty()).then(|| {
        format!(
            "{} {were} left out. All numbers are about the remaining {} by {}.",
            names::capitalized(&list(&parts)),
            count(results.measured.counts.total(), "rating"),
            count(results.people() as u64, "participant")
        )
    })
}

/// Returns the sessions of participants who were not excluded.
fn sessions<'a>(source: &'a Source, results: &Results) -> impl Iterator<Item = &'a SessionRead> + Clone {
    let excluded: Vec<String> = (results.measured.excluded.iter())
        .filter_map(|excluded| if let Part::Participant(id) = &excluded.what { Some(id.clone()) } else { None })
        .collect();
    source.sessions.iter().filter(move |session| !excluded.contains(&session.subject))
}

/// Returns the analyzed participants who have any ratings from a program: how many, and how many ratings they have in all.
pub(super) fn simulated<'a>(source: &'a Source, results: &Results) -> BTreeMap<&'a str, [u64; 2]> {
    let recorded = source.sessions.iter().filter(|session| session.sidecar.is_some());
    let of = |session: &SessionRead| [if session.is_simulated() { session.rated } else { 0 }, session.rated];
    let sessions = recorded.map(|session| (&session.subject, of(session)));
    let tables = source.files.iter().flat_map(|file| &file.simulated).map(|(subject, counts)| (subject, *counts));
    let mut all = BTreeMap::<&str, [u64; 2]>::new();
    for (subject, counts) in sessions.chain(tables) {
        all.entry(subject).or_default().iter_mut().zip(counts).for_each(|(sum, n)| *sum += n);
    }
    let subjects = &results.measured.counts.subjects;
    all.retain(|subject, [simulated, _]| *simulated > 0 && subjects.iter().any(|known| known == subject));
    all
}
