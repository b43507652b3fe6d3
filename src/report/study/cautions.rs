//! What the reader must bear in mind, in sentences.

use super::{effects, health, names, oddities::oddities, sittings, summary::ALPHA};
use crate::report::document::numbers::{count, list, p_is, probability, short_list};
use crate::{
    analysis::{Note, Results, results::FactorResults},
    store::ratings::Source,
};

/// All of them, the gravest first.
pub(crate) fn cautions(source: &Source, results: &Results) -> Vec<String> {
    let mut cautions = Vec::new();
    cautions.extend(simulated(source, results));
    cautions.extend(one_participant(source, results));
    cautions.extend(faults(source));
    cautions.extend(nothing_found(results));
    cautions.extend(about_model(results));
    cautions.extend(names::varied(results).filter_map(|factor| hopeless_pairs(results, factor)));
    cautions.extend(oddities(results));
    cautions
}

/// Absence of evidence is no evidence of absence.
fn nothing_found(results: &Results) -> Option<String> {
    let unclear: Vec<&str> = names::varied(results)
        .filter(|factor| effects::evidence(results, factor).is_some_and(|evidence| evidence.p >= ALPHA))
        .map(|factor| names::factor(&factor.name))
        .collect();
    (!unclear.is_empty()).then(|| {
        format!(
            "That this study, with {}, found no clear difference by {} does not show that there is none.",
            count(results.people() as u64, "participant"),
            list(&unclear)
        )
    })
}

/// Said first and plainly: these are not people.
pub(crate) fn simulated(source: &Source, results: &Results) -> Option<String> {
    let simulated = sittings::simulated(source);
    if simulated.is_empty() {
        return None;
    }
    Some(if simulated.len() >= results.people() {
        "These data are simulated: a program gave all ratings, and nothing here says anything about people.".to_owned()
    } else {
        format!(
            "Part of these data is simulated: a program gave ratings of {} of {} ({}). What follows mixes them with those of people.",
            simulated.len(),
            count(results.people() as u64, "participant"),
            short_list(&simulated, 6)
        )
    })
}

fn one_participant(source: &Source, results: &Results) -> Option<String> {
    if results.people() != 1 {
        return None;
    }
    let plan = match &source.protocol {
        Some(protocol) => format!("machband plan {} --participants 4,8,12", protocol.name),
        None => "machband plan".to_owned(),
    };
    Some(format!(
        "There is one participant: this page describes these ratings, and nothing follows from them for other people. \
         The next step is more participants; “{plan}” estimates how many are needed."
    ))
}

fn faults(source: &Source) -> Option<String> {
    let messages = source.faults.len() as u64;
    (messages > 0).then(|| {
        let files = count(health::files_with_faults(source) as u64, "file");
        format!("Reading gave {} about {files}: see the health of the data.", count(messages, "fault message"))
    })
}

/// What the reader must know of the model before its numbers.
fn about_model(results: &Results) -> Vec<String> {
    let report = match &results.model {
        Ok(report) => report,
        Err(error) => return vec![format!("There is no model: {error}.")],
    };
    let mut cautions = Vec::new();
    let counts_for_people = results.is_inferential() && report.model.random.is_none();
    let notes = &report.model.notes;
    if counts_for_people && !notes.iter().any(|note| matches!(note, Note::RunawayVariance | Note::NoMixedModel)) {
        cautions.push(
            "The model takes all ratings as independent, although those of a person belong together: its intervals are \
             probably too narrow."
                .to_owned(),
        );
    }
    let serious = notes.iter().filter(|note| is_serious(note)).map(|note| format!("About the model: {note}."));
    cautions.extend(serious);
    if results.is_inferential() {
        for test in &report.proportional_odds {
            if let Some(p) = test.p.filter(|p| *p < ALPHA) {
                cautions.push(format!(
                    "The effect of {} is not the same along the scale (proportional odds, {}): its one number is an average.",
                    names::factor(&test.term),
                    p_is(p)
                ));
            }
        }
    }
    cautions
}

fn is_serious(note: &Note) -> bool {
    match note {
        Note::RunawayVariance
        | Note::NoMixedModel
        | Note::NotConverged { .. }
        | Note::Flat
        | Note::MissingValues { .. }
        | Note::EmptyCategory { .. }
        | Note::Rebased { .. } => true,
        // Of one participant more is said than this.
        Note::OneSubject
        | Note::NoSubjectVariance
        | Note::Aliased { .. }
        | Note::AliasedTerm { .. }
        | Note::Separation { .. }
        | Note::SeparatedThreshold { .. }
        | Note::ScaleIgnored => false,
    }
}

/// Where no ratings whatever could tell a pair of levels apart.
pub(crate) fn hopeless_pairs(results: &Results, factor: &FactorResults) -> Option<String> {
    let pairs = factor.pairs.as_ref().filter(|pairs| results.is_inferential() && pairs.cannot_reach(ALPHA))?;
    let people = results.people() - factor.incomplete.len();
    let (name, people) = (names::factor(&factor.name), count(people as u64, "participant"));
    let least = if pairs.least_p >= 1.0 { "1".to_owned() } else { probability(pairs.least_p) };
    Some(match pairs.pairs.len() {
        1 => format!(
            "Wilcoxon’s test cannot tell the levels of {name} apart: with {people} its least p is {least}, whatever the ratings."
        ),
        n => format!(
            "Which levels of {name} differ cannot be tested in pairs: with {people} and {n} pairs the least p that Holm’s \
             correction can give is {least}, whatever the ratings."
        ),
    })
}
