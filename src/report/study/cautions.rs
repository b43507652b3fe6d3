//! Cautions for readers about the data, the model, and how participants answered.

use std::collections::BTreeSet;

use super::{findings::ALPHA, interactions, names, sittings};
use crate::{
    analysis::{Checks, Note, Results, results::SubjectResults},
    report::document::{count, either, fixed, p_is, percent, short_list, unit, whole},
    store::{FileError, ratings::Source},
};

/// A median response time above this, in seconds, is probably one in milliseconds.
const LONG_S: f64 = 60.0;
/// A participant with at least this proportion of ratings in one category hardly used the others.
const NEARLY_ALL: f64 = 0.9;
/// Minimum number of ratings needed to judge how a participant uses the scale.
const FEW_RATINGS: u64 = 10;
/// A median response time below this, in seconds, is too short to look and decide.
const HASTY_S: f64 = 0.3;
/// Maximum number of names in one sentence.
const MAX_NAMES: usize = 6;

/// Returns all cautions, most serious first.
pub(super) fn cautions(source: &Source, results: &Results) -> Vec<String> {
    let mut cautions = Vec::new();
    cautions.extend(simulated(source, results));
    cautions.extend((results.people() == 1).then(|| ONE_PARTICIPANT.to_owned()));
    cautions.extend(problems(&source.errors, "error", source.files.iter().map(|file| file.erroneous).sum()));
    cautions.extend(problems(&source.warnings, "warning", 0));
    cautions.extend(nothing_found(results));
    cautions.extend(about_model(results));
    cautions.extend(unusual_behavior(results));
    cautions
}

/// Says which ratings come from a program, if any do.
pub(super) fn simulated(source: &Source, results: &Results) -> Option<String> {
    let simulated = sittings::simulated(source, results);
    if simulated.is_empty() {
        return None;
    }
    let is_whole = simulated.values().all(sittings::all_simulated);
    let [from_program, all] = [0, 1].map(|which| simulated.values().map(|counts| counts[which]).sum());
    let ratings =
        if is_whole { "the ratings".to_owned() } else { format!("{} of {} ratings", whole(from_program), whole(all)) };
    Some(if is_whole && simulated.len() >= results.people() {
        "These data are simulated: all ratings come from a program, and the results say nothing about people."
            .to_owned()
    } else {
        format!(
            "Some of these data are simulated: {ratings} of {} of {} ({}) come from a program. The results combine them \
             with ratings from people.",
            simulated.len(),
            count(results.people() as u64, "participant"),
            short_list(&Vec::from_iter(simulated.into_keys()), MAX_NAMES)
        )
    })
}

/// What the trials of one participant say.
const ONE_PARTICIPANT: &str = "There is only one participant: tests and intervals are about this participant’s repeated trials and say \
     nothing about other people. “machband plan” estimates how many participants a statement about people needs.";

fn problems(problems: &[FileError], what: &str, excluded: u64) -> Option<String> {
    let files: BTreeSet<&str> = problems.iter().map(|problem| problem.file.as_str()).collect();
    let (messages, files) = (count(problems.len() as u64, what), count(files.len() as u64, "file"));
    let excluded = match excluded {
        0 => String::new(),
        1 => ", and 1 row is excluded".to_owned(),
        rows => format!(", and {rows} rows are excluded"),
    };
    (!problems.is_empty()).then(|| format!("The input has {messages} in {files}{excluded}; see “Data quality”."))
}

/// Warns that a missing effect proves nothing: absence of evidence is not evidence of absence.
fn nothing_found(results: &Results) -> Option<String> {
    let unclear = interactions::unclear(results);
    let what = match results.people() {
        1 => "These trials of one participant".to_owned(),
        people => format!("This study, with {},", count(people as u64, "participant")),
    };
    let unclear_list = either(&unclear);
    (!unclear.is_empty())
        .then(|| format!("{what} found no clear effect of {unclear_list}. This does not show that there is none."))
}

/// Says what readers must know about the model before they read its numbers.
fn about_model(results: &Results) -> Vec<String> {
    let report = match &results.model {
        Ok(report) => report,
        Err(error) => return vec![format!("There is no model: {error}.")],
    };
    let mut cautions = Vec::new();
    let dependences = interactions::dependences(results);
    cautions.extend(dependences.iter().filter(|found| found.is_clear() && !found.is_modeled).map(|found| {
        let together = found.names(results);
        format!(
            "The model is additive, although the effects of {together} depend on each other: its coefficients and \
             comparisons of each are averages over the other. A term such as {} models the interaction.",
            interactions::product(results, &found.names)
        )
    }));
    if report.checks.as_ref().is_some_and(Checks::is_poor) {
        let text = "The model does not describe the ratings in the single conditions (see “Does the model describe the ratings?”). \
                    Other terms may describe them better: interactions, or the levels of a factor instead of a slope.";
        cautions.push(text.to_owned());
    }
    let notes = &report.model.notes;
    if results.ignores_people() {
        cautions.push(
            "The model treats all ratings as independent, although ratings by the same participant are related. Its \
             intervals are probably too narrow, and its p values too small."
                .to_owned(),
        );
    }
    cautions.extend(notes.iter().filter(|note| is_serious(note)).map(|note| names::note(results, &report.model, note)));
    cautions.extend(report.order.as_ref().filter(|order| order.is_dependent()).map(|order| {
        let so = if results.is_inferential() {
            "If conditions were shown in blocks, this cannot be distinguished from differences between participants in the \
             effects, and effects may seem clearer than they are."
        } else {
            "The tests of this participant’s trials assume that they are independent, and find effects too often."
        };
        format!(
            "Successive ratings are related beyond what the model explains (correlation of residuals {}, {}). {so}",
            unit(order.lag_one),
            p_is(order.lag_one_p)
        )
    }));
    let drifting = report.order.as_ref().filter(|order| order.is_drifting());
    cautions.extend(drifting.and_then(|order| Some((order, order.drift?))).map(|(order, drift)| {
        let verb = if drift > 0.0 { "rise" } else { "fall" };
        format!(
            "Ratings {verb} during a session: by an estimated {} on the latent scale from its first to its last trial ({}). \
             Conditions that come early or late are not compared fairly.",
            fixed(drift.abs(), 2),
            order.drift_p.map(p_is).unwrap_or_default()
        )
    }));
    cautions.extend(report.proportional_odds.iter().filter_map(|test| {
        let p = p_is(test.p_holm.filter(|p| *p < ALPHA)?);
        Some(format!(
            "The ratings show that the effect of {} differs along the scale (test of proportional odds, corrected {p}). Its \
             coefficient is an average.",
            names::term(results, &test.term)
        ))
    }));
    cautions
}

/// True if a note is a caution. There is a separate caution for a single participant.
pub(super) fn is_serious(note: &Note) -> bool {
    matches!(
        note,
        Note::RunawayVariance
            | Note::NoMixedModel
            | Note::NotConverged { .. }
            | Note::Flat
            | Note::AliasedTerm { .. }
            | Note::Nested { .. }
            | Note::MissingValues { .. }
            | Note::EmptyCategory { .. }
            | Note::Rebased { .. }
    )
}

/// Describes behavior of participants that readers should check: use of only one category, and unusual response times.
fn unusual_behavior(results: &Results) -> Vec<String> {
    let subjects = &results.subjects;
    let mut sentences = one_category(results);
    sentences.extend(few_cross(results));
    // Participants with the same peculiarity are named in one sentence.
    let median = |subject: &SubjectResults| Some(subject.times?.median);
    if let Some((who, least, _)) = odd(subjects, |own| median(own).filter(|median| *median > LONG_S)) {
        sentences.push(format!(
            "{who} took at least {} s for half of the answers: are the times in milliseconds? They are read as seconds.",
            fixed(least.floor(), 0)
        ));
    }
    if let Some((who, _, most)) = odd(subjects, |own| median(own).filter(|median| *median < HASTY_S)) {
        let most = fixed(most, 2);
        sentences.push(format!("{who} gave half of the answers within {most} s: too fast to look and decide."));
    }
    sentences
}

/// Names the participants who rated several levels of a factor of which most others rated one.
fn few_cross(results: &Results) -> impl Iterator<Item = String> {
    results.factors.iter().filter(|factor| !factor.within && !factor.crossing.is_empty()).map(|factor| {
        let (name, who) = (names::factor(results, &factor.name), short_list(&factor.crossing, MAX_NAMES));
        let of = count(results.people() as u64, "participant");
        let few = factor.crossing.len();
        format!("{few} of {of} ({who}) rated several levels of {name}, the others at most one: is this by design?")
    })
}

/// Names the participants who used one category always, or nearly always.
fn one_category(results: &Results) -> Vec<String> {
    let most_used = |subject: &SubjectResults| {
        let summary = &subject.group.summary;
        let shares = summary.proportions.iter().enumerate();
        let (category, share) = shares.max_by(|l, r| l.1.total_cmp(r.1)).filter(|_| summary.n >= FEW_RATINGS)?;
        (*share >= NEARLY_ALL).then_some((category, *share))
    };
    let of_category = |(index, name): (usize, &String)| {
        let share = |subject: &SubjectResults| Some(most_used(subject).filter(|(category, _)| *category == index)?.1);
        let (whose, least, _) = odd(&results.subjects, share)?;
        Some(if least >= 1.0 {
            format!("{whose} used only one category: all their ratings are {name}.")
        } else {
            let some = percent((100.0 * least).floor() / 100.0);
            format!("{whose} hardly used more than one category: at least {some} of their ratings are {name}.")
        })
    };
    results.measured.counts.categories.iter().enumerate().filter_map(of_category).collect()
}

/// Returns the names of the participants with an unusual value, and the smallest and the largest such value.
fn odd(subjects: &[SubjectResults], value: impl Fn(&SubjectResults) -> Option<f64>) -> Option<(String, f64, f64)> {
    let (ids, values): (Vec<&str>, Vec<f64>) =
        subjects.iter().filter_map(|own| Some((names::participant(own), value(own)?))).unzip();
    let least = values.iter().copied().min_by(f64::total_cmp)?;
    Some((names::who(&ids, MAX_NAMES), least, values.into_iter().max_by(f64::total_cmp)?))
}
