//! What the reader must bear in mind, in sentences.

use super::{effects, limits::ALPHA, names, oddities::oddities, sittings};
use crate::{
    analysis::{Note, Results, results::FactorResults},
    report::document::numbers::{count, list, p_is, probability, short_list},
    store::ratings::Source,
};

/// All of them, the gravest first.
pub(super) fn cautions(source: &Source, results: &Results) -> Vec<String> {
    let mut cautions = Vec::new();
    cautions.extend(simulated(source, results));
    cautions.extend(one_participant(source, results));
    cautions.extend(faults(source));
    cautions.extend(nothing_found(results));
    cautions.extend(about_model(results));
    cautions.extend(names::varied(results).filter_map(|factor| pairs_without_power(results, factor)));
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
            "This study, with {}, found no clear difference by {}. That does not show that there is none.",
            count(results.people() as u64, "participant"),
            list(&unclear)
        )
    })
}

fn simulated(source: &Source, results: &Results) -> Option<String> {
    let simulated = sittings::simulated(source);
    if simulated.is_empty() {
        return None;
    }
    Some(if simulated.len() >= results.people() {
        "These data are simulated: a program gave all ratings, and nothing here says anything about people.".to_owned()
    } else {
        format!(
            "Part of these data is simulated: a program gave the ratings of {} of {} ({}). The results mix them with \
             those of people.",
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
    let plan = source.protocol.as_ref().map_or_else(String::new, |p| format!(" {} --participants 4,8,12", p.name));
    Some(format!(
        "There is one participant: this page describes these ratings, and nothing follows from them for other people. \
         The next step is more participants; “machband plan{plan}” estimates how many are needed."
    ))
}

fn faults(source: &Source) -> Option<String> {
    let mut files: Vec<&str> = source.faults.iter().map(|fault| fault.file.as_str()).collect();
    files.sort_unstable();
    files.dedup();
    let (messages, files) = (count(source.faults.len() as u64, "fault"), count(files.len() as u64, "file"));
    (!source.faults.is_empty()).then(|| format!("Reading found {messages} in {files}: see the health of the data."))
}

/// What the reader must know of the model before its numbers.
fn about_model(results: &Results) -> Vec<String> {
    let report = match &results.model {
        Ok(report) => report,
        Err(error) => return vec![format!("There is no model: {error}.")],
    };
    let mut cautions = Vec::new();
    let notes = &report.model.notes;
    let is_told = notes.iter().any(|note| matches!(note, Note::RunawayVariance | Note::NoMixedModel));
    if results.is_inferential() && report.model.random.is_none() && !is_told {
        cautions.push(
            "The model treats all ratings as independent, although the ratings of one person belong together: its \
             intervals are probably too narrow."
                .to_owned(),
        );
    }
    cautions.extend(notes.iter().filter(|note| is_serious(note)).map(|note| format!("About the model: {note}.")));
    if results.is_inferential() {
        for test in &report.proportional_odds {
            if let Some(p) = test.p.filter(|p| *p < ALPHA) {
                cautions.push(format!(
                    "The effect of {} is not the same along the scale (proportional odds, {}). Its one number is an \
                     average: trust its direction more than its size.",
                    names::factor(&test.term),
                    p_is(p)
                ));
            }
        }
    }
    cautions
}

/// Whether a note is a caution; of one participant more is said than the model's note.
pub(super) fn is_serious(note: &Note) -> bool {
    matches!(
        note,
        Note::RunawayVariance
            | Note::NoMixedModel
            | Note::NotConverged { .. }
            | Note::Flat
            | Note::MissingValues { .. }
            | Note::EmptyCategory { .. }
            | Note::Rebased { .. }
    )
}

/// Where no ratings whatever could tell a pair of levels apart.
fn pairs_without_power(results: &Results, factor: &FactorResults) -> Option<String> {
    let pairs = factor.pairs.as_ref().filter(|pairs| results.is_inferential() && pairs.cannot_reach(ALPHA))?;
    let people = count((results.people() - factor.incomplete.len()) as u64, "participant");
    let name = names::factor(&factor.name);
    let least = if pairs.least_p >= 1.0 { "1".to_owned() } else { probability(pairs.least_p) };
    Some(match pairs.pairs.len() {
        1 => format!(
            "Wilcoxon’s test cannot tell the levels of {name} apart: with {people} the smallest possible p is {least}, \
             whatever the ratings."
        ),
        n => format!(
            "No test can tell which levels of {name} differ: with {people} and {n} pairs the smallest p that Holm’s \
             correction can give is {least}, whatever the ratings."
        ),
    })
}
