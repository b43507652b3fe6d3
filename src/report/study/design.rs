//! The design: what was varied, how often, how it was shown, and what was done of it.

use maud::{Markup, html};

use super::{description, names, sittings};
use crate::report::document::numbers::{count, fixed, short_list, whole};
use crate::report::skins::html::table::{Kind, table};
use crate::{
    analysis::Results,
    experiment::{Order, Protocol},
    store::ratings::Source,
};

/// The section.
pub(crate) fn section(source: &Source, results: &Results) -> Markup {
    html! {
        @match &source.protocol {
            Some(protocol) => (defined(source, protocol)),
            None => { p { "The files bring no definition of an experiment: what is said here is what the ratings themselves show." } }
        }
        (factors(source, results))
        (done(source, results))
    }
}

fn defined(source: &Source, protocol: &Protocol) -> Markup {
    let design = &protocol.design;
    let row = |what: &str, value: String| vec![what.to_owned(), value];
    let mut rows = vec![
        row("Experiment", protocol.name.clone()),
        row("Stimulus", stimulus(protocol)),
        row("Trials of each condition", whole(design.repetitions.into())),
        row("Main trials of a session", whole(protocol.main_trials() as u64)),
        row("Practice trials, not analysed", whole(design.practice.into())),
        row("Order", order(protocol)),
        row(
            "Break",
            if design.break_every == 0 {
                "none".to_owned()
            } else {
                format!("after every {} trials", design.break_every)
            },
        ),
        row(
            "Between stimuli",
            format!(
                "a uniform field of relative luminance {} for {} s",
                protocol.recovery.level, protocol.recovery.duration_s
            ),
        ),
        row(
            "Planned viewing",
            format!(
                "{} cm from the screen, stimulus {}° wide",
                protocol.viewing.distance_cm, protocol.viewing.window_deg
            ),
        ),
        row("Question", protocol.response.question.clone()),
        row("Answers", names::categories_of(protocol).join("; ")),
    ];
    if let Some((first, last)) = sittings::days(source) {
        rows.push(row(
            "Sessions",
            if first == last { format!("on {first}") } else { format!("from {first} to {last}") },
        ));
    }
    table("The design, by its definition", &[("What", Kind::Text), ("Value", Kind::Text)], rows)
}

/// The stimulus and its parameters that do not vary.
fn stimulus(protocol: &Protocol) -> String {
    let stimulus = &protocol.stimulus;
    let fixed: Vec<String> = (stimulus.parameters().iter())
        .filter(|parameter| !protocol.factors.iter().any(|factor| factor.name == parameter.name))
        .filter_map(|parameter| Some(format!("{} {}", parameter.name, stimulus.get(parameter.name)?)))
        .collect();
    if fixed.is_empty() { stimulus.kind().to_owned() } else { format!("{} ({})", stimulus.kind(), fixed.join(", ")) }
}

fn order(protocol: &Protocol) -> String {
    let order = match &protocol.design.order {
        Order::Random => "all trials in random order".to_owned(),
        Order::Blocked(factor) => format!("blocks by {}, in random order", names::factor(factor)),
        Order::Latin(factor) => format!("blocks by {}, their order balanced over participants", names::factor(factor)),
    };
    match protocol.design.max_run {
        Some(run) => format!("{order}, at most {run} in a row with the same level"),
        None => order,
    }
}

fn factors(source: &Source, results: &Results) -> Markup {
    let planned = |name: &str| -> Option<usize> {
        let factor = source.protocol.as_ref()?.factors.iter().find(|factor| factor.name == name)?;
        Some(factor.levels.len())
    };
    let rows: Vec<Vec<String>> = (results.measured.counts.factors.iter())
        .map(|factor| {
            let levels: Vec<String> = factor.levels.iter().map(|level| names::level(&factor.name, level)).collect();
            let planned = planned(&factor.name).map_or_else(|| "–".to_owned(), |n| n.to_string());
            vec![names::factor(&factor.name).to_owned(), levels.join(", "), levels.len().to_string(), planned]
        })
        .collect();
    let columns =
        [("Factor", Kind::Text), ("Levels rated", Kind::Text), ("Number", Kind::Number), ("Planned", Kind::Number)];
    html! {
        @if rows.is_empty() {
            p { "No factor was varied: all ratings are of one condition." }
        } @else {
            (table("Factors and their levels", &columns, rows))
        }
    }
}

/// Planned against done.
fn done(source: &Source, results: &Results) -> Markup {
    let planned: u64 = source.sessions.iter().filter_map(|session| session.planned).sum();
    let rated: u64 = source.sessions.iter().filter(|s| s.planned.is_some()).map(|s| s.rated).sum();
    let all: usize = results.measured.counts.factors.iter().map(|factor| factor.levels.len()).product();
    let found = results.measured.counts.conditions.len();
    let ns: Vec<u64> = results.cells.iter().map(|cell| cell.summary.n).collect();
    html! {
        @if planned > 0 {
            p {
                "Of " (count(planned, "planned main trial")) " in " (count(source.sessions.len() as u64, "session")) ", "
                (whole(rated)) " are rated (" (fixed(100.0 * rated as f64 / planned as f64, 1)) "\u{a0}%)."
            }
        }
        @if found > 0 {
            p {
                (count(found as u64, "condition")) " have ratings"
                @if found < all { ", of " (whole(all as u64)) " that these levels could form" }
                "; " (per_condition(&ns)) "."
            }
        }
        @if let Some(sentence) = description::uneven(results) { p { (sentence) } }
        @if source.protocol.is_none() && !results.measured.counts.subjects.is_empty() {
            p { "Participants: " (short_list(&results.measured.counts.subjects, 12)) "." }
        }
    }
}

fn per_condition(ns: &[u64]) -> String {
    match (ns.iter().min(), ns.iter().max()) {
        (Some(least), Some(most)) if least == most => format!("each has {}", count(*least, "rating")),
        (Some(least), Some(most)) => {
            format!("the number of ratings of each goes from {} to {}", whole(*least), whole(*most))
        }
        _ => "none has ratings".to_owned(),
    }
}
