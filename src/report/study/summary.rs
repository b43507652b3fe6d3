//! The summary in plain language. Every sentence is computed: what cannot be said of these results is not said.

use super::{cautions::cautions, findings, health, names};
use crate::report::document::numbers::{count, list, mean, percent, range, unit};
use crate::{
    analysis::{Results, bootstrap::Interval, results::SubjectResults, summary::category_values},
    store::ratings::Source,
};

/// Probability below which a difference is told apart from chance.
pub(crate) const ALPHA: f64 = 0.05;
/// α from which Krippendorff calls data reliable.
pub(crate) const RELIABLE: f64 = 0.8;
/// α from which Krippendorff allows tentative conclusions.
pub(crate) const TENTATIVE: f64 = 0.667;

/// What a study says, in sentences.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Summary {
    /// Who rated what.
    pub lead: Vec<String>,
    /// What was found, an item a factor, then agreement.
    pub findings: Vec<String>,
    /// What must be borne in mind.
    pub cautions: Vec<String>,
}

/// The summary of a study.
pub fn summary(source: &Source, results: &Results) -> Summary {
    let mut findings: Vec<String> = names::varied(results).map(|factor| findings::finding(results, factor)).collect();
    findings.extend(findings::interactions(results));
    findings.extend(between_participants(results));
    findings.extend(agreement(results));
    findings.extend(repetition(results));
    Summary { lead: lead(source, results), findings, cautions: cautions(source, results) }
}

fn lead(source: &Source, results: &Results) -> Vec<String> {
    let counts = &results.measured.counts;
    let varied: Vec<String> = names::varied(results)
        .map(|factor| format!("{} ({} levels)", names::factor(&factor.name), factor.levels.len()))
        .collect();
    let by = if varied.is_empty() { String::new() } else { format!(", which differ in {}", list(&varied)) };
    let mut lead = vec![format!(
        "{} gave {} of {}{by}.",
        count(results.people() as u64, "participant"),
        count(counts.total(), "rating"),
        count(counts.conditions.len() as u64, "condition"),
    )];
    if let Some((low, high)) = names::ends(counts, source.protocol.as_ref()) {
        let positions = if names::categories_are_texts(counts) { "; a mean counts their places from 0" } else { "" };
        lead.push(format!("Ratings go from {low} to {high}{positions}."));
    }
    if counts.total() > 0 {
        lead.push(format!("Over everything their mean is {}.", mean(grand_mean(results))));
    }
    if !source.sessions.is_empty() {
        lead.push(health::finished_sentence(source, &health::unfinished(source)));
    }
    lead
}

fn grand_mean(results: &Results) -> f64 {
    let counts = &results.measured.counts;
    let values = category_values(counts);
    let sum: f64 = counts.rows.iter().map(|row| row.count as f64 * values[row.rating as usize]).sum();
    sum / counts.total() as f64
}

fn name(subject: &SubjectResults) -> &str {
    subject.group.names.first().map_or("", String::as_str)
}

fn between_participants(results: &Results) -> Option<String> {
    if !results.is_inferential() {
        return None;
    }
    let by_mean = |l: &&SubjectResults, r: &&SubjectResults| l.group.summary.mean.total_cmp(&r.group.summary.mean);
    let (least, most) = (results.subjects.iter().min_by(by_mean)?, results.subjects.iter().max_by(by_mean)?);
    Some(format!(
        "Participants’ own means go from {} ({}) to {} ({}).",
        mean(least.group.summary.mean),
        name(least),
        mean(most.group.summary.mean),
        name(most)
    ))
}

/// Krippendorff's α beside his own marks.
fn agreement(results: &Results) -> Option<String> {
    let alpha = results.alpha?;
    let verdict = match alpha.alpha {
        a if a >= RELIABLE => "at or above the .800 from which Krippendorff calls data reliable",
        a if a >= TENTATIVE => "between .667 and .800, where Krippendorff allows tentative conclusions only",
        _ => "below the .667 that Krippendorff asks for even of tentative conclusions",
    };
    let interval = interval_words(results, alpha.interval);
    Some(format!("Participants agree with each other by α = {}{interval}: {verdict}.", unit(alpha.alpha)))
}

fn repetition(results: &Results) -> Option<String> {
    let (kappa, interval) = results.kappa?;
    let interval = interval_words(results, interval);
    let kappa = unit(kappa);
    Some(if results.is_inferential() {
        format!("Rating a condition again, participants agree with themselves by κ = {kappa} on average{interval}.")
    } else {
        format!("Rating a condition again, the participant agrees with their first rating by κ = {kappa}.")
    })
}

fn interval_words(results: &Results, interval: Option<Interval>) -> String {
    let level = percent(results.options.bootstrap.level);
    interval.map(|i| format!(" ({level} interval {})", range(Some(i), unit))).unwrap_or_default()
}
