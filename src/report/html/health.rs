//! What is wrong with the data, or might be.

use std::collections::BTreeSet;

use maud::{Markup, html};

use super::{
    numbers::{count, fixed, list, percent, short_list, unit, whole},
    sittings,
    table::{Kind, table},
};
use crate::{
    analysis::{Results, results::SubjectResults},
    store::ratings::{FileRead, SessionRead, Source},
};

/// Proportion of one category from which a subject is said to have used hardly another.
const NEARLY_ALL: f64 = 0.9;
/// Fewer ratings say nothing about how somebody uses the scale.
const FEW_RATINGS: u64 = 10;
/// κ up to which agreement is "slight" at most, Landis & Koch (1977).
pub(super) const LOW_KAPPA: f64 = 0.2;
/// Median response time, seconds, in which nobody looks and decides.
const HASTY_S: f64 = 0.3;
/// A participant's median time is odd where it is so many times longer or shorter than the middle one.
const ODD_TIMES: f64 = 3.0;
/// Most names in one sentence.
const MOST_NAMES: usize = 6;

/// What became of all rows.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Rows {
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
pub(super) fn rows(source: &Source) -> Rows {
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
pub(super) fn unfinished(source: &Source) -> Vec<&SessionRead> {
    source.sessions.iter().filter(|session| session.is_unfinished()).collect()
}

/// What participants did that a reader should look at, in sentences.
pub(super) fn oddities(results: &Results) -> Vec<String> {
    let subjects = &results.subjects;
    let mut sentences: Vec<String> = subjects.iter().filter_map(|subject| one_category(results, subject)).collect();
    sentences.extend(little_agreement(subjects));
    sentences.extend(haste(subjects));
    sentences.extend(odd_times(subjects));
    sentences
}

fn name(subject: &SubjectResults) -> &str {
    subject.group.names.first().map_or("", String::as_str)
}

fn one_category(results: &Results, subject: &SubjectResults) -> Option<String> {
    let (who, summary) = (name(subject), &subject.group.summary);
    let (category, &share) = summary.proportions.iter().enumerate().max_by(|l, r| l.1.total_cmp(r.1))?;
    if share < NEARLY_ALL || summary.n < FEW_RATINGS {
        return None;
    }
    let category = &results.measured.counts.categories[category];
    let ratings = count(summary.n, "rating");
    Some(if share >= 1.0 {
        format!("{who} used one category only: all {ratings} are {category}.")
    } else {
        let share = percent((share * 100.0).floor() / 100.0);
        format!("{who} used hardly more than one category: {share} of {ratings} are {category}.")
    })
}

/// Several people with the same oddity share a sentence.
fn little_agreement(subjects: &[SubjectResults]) -> Option<String> {
    let low: Vec<(&str, f64)> =
        subjects.iter().filter_map(|s| Some((name(s), s.kappa?))).filter(|(_, kappa)| *kappa <= LOW_KAPPA).collect();
    let (least, most) = ends(&low)?;
    let who: Vec<&str> = low.iter().map(|(who, _)| *who).collect();
    let (least, most) = (unit(least), unit(most));
    let kappa = if least == most { format!("= {least}") } else { format!("from {least} to {most}") };
    Some(format!("{} agreed little with their own first ratings: κ {kappa}.", short_list(&who, MOST_NAMES)))
}

fn haste(subjects: &[SubjectResults]) -> Option<String> {
    let hasty: Vec<(&str, f64)> = subjects
        .iter()
        .filter_map(|s| Some((name(s), s.times?.median)))
        .filter(|(_, median)| *median < HASTY_S)
        .collect();
    let (_, most) = ends(&hasty)?;
    let who: Vec<&str> = hasty.iter().map(|(who, _)| *who).collect();
    Some(format!(
        "Half of the answers of {} came within {} s: too fast to look and decide.",
        short_list(&who, MOST_NAMES),
        fixed(most, 2)
    ))
}

fn ends(values: &[(&str, f64)]) -> Option<(f64, f64)> {
    let numbers = || values.iter().map(|(_, value)| *value);
    Some((numbers().min_by(f64::total_cmp)?, numbers().max_by(f64::total_cmp)?))
}

fn odd_times(subjects: &[SubjectResults]) -> Vec<String> {
    let medians: Vec<(&str, f64)> =
        subjects.iter().filter_map(|subject| Some((name(subject), subject.times?.median))).collect();
    let mut sorted: Vec<f64> = medians.iter().map(|(_, median)| *median).collect();
    sorted.sort_by(f64::total_cmp);
    // With two, neither is the odd one.
    let Some(&middle) = sorted.get(sorted.len() / 2).filter(|_| sorted.len() > 2) else { return Vec::new() };
    (medians.into_iter())
        // Of those who answer in haste this is said already.
        .filter(|(_, median)| *median > ODD_TIMES * middle || (*median * ODD_TIMES < middle && *median >= HASTY_S))
        .map(|(who, median)| {
            let slow = if median > middle { "slowly" } else { "fast" };
            let (own, usual) = (fixed(median, 2), fixed(middle, 2));
            format!("{who} answered unusually {slow}: {own} s at the median, where {usual} s is usual here.")
        })
        .collect()
}

/// The section.
pub(super) fn section(source: &Source, results: &Results) -> Markup {
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
pub(super) fn finished_sentence(source: &Source, unfinished: &[&SessionRead]) -> String {
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
pub(super) fn files_with_faults(source: &Source) -> usize {
    source.faults.iter().map(|fault| fault.file.as_str()).collect::<BTreeSet<_>>().len()
}
