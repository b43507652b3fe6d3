//! The plain-language summary. Every sentence is computed from the results.

use super::{
    cautions::{cautions, simulated},
    exclusions, findings, health, interactions, names,
};
use crate::{
    analysis::{ModelReport, Results, results::FactorResults},
    report::document::{Section, count, list, mean},
    statistics::mean_and_sd,
    store::ratings::Source,
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
    let scale = names::scale(counts, source.protocol.as_ref());
    let is_used = |category: &usize| counts.rows.iter().any(|row| usize::from(row.rating) == *category);
    let used: Vec<usize> = (0..scale.len()).filter(is_used).collect();
    if let (Some(&first), Some(&last)) = (used.first(), used.last()) {
        let positions =
            if names::categories_are_texts(counts) { "; means use their positions, counted from 0" } else { "" };
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
    if counts.total() > 0 {
        // As in every mean, each participant counts equally.
        let of_people: Vec<f64> = results.subjects.iter().map(|subject| subject.group.summary.mean).collect();
        lead.push(format!("Their overall mean is {}.", mean(mean_and_sd(&of_people).0)));
    }
    if (2..FEW_PEOPLE).contains(&results.people()) {
        lead.push(format!("With only {who}, intervals are wide, and only large and consistent effects can be found."));
    }
    let is_modeled = |name: &&String| results.model.is_ok() && findings::main_effect(results, name).is_some();
    let modeled = results.covariates.iter().filter(is_modeled);
    let names: Vec<String> = modeled.map(|name| names::factor(results, name)).collect();
    if !names.is_empty() {
        let (covariates, are) = match names.len() {
            1 => ("covariate", "a number with a linear effect, not a condition"),
            _ => ("covariates", "numbers with linear effects, not conditions"),
        };
        lead.push(format!("The model has the {covariates} {}: {are}.", list(&names)));
    }
    if let Some((_, items)) = results.spec.items.as_ref().and_then(|items| results.modeled().factor(items)) {
        let is_modeled =
            |report: &ModelReport| report.model.random.as_ref().is_some_and(|random| random.items.is_some());
        lead.push(format!(
            "The {} of {} are a sample of items{} Raw means and their intervals hold for these items.",
            count(items.levels.len() as u64, "level"),
            names::factor(results, &items.name),
            if results.model.as_ref().is_ok_and(is_modeled) {
                ": each has a random intercept in the model, so its tests and intervals hold for other items as well."
            } else {
                ", but there is no model with random effects of them, so the results say nothing about other items."
            }
        ));
    }
    lead.extend(exclusions::sentences(source, results));
    lead.extend(health::finished_sentence(source, results));
    lead
}
