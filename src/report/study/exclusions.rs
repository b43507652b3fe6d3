//! What was excluded on request, in sentences.

use super::names;
use crate::{
    analysis::{
        Results,
        counts::{Excluded, Part},
    },
    report::document::{Section, Shown, TableOf, count, list, whole},
    store::ratings::{Reason, SessionRead, Source},
};

/// Returns a sentence for each kind of exclusion, and then how many ratings were analyzed; nothing without exclusions.
pub(super) fn sentences(source: &Source, results: &Results) -> Vec<String> {
    let measured = &results.measured;
    let with_ratings = |name: &str, ratings: u64| format!("{name} ({})", count(ratings, "rating"));
    let (mut people, mut sentences, mut further) = (Vec::new(), Vec::new(), false);
    for Excluded { what, ratings, participants } in &measured.excluded {
        match what {
            Part::Participant(id) => people.push(with_ratings(id, *ratings)),
            Part::Levels { factor, kept } => {
                let kept: Vec<Shown> = kept.iter().map(|level| names::level(results, factor, level)).collect();
                sentences.push(format!(
                    "Only ratings at {} {} were analyzed, on request; {} at other levels {} left out.",
                    names::factor(results, factor),
                    list(&kept),
                    count(*ratings, "rating"),
                    if *ratings == 1 { "was" } else { "were" }
                ));
            }
            Part::Missing(factor) => sentences.push(format!(
                "{}{} by {} without a value of {} {} left out, because the model needs it.",
                if std::mem::replace(&mut further, true) { "A further " } else { "" },
                count(*ratings, "rating"),
                count(*participants, "participant"),
                names::factor(results, factor),
                if *ratings == 1 { "was" } else { "were" }
            )),
        }
    }
    if !people.is_empty() {
        let who = if people.len() == 1 { "Participant" } else { "Participants" };
        let were = if people.len() == 1 { "was" } else { "were" };
        sentences.insert(0, format!("{who} {} {were} left out on request.", list(&people)));
    }
    let (least, most) = source.shape.time_limits;
    for (limit, reason, than) in [(least, Reason::TooFast, "less"), (most, Reason::TooSlow, "more")] {
        sentences.extend(limit.map(|limit| {
            let (rows, people) = source.left_out(reason);
            let (rows, people) = (count(rows, "trial"), count(people as u64, "participant"));
            format!("Trials answered in {than} than {limit} s were left out on request ({rows} by {people}).")
        }));
    }
    if !sentences.is_empty() {
        sentences.push(format!(
            "All numbers are about the remaining {} by {}.",
            count(measured.counts.total(), "rating"),
            count(results.people() as u64, "participant")
        ));
    }
    sentences
}

/// Adds a table of everything that was left out and can be read: why, how much, and of how many participants.
pub(super) fn table(section: &mut Section, source: &Source, results: &Results) {
    let reasons = Reason::ALL.iter().map(|reason| (format!("rows {reason}"), source.left_out(*reason)));
    let reasons = reasons.filter(|(_, (rows, _))| *rows > 0);
    let reasons = reasons.map(|(why, (rows, people))| (why, rows, people as u64));
    let requests = results.measured.excluded.iter().map(|excluded| {
        let why = match &excluded.what {
            Part::Participant(id) => format!("ratings by {id}"),
            Part::Levels { factor, .. } => format!("ratings at other levels of {}", names::factor(results, factor)),
            Part::Missing(factor) => format!("ratings without a value of {}", names::factor(results, factor)),
        };
        (why, excluded.ratings, excluded.participants)
    });
    let rows: Vec<(String, u64, u64)> = reasons.chain(requests).collect();
    if !rows.is_empty() {
        TableOf::new("What was left out, and why", &rows)
            .text("Left out", |(why, ..)| why)
            .number("Number", |(_, number, _)| whole(*number))
            .number("Participants", |(.., people)| whole(*people))
            .add_to(section);
    }
}

/// Returns the sessions of participants who were not excluded.
pub(super) fn sessions<'a>(source: &'a Source, results: &Results) -> impl Iterator<Item = &'a SessionRead> + Clone {
    let excluded: Vec<String> = (results.measured.excluded.iter())
        .filter_map(|excluded| if let Part::Participant(id) = &excluded.what { Some(id.clone()) } else { None })
        .collect();
    source.sessions.iter().filter(move |session| !excluded.contains(&session.subject))
}
