//! The design: what was varied, how often, how it was shown, and how much of it was done.

use super::{names, sittings};
use crate::{
    analysis::Results,
    experiment::{Order, Protocol},
    report::document::{
        Section,
        numbers::{count, fixed, short_list, whole},
    },
    store::ratings::Source,
};

/// The section.
pub(super) fn section(source: &Source, results: &Results) -> Section {
    let mut section = Section::new("design", "Design");
    match &source.protocol {
        Some(protocol) => section.facts("The design, by its definition", definition(source, protocol)),
        None => section.text(
            "The files bring no definition of an experiment: this section says what the ratings themselves show.",
        ),
    }
    factors(&mut section, source, results);
    done(&mut section, source, results);
    section
}

fn definition(source: &Source, protocol: &Protocol) -> Vec<(&'static str, String)> {
    let (design, recovery, viewing) = (&protocol.design, &protocol.recovery, &protocol.viewing);
    let breaks = match design.break_every {
        0 => "none".to_owned(),
        n => format!("after every {n} trials"),
    };
    let mut rows = vec![
        ("Experiment", protocol.name.clone()),
        ("Stimulus", stimulus(protocol)),
        ("Trials of each condition", whole(design.repetitions.into())),
        ("Main trials of a session", whole(protocol.main_trials() as u64)),
        ("Practice trials, not analyzed", whole(design.practice.into())),
        ("Order", order(protocol)),
        ("Break", breaks),
        (
            "Between stimuli",
            format!("a uniform field of relative luminance {} for {} s", recovery.level, recovery.duration_s),
        ),
        (
            "Planned viewing",
            format!("{} cm from the screen, stimulus {}° wide", viewing.distance_cm, viewing.window_deg),
        ),
        ("Question", protocol.response.question.clone()),
        ("Answers", names::categories_of(protocol).join("; ")),
    ];
    rows.extend(sittings::days(source).map(|(first, last)| {
        ("Sessions", if first == last { format!("on {first}") } else { format!("from {first} to {last}") })
    }));
    rows
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
        Order::Latin(factor) => {
            format!("blocks by {}, with their order balanced over participants", names::factor(factor))
        }
    };
    match protocol.design.max_run {
        Some(run) => format!("{order}, at most {run} in a row with the same level"),
        None => order,
    }
}

fn factors(section: &mut Section, source: &Source, results: &Results) {
    let planned = |name: &str| {
        let factor = source.protocol.as_ref()?.factors.iter().find(|factor| factor.name == name)?;
        Some(factor.levels.len().to_string())
    };
    let rows: Vec<Vec<String>> = (results.measured.counts.factors.iter())
        .map(|factor| {
            let levels: Vec<String> = factor.levels.iter().map(|level| names::level(&factor.name, level)).collect();
            let planned = planned(&factor.name).unwrap_or_else(|| "–".to_owned());
            vec![names::factor(&factor.name).to_owned(), levels.join(", "), levels.len().to_string(), planned]
        })
        .collect();
    if rows.is_empty() {
        section.text("No factor was varied: all ratings are of one condition.");
    } else {
        section.table("Factors and their levels", &["Factor", "Levels rated"], &["Number", "Planned"], rows);
    }
}

/// Planned against done.
fn done(section: &mut Section, source: &Source, results: &Results) {
    let counts = &results.measured.counts;
    let planned: u64 = source.sessions.iter().filter_map(|session| session.planned).sum();
    let rated: u64 = source.sessions.iter().filter(|s| s.planned.is_some()).map(|s| s.rated).sum();
    if planned > 0 {
        section.text(format!(
            "Of {} in {}, {} are rated ({}\u{a0}%).",
            count(planned, "planned main trial"),
            count(source.sessions.len() as u64, "session"),
            whole(rated),
            fixed(100.0 * rated as f64 / planned as f64, 1)
        ));
    }
    let possible: usize = counts.factors.iter().map(|factor| factor.levels.len()).product();
    let found = counts.conditions.len();
    let ns = || results.cells.iter().map(|cell| cell.summary.n);
    if let (Some(least), Some(most)) = (ns().min(), ns().max()) {
        let of = if found < possible {
            format!(", of {} that these levels could form", whole(possible as u64))
        } else {
            String::new()
        };
        let each = if least == most {
            format!("each has {}", count(least, "rating"))
        } else {
            format!("they have {} to {} ratings each", whole(least), whole(most))
        };
        section.text(format!("{} have ratings{of}; {each}.", count(found as u64, "condition")));
    }
    section.blocks.extend(uneven(results).map(crate::report::document::Block::Text));
    if source.protocol.is_none() && !counts.subjects.is_empty() {
        section.text(format!("Participants: {}.", short_list(&counts.subjects, 12)));
    }
}

/// Participants whose number of ratings differs from most others'; none where all are alike.
fn uneven(results: &Results) -> Option<String> {
    let n = |subject: &crate::analysis::results::SubjectResults| subject.group.summary.n;
    let (least, most) = (results.subjects.iter().map(n).min()?, results.subjects.iter().map(n).max()?);
    let few: Vec<&str> = results.subjects.iter().filter(|subject| n(subject) < most).map(names::participant).collect();
    (least < most).then(|| {
        format!(
            "Participants gave {} to {} ratings. Fewer than the most came from {}.",
            whole(least),
            whole(most),
            short_list(&few, 12)
        )
    })
}
