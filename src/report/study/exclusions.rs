//! What was excluded on request, in sentences.

use super::names;
use crate::{
    analysis::{Results, counts::Excluded},
    report::document::{
        Shown,
        numbers::{count, list, whole},
    },
    store::ratings::{SessionRead, Source},
};

/// Returns a sentence for each kind of exclusion, and then how many ratings were analyzed; nothing without exclusions.
pub(super) fn sentences(results: &Results) -> Vec<String> {
    let measured = &results.measured;
    let with_ratings = |name: &str, ratings: u64| format!("{name} ({})", count(ratings, "rating"));
    let mut people = Vec::new();
    let mut sentences = Vec::new();
    for excluded in &measured.excluded {
        match excluded {
            Excluded::Participant { id, ratings } => people.push(with_ratings(id, *ratings)),
            Excluded::Levels { factor, kept, ratings } => {
                let kept: Vec<Shown> = kept.iter().map(|level| names::level(factor, level)).collect();
                let kept: Vec<&str> = kept.iter().map(|level| &**level).collect();
                sentences.push(format!(
                    "On request, only ratings at {} {} were analyzed; {} at other levels {} excluded.",
                    names::factor(factor),
                    list(&kept),
                    count(*ratings, "rating"),
                    if *ratings == 1 { "was" } else { "were" }
                ));
            }
        }
    }
    if !people.is_empty() {
        let who = if people.len() == 1 { "the participant" } else { "the participants" };
        let people: Vec<&str> = people.iter().map(String::as_str).collect();
        sentences.insert(0, format!("On request, {who} {} excluded.", was(&people)));
    }
    if !sentences.is_empty() {
        sentences.push(format!(
            "This leaves {} by {}.",
            count(measured.counts.total(), "rating"),
            count(results.people() as u64, "participant")
        ));
    }
    sentences
}

fn was(names: &[&str]) -> String {
    format!("{} {}", list(names), if names.len() == 1 { "was" } else { "were" })
}

/// Returns the number of ratings that were excluded, formatted.
pub(super) fn ratings(results: &Results) -> Shown {
    whole(results.measured.excluded.iter().map(Excluded::ratings).sum())
}

/// Returns the sessions of participants who were not excluded.
pub(super) fn sessions<'a>(source: &'a Source, results: &Results) -> impl Iterator<Item = &'a SessionRead> + Clone {
    let excluded: Vec<String> = (results.measured.excluded.iter())
        .filter_map(|excluded| match excluded {
            Excluded::Participant { id, .. } => Some(id.clone()),
            Excluded::Levels { .. } => None,
        })
        .collect();
    source.sessions.iter().filter(move |session| !excluded.contains(&session.subject))
}
