//! Names of participants, factors, levels and categories, as used in sentences and tables.

pub(super) use crate::report::names::{capitalized, categories_of, coefficient, factor, level, term};
use crate::{
    analysis::{
        Model, Note, RandomSlope, Results,
        counts::Counts,
        results::{FactorResults, SubjectResults},
        summary::Group,
    },
    experiment::Protocol,
    report::{
        document::{Shown, count, list, short_list},
        names::Known,
    },
};

/// Returns a note about the model as a sentence.
pub(super) fn note(results: &Results, model: &Model, note: &Note) -> String {
    let mut note = note.clone();
    match &mut note {
        Note::MissingValues { factor: name, .. } => *name = factor(results, name),
        Note::Nested { factor: own, other, .. } => {
            [own, other].into_iter().for_each(|name| *name = factor(results, name));
        }
        Note::Rebased { factor: name, baseline, separated, .. } => {
            [baseline, separated].into_iter().for_each(|own| *own = level(results, name, own).to_string());
            *name = factor(results, name);
        }
        Note::AliasedTerm { term: own, of } | Note::NoSlope { term: own, of } => *own = term(results, of),
        Note::Separation { coefficient: own, term: of, .. } => {
            let found = model.coefficients.iter().find(|coefficient| coefficient.name == *own);
            if let Some(found) = found {
                (*own, *of) = (coefficient(results, &found.parts), term(results, &found.term));
            }
        }
        _ => {}
    }
    format!("{}.", capitalized(&note.to_string()))
}

/// Returns the level of a group of ratings.
pub(super) fn level_of(results: &Results, factor: &FactorResults, group: &Group) -> Shown {
    level(results, &factor.name, group.names.first().map_or("", String::as_str))
}

/// Returns the participant's ID.
pub(super) fn participant(subject: &SubjectResults) -> &str {
    subject.group.names.first().map_or("", String::as_str)
}

/// Begins a sentence about participants: `Participant 97`, or `Participants 97, 134 and 3 more`.
pub(super) fn who(ids: &[&str], most: usize) -> String {
    format!("{} {}", if ids.len() == 1 { "Participant" } else { "Participants" }, short_list(ids, most))
}

/// Returns in what participants differ: a term, or a coefficient if the random effects are correlated.
pub(super) fn slope(results: &Results, model: &Model, own: &RandomSlope) -> String {
    let found = model.coefficients.iter().find(|coefficient| coefficient.name == own.name);
    found.map_or_else(|| term(results, &own.term), |found| coefficient(results, &found.parts))
}

/// Returns the categories, with their labels if there is a definition.
pub(super) fn scale(counts: &Counts, protocol: Option<&Protocol>) -> Vec<String> {
    match protocol {
        Some(protocol) if protocol.response.categories.len() == counts.categories.len() => categories_of(protocol),
        _ => counts.categories.iter().map(|category| level(Known::None, "", category).to_string()).collect(),
    }
}

/// Describes the sample in a sentence: `8 participants gave 1,920 ratings of 45 conditions, which differ in …`. The
/// sentence ends with the name of each factor that varies and the result of `levels` for it.
pub(super) fn rated(who: &str, results: &Results, differ: &str, levels: impl Fn(&FactorResults) -> String) -> String {
    let counts = &results.measured.counts;
    let varied: Vec<String> =
        varied(results).map(|one| format!("{} ({})", factor(results, &one.name), levels(one))).collect();
    let by = if varied.is_empty() { String::new() } else { format!(", {differ} {}", list(&varied)) };
    let (ratings, conditions) = (count(counts.total(), "rating"), count(counts.complete_conditions(), "condition"));
    format!("{who} gave {ratings} of {conditions}{by}.")
}

/// Returns the factors that vary.
pub(super) fn varied(results: &Results) -> impl Iterator<Item = &FactorResults> {
    results.factors.iter().filter(|factor| factor.levels.len() > 1)
}
