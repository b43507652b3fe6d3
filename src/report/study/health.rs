//! What is wrong with the data, or might be.

use std::collections::BTreeSet;

use maud::{Markup, html};

use super::{oddities::oddities, sittings};
use crate::report::document::numbers::{count, list, short_list, whole};
use crate::report::skins::html::table::{Kind, table};
use crate::{
    analysis::Results,
    store::ratings::{FileRead, SessionRead, Source},
};

/// What became of all rows.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Rows {
    /// Below the headers.
    pub rows: u64,
    /// Of these, those that count.
    pub counted: u64,
    /// Trials that they stand for.
    pub ratings: u64,
    /// Practice.
    pub practice: u64,
    /// Ratings taken back.
    pub superseded: u64,
    /// With a fault.
    pub faulty: u64,
    /// Of unfinished sessions, left out on request.
    pub unfinished: u64,
}

/// The sum over files.
pub(crate) fn rows(source: &Source) -> Rows {
    source.files.iter().fold(Rows::default(), |sum, file: &FileRead| Rows {
        rows: sum.rows + file.rows,
        counted: sum.counted + file.counted,
        ratings: sum.ratings + file.ratings,
        practice: sum.practice + file.practice,
        superseded: sum.superseded + file.superseded,
        faulty: sum.faulty + file.faulty,
        unfinished: sum.unfinished + file.unfinished,
    })
}

/// Sessions in which planned trials are not rated.
pub(crate) fn unfinished(source: &Source) -> Vec<&SessionRead> {
    source.sessions.iter().filter(|session| session.is_unfinished()).collect()
}

/// The section.
pub(crate) fn section(source: &Source, results: &Results) -> Markup {
    let oddities = oddities(results);
    html! {
        (reading(source))
        (faults(source))
        (sessions(source))
        (course_of_sessions(source))
        h3 { "How participants answered" }
        @if oddities.is_empty() {
            p { "Nobody used one category only, and neither response times nor repeated ratings are conspicuous, as far as they are known." }
        } @else {
            ul { @for sentence in &oddities { li { (sentence) } } }
        }
    }
}

fn reading(source: &Source) -> Markup {
    let sum = rows(source);
    let row = |what: &str, n: u64| vec![what.to_owned(), whole(n)];
    let rows = vec![
        row("Files", source.files.len() as u64),
        row("Rows below the headers", sum.rows),
        row("Left out: practice", sum.practice),
        row("Left out: ratings taken back", sum.superseded),
        row("Left out: rows with a fault", sum.faulty),
        row("Left out: unfinished sessions, on request", sum.unfinished),
        row("Rows that count", sum.counted),
        row("Ratings that they stand for", sum.ratings),
    ];
    html! {
        h3 { "What was read" }
        (table("What became of the rows", &[("What", Kind::Text), ("Number", Kind::Number)], rows))
    }
}

fn faults(source: &Source) -> Markup {
    html! {
        h3 { "Faults" }
        @if source.faults.is_empty() {
            p { "No fault was found in the files." }
        } @else {
            p { (count(source.faults.len() as u64, "message")) ". What is wrong was left out; the rest was analysed." }
            ul.faults { @for fault in &source.faults { li { (fault) } } }
        }
    }
}

fn sessions(source: &Source) -> Markup {
    if source.sessions.is_empty() {
        return html! {};
    }
    let unfinished = unfinished(source);
    let simulated = sittings::simulated(source);
    let columns = [
        ("Participant", Kind::Text),
        ("Session", Kind::Text),
        ("Planned", Kind::Number),
        ("Rated", Kind::Number),
        ("State", Kind::Text),
        ("Ratings by", Kind::Text),
        ("Trials with dropped frames", Kind::Number),
    ];
    let rows: Vec<Vec<String>> = source.sessions.iter().map(session).collect();
    html! {
        h3 { "Sessions" }
        @if !simulated.is_empty() {
            p.warning {
                strong { "Simulated." } " The ratings of " (short_list(&simulated, 12)) " were given by a program, not by "
                @if simulated.len() == 1 { "a person." } @else { "people." }
            }
        }
        p { (finished_sentence(source, &unfinished)) }
        (table("Sessions: trials planned and rated", &columns, rows))
    }
}

/// How many sessions are finished, as far as that is known.
pub(crate) fn finished_sentence(source: &Source, unfinished: &[&SessionRead]) -> String {
    let planned = source.sessions.iter().filter(|session| session.planned.is_some()).count();
    let (all, open) = (source.sessions.len(), unfinished.len());
    if planned < all {
        let unknown = count((all - planned) as u64, "session");
        let others =
            if planned > 0 { format!("; of the other {planned}, {open} are unfinished") } else { String::new() };
        return format!("Of {unknown} it is not known how many trials were planned{others}.");
    }
    match (open, all) {
        (0, 1) => "The session is finished.".to_owned(),
        (0, _) => format!("All {all} sessions are finished."),
        (1, 1) => "The session is unfinished.".to_owned(),
        (1, _) => format!("1 of {all} sessions is unfinished."),
        _ => format!("{open} of {all} sessions are unfinished."),
    }
}

fn session(session: &SessionRead) -> Vec<String> {
    let state = match session.planned {
        None => "not known".to_owned(),
        Some(planned) if session.rated < planned => format!("unfinished, {} missing", whole(planned - session.rated)),
        Some(_) => "finished".to_owned(),
    };
    let by = match &session.sidecar {
        None => "not known",
        Some(_) if sittings::is_simulated(session) => "a program",
        Some(_) => "a person",
    };
    let dash = |n: Option<u64>| n.map_or_else(|| "–".to_owned(), whole);
    vec![
        session.subject.clone(),
        session.session.clone(),
        dash(session.planned),
        whole(session.rated),
        state,
        by.to_owned(),
        dash(session.dropped),
    ]
}

fn course_of_sessions(source: &Source) -> Markup {
    let (preflight, incidents) = (sittings::preflight(source), sittings::incidents(source));
    let sittings_told = sittings::all(source).count();
    if sittings_told == 0 {
        return html! {};
    }
    let checks = sittings::all(source).map(|(_, sitting)| sitting.preflight.len()).sum::<usize>();
    let dropped: Vec<u64> = source.sessions.iter().filter_map(|session| session.dropped).collect();
    let late: u64 = dropped.iter().sum();
    let rated: u64 = source.sessions.iter().filter(|s| s.dropped.is_some()).map(|s| s.rated).sum();
    html! {
        h3 { "Screens and incidents" }
        @if dropped.is_empty() {
            p { "No session measured its frames." }
        } @else {
            p { "In " (whole(late)) " of " (count(rated, "trial")) " whose frames were measured at least one frame was dropped." }
        }
        @if checks == 0 {
            p { "No check before a session is recorded." }
        } @else if preflight.is_empty() {
            p { "No check before a session found anything amiss." }
        } @else {
            p { "Found before sessions, and not as it should be:" }
            ul { @for (sentence, n) in &preflight { li { (sentence) " (" (count(*n as u64, "sitting")) ")" } } }
        }
        @if !incidents.is_empty() {
            p { "Mended or moved while sessions ran:" }
            ul { @for incident in &incidents { li { (incident) } } }
        }
        (differences(source))
    }
}

/// What differs between sittings, and so may stand for differences between people.
fn differences(source: &Source) -> Markup {
    let properties = sittings::properties(source);
    let different: Vec<&str> = properties.iter().filter(|p| p.values.len() > 1).map(|p| p.name).collect();
    let value = |(value, n): &(String, usize)| format!("{value} ({})", count(*n as u64, "sitting"));
    let rows: Vec<Vec<String>> = (properties.iter())
        .map(|property| {
            let values: Vec<String> = property.values.iter().map(value).collect();
            let same = if values.len() > 1 { "differs" } else { "the same" };
            vec![property.name.to_owned(), values.join("; "), same.to_owned()]
        })
        .collect();
    html! {
        @if different.is_empty() {
            p { "All sittings were run alike, as far as is recorded." }
        } @else {
            p.warning { "Sittings differ in " (list(&different)) ": differences between participants may come from that." }
        }
        (table("How the sittings were run", &[("What", Kind::Text), ("Value", Kind::Text), ("Over sittings", Kind::Text)], rows))
    }
}

/// Subjects of whom a file says something wrong: how many files have faults.
pub(crate) fn files_with_faults(source: &Source) -> usize {
    source.faults.iter().map(|fault| fault.file.as_str()).collect::<BTreeSet<_>>().len()
}
