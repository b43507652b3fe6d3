//! The plain-language summary, with cautions about the data, the model, and how participants answered. Every sentence is
//! computed from the results.

use std::collections::BTreeSet;

use super::{findings, health, interactions, names};
use crate::{
    analysis::{
        Checks, ModelReport, Note, Order, Results,
        counts::Measured,
        number_of,
        results::{FactorResults, SubjectResults},
        terms::Term,
    },
    report::document::{Section, count, either, list, short_list, whole},
    store::{FileError, ratings::Source},
};

/// With fewer participants than this, the summary says that they are few.
const FEW_PEOPLE: usize = 6;

/// A study's conclusions, in sentences.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Summary {
    /// Who rated what.
    pub lead: Vec<String>,
    /// The findings: an item for each factor or interaction.
    pub findings: Vec<String>,
    /// Cautions, most serious first.
    pub cautions: Vec<String>,
}

pub(super) fn section(source: &Source, results: &Results) -> Section {
    let Summary { lead, findings, mut cautions } = summary(source, results);
    let mut section = Section::new("summary", "Summary");
    // A caution about simulated data comes first, and prominently.
    if simulated(source, results).is_some() {
        section.warning(cautions.remove(0));
    }
    section.text(lead.join(" "));
    section.list(findings);
    if !cautions.is_empty() {
        section.heading("Cautions");
        section.list(cautions);
    }
    section
}

/// Summarizes a study.
pub fn summary(source: &Source, results: &Results) -> Summary {
    // Where effects depend on each other, no factor has an effect of its own.
    let dependences = interactions::dependences(results);
    let (clear, others): (Vec<_>, Vec<_>) = dependences.iter().partition(|found| found.is_clear());
    let mut findings: Vec<String> =
        clear.iter().filter_map(|found| interactions::interaction(results, found)).collect();
    let alone = names::varied(results).filter(|factor| !interactions::is_dependent(&dependences, &factor.name));
    findings.extend(alone.map(|factor| findings::finding(results, factor)));
    findings.extend(results.covariates.iter().filter_map(|name| interactions::covariate(results, &dependences, name)));
    findings.extend(others.iter().filter_map(|found| interactions::interaction(results, found)));
    findings.extend(interactions::untested(results, &dependences));
    Summary { lead: lead(source, results), findings, cautions: cautions(source, results) }
}

fn lead(source: &Source, results: &Results) -> Vec<String> {
    let counts = &results.measured.counts;
    let levels = |factor: &FactorResults| {
        let own = counts.factor(&factor.name).map(|(index, _)| index);
        let is_missing = own.is_some_and(|own| counts.conditions.iter().any(|levels| levels[own].is_none()));
        format!("{} levels{}", factor.levels.len(), if is_missing { ", missing in some ratings" } else { "" })
    };
    let who = count(results.people() as u64, "participant");
    let mut lead = vec![names::rated(&who, results, "which differ in", levels)];
    let possible: u64 = counts.factors.iter().map(|factor| factor.levels.len() as u64).product();
    if counts.complete_conditions() < possible {
        lead.push(format!("There are {} possible combinations of these levels.", whole(possible)));
    }
    let scale = names::scale(counts, source.protocol.as_ref());
    let is_used = |category: &usize| counts.rows.iter().any(|row| usize::from(row.rating) == *category);
    let used: Vec<usize> = (0..scale.len()).filter(is_used).collect();
    if let (Some(&first), Some(&last)) = (used.first(), used.last()) {
        let is_text = |category: &String| !number_of(category).is_some_and(f64::is_finite);
        let are_texts = counts.categories.iter().any(is_text);
        let positions = if are_texts { "; means use their positions, counted from 0" } else { "" };
        let ratings = match first == last {
            true => format!("all ratings are {}", scale[first]),
            false => format!("ratings range from {} to {}", scale[first], scale[last]),
        };
        lead.push(match scale.as_slice() {
            [low, .., high] if (first, last) != (0, scale.len() - 1) => {
                format!("The scale is from {low} to {high}{positions}; {ratings}.")
            }
            _ => format!("{}{positions}.", names::capitalized(&ratings)),
        });
    }
    if (2..FEW_PEOPLE).contains(&results.people()) {
        lead.push(format!("With only {who}, intervals are wide, and only large and consistent effects can be found."));
    }
    let is_modeled = |name: &&String| results.model.is_ok() && findings::main_effect(results, name).is_some();
    let modeled = results.covariates.iter().filter(is_modeled);
    let names: Vec<String> = modeled.map(|name| names::factor(results, name)).collect();
    if !names.is_empty() {
        let s = if names.len() == 1 { "" } else { "s" };
        lead.push(format!(
            "The model has the covariate{s} {}, with a linear effect instead of conditions.",
            list(&names)
        ));
    }
    if let Some((_, items)) = results.spec.items.as_ref().and_then(|items| results.modeled().factor(items)) {
        let is_modeled =
            |report: &ModelReport| report.model.random.as_ref().is_some_and(|random| random.items.is_some());
        lead.push(format!(
            "The {} of {} are a sample of items{} Raw means and their intervals hold for these items.",
            count(items.levels.len() as u64, "level"),
            names::factor(results, &items.name),
            if results.model.as_ref().is_ok_and(is_modeled) {
                ": each has a random intercept, so the model’s tests and intervals hold for other items as well."
            } else {
                ", but there is no model with random effects of them, so the results say nothing about other items."
            }
        ));
    }
    lead.extend(health::exclusions(source, results));
    lead.extend(health::finished_sentence(source, results));
    lead
}

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
fn cautions(source: &Source, results: &Results) -> Vec<String> {
    let mut cautions = Vec::new();
    cautions.extend(simulated(source, results));
    cautions.extend((results.people() == 1).then(|| ONE_PARTICIPANT.to_owned()));
    cautions.extend(problems(&source.errors, "error"));
    cautions.extend(problems(&source.warnings, "warning"));
    cautions.extend(nothing_found(results));
    cautions.extend(about_model(results));
    cautions.extend(unusual_behavior(results));
    cautions
}

/// Says which ratings come from a program, if any do.
fn simulated(source: &Source, results: &Results) -> Option<String> {
    let simulated = health::simulated(source, results);
    if simulated.is_empty() {
        return None;
    }
    let [from_program, all] = [0, 1].map(|which| simulated.values().map(|counts| counts[which]).sum());
    Some(if simulated.values().all(|[own, all]| own == all) && simulated.len() >= results.people() {
        "These data are simulated: all ratings come from a program, and the results say nothing about people."
            .to_owned()
    } else {
        format!(
            "Some of these data are simulated: {} of {} ratings of {} of {} ({}) come from a program. The results combine them \
             with other ratings.",
            whole(from_program),
            whole(all),
            simulated.len(),
            count(results.people() as u64, "participant"),
            short_list(&Vec::from_iter(simulated.into_keys()), MAX_NAMES)
        )
    })
}

/// What the trials of one participant say.
const ONE_PARTICIPANT: &str = "There is only one participant: tests and intervals are about this participant’s repeated trials and say \
     nothing about other people. “machband plan” estimates how many participants a statement about people needs.";

fn problems(problems: &[FileError], what: &str) -> Option<String> {
    let files: BTreeSet<&str> = problems.iter().map(|problem| problem.file.as_str()).collect();
    let (messages, files) = (count(problems.len() as u64, what), count(files.len() as u64, "file"));
    (!problems.is_empty()).then(|| format!("The input has {messages} in {files}; see “Data quality”."))
}

/// Warns that a missing effect proves nothing: absence of evidence is not evidence of absence.
fn nothing_found(results: &Results) -> Option<String> {
    let [effects, trends] = interactions::unclear(results);
    let none = [("effect of", effects), ("linear trend with", trends)].into_iter().filter(|(_, of)| !of.is_empty());
    let none: Vec<String> = none.map(|(what, of)| format!("no clear {what} {}", either(&of))).collect();
    let what = match results.people() {
        1 => "These trials of one participant".to_owned(),
        people => format!("This study, with {},", count(people as u64, "participant")),
    };
    (!none.is_empty()).then(|| format!("{what} found {}. This does not show that there is none.", list(&none)))
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
                    An effect may differ along the scale, or other terms may describe them better: interactions, or the levels \
                    of a factor instead of a slope.";
        cautions.push(text.to_owned());
    }
    cautions.extend(extrapolated(results));
    let notes = &report.model.notes;
    if results.ignores_people() {
        cautions.push(
            "The model treats all ratings as independent, although ratings by the same participant are related. Its \
             intervals are probably too narrow, and its p values too small."
                .to_owned(),
        );
    }
    cautions.extend(notes.iter().filter(|note| is_serious(note)).map(|note| names::note(results, &report.model, note)));
    if report.order.as_ref().is_some_and(Order::is_dependent) {
        let so = if results.is_inferential() {
            "If conditions were shown in blocks, effects may seem clearer than they are, and people may seem to differ in them."
        } else {
            "The tests of this participant’s trials assume that they are independent, and find effects too often."
        };
        cautions.push(format!(
            "Successive ratings are related beyond what the model explains (see “Do ratings depend on the order of the \
             trials?”). {so}"
        ));
    }
    if let Some(drift) = report.order.as_ref().filter(|order| order.is_drifting()).and_then(|order| order.drift) {
        cautions.push(format!(
            "Ratings {} during a session, so conditions that come early or late are not compared fairly (see “Do ratings depend \
             on the order of the trials?”).",
            if drift > 0.0 { "rise" } else { "fall" }
        ));
    }
    cautions
}

/// Warns of covariates whose values do not overlap between the levels of a factor in the model.
fn extrapolated(results: &Results) -> Vec<String> {
    let Some(Measured { counts, .. }) = &results.whole else { return Vec::new() };
    let place = |name: &String| counts.factors.iter().position(|factor| factor.name == *name);
    let main = |factor: &&FactorResults| results.spec.terms.iter().any(|term| *term == Term::factor(&factor.name));
    let of = |covariate: &String, factor: &FactorResults| {
        let own = place(&factor.name)?;
        let [lower, higher] = counts
            .apart(place(covariate)?, own)?
            .map(|level| names::level(results, &factor.name, &counts.factors[own].levels[level as usize]).to_string());
        let [covariate, factor] = [covariate, &factor.name].map(|name| names::factor(results, name));
        Some(format!(
            "Every value of {covariate} at {higher} is above those at {lower}: the effects of {factor} and {covariate} can be told \
             apart only by extrapolation."
        ))
    };
    let factors = || results.factors.iter().filter(main);
    results.covariates.iter().flat_map(|covariate| factors().filter_map(move |factor| of(covariate, factor))).collect()
}

/// True if a note is a caution. There is a separate caution for a single participant.
fn is_serious(note: &Note) -> bool {
    matches!(
        note,
        Note::NoMixedModel
            | Note::NotConverged { .. }
            | Note::Flat
            | Note::AliasedTerm { .. }
            | Note::Nested { .. }
            | Note::MissingValues { .. }
            | Note::EmptyCategory { .. }
            | Note::Rebased { .. }
    )
}

/// Describes behavior of participants that readers should check: use of one category, and unusual response times.
fn unusual_behavior(results: &Results) -> Vec<String> {
    let who = |is: &dyn Fn(&SubjectResults) -> bool, what: &str| {
        let ids: Vec<&str> = results.subjects.iter().filter(|own| is(own)).map(names::participant).collect();
        (!ids.is_empty()).then(|| format!("{} {what}", names::who(&ids, MAX_NAMES)))
    };
    let is_monotonous = |own: &SubjectResults| {
        let summary = &own.group.summary;
        summary.n >= FEW_RATINGS && summary.proportions.iter().any(|share| *share >= NEARLY_ALL)
    };
    let sentences = [
        who(&is_monotonous, "used one category for at least 90\u{a0}% of their ratings."),
        who(
            &|own| own.time.is_some_and(|time| time > LONG_S),
            "took more than a minute for half of the answers: are the times in milliseconds? They are read as seconds.",
        ),
        who(
            &|own| own.time.is_some_and(|time| time < HASTY_S),
            "gave half of the answers within 0.3\u{a0}s: too fast to look and decide.",
        ),
    ];
    sentences.into_iter().flatten().collect()
}
