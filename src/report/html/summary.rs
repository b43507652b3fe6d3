//! The summary in plain language. Every sentence is computed: what cannot be said of these results is not said.

use super::{
    effects::{self, Contrast, Course, Evidence},
    health, names,
    numbers::{count, fixed, list, mean, p_is, percent, probability, range, ratio, short_list, unit},
    sittings,
};
use crate::{
    analysis::{
        Link, Note, Part, Results,
        results::{FactorResults, SubjectResults},
        summary::category_values,
    },
    store::ratings::Source,
};

/// Probability below which a difference is told apart from chance.
pub(super) const ALPHA: f64 = 0.05;
/// α from which Krippendorff calls data reliable.
pub(super) const RELIABLE: f64 = 0.8;
/// α from which Krippendorff allows tentative conclusions.
pub(super) const TENTATIVE: f64 = 0.667;

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
    let mut findings: Vec<String> = names::varied(results).map(|factor| finding(results, factor)).collect();
    findings.extend(interactions(results));
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

/// What a factor does.
fn finding(results: &Results, factor: &FactorResults) -> String {
    let course = effects::course(results, factor);
    let Some(evidence) = effects::evidence(results, factor) else {
        let none = if results.is_inferential() { " No test of it could be made." } else { "" };
        return format!("{}.{none}", means(factor, course, !results.is_inferential()));
    };
    let contrast = effects::contrast(results, factor);
    let mut text = if evidence.p < ALPHA {
        format!("{}; {}.", means(factor, course, false), rarity(factor, &evidence))
    } else {
        let how = format!("{}, {}", evidence.name, p_is(evidence.p));
        format!(
            "By {}, {}, and this study cannot tell the levels apart ({how}).",
            names::factor(&factor.name),
            span(factor)
        )
    };
    text.extend(contrast.map(|contrast| size(results, &contrast, evidence.p < ALPHA)));
    text.extend(second_opinion(results, factor, &evidence));
    text
}

/// The means in words, without the full stop; of one participant they are those of these ratings and no more.
fn means(factor: &FactorResults, course: Course, only_these: bool) -> String {
    let the_mean = if only_these { "In these ratings the mean" } else { "The mean rating" };
    let name = names::factor(&factor.name);
    let at = |index: usize| {
        let level = &factor.levels[index];
        let level_name = level.names.first().map_or("", String::as_str);
        (mean(level.summary.mean), names::level(&factor.name, level_name))
    };
    let ((first, first_level), (last, last_level)) = (at(0), at(factor.levels.len() - 1));
    let ends = format!("from {first} at {first_level} to {last} at {last_level}");
    let two = factor.levels.len() == 2;
    match course {
        Course::Rises if two => format!("{the_mean} rises with {name}, {ends}"),
        Course::Falls if two => format!("{the_mean} falls with {name}, {ends}"),
        Course::Rises => format!("{the_mean} rises with {name} at every step, {ends}"),
        Course::Falls => format!("{the_mean} falls with {name} at every step, {ends}"),
        Course::TendsUp => {
            format!("{the_mean} tends to rise with {name}, {ends}, though not at every step{}", turn(factor))
        }
        Course::TendsDown => {
            format!("{the_mean} tends to fall with {name}, {ends}, though not at every step{}", turn(factor))
        }
        Course::None => {
            let (low, high) = least_and_most(factor);
            if low == high {
                return format!("{the_mean} is {low}: the same at all levels of {name}");
            }
            format!(
                "By {name}, {} is highest, {high}, and lowest, {low}",
                if only_these { "the mean of these ratings" } else { "the mean rating" }
            )
        }
    }
}

/// Between which means a factor's levels lie.
fn span(factor: &FactorResults) -> String {
    let (low, high) = least_and_most(factor);
    match (low.split_once(' '), high.split_once(' ')) {
        (Some((least, _)), Some((most, _))) if least == most => format!("mean ratings are {least} at all levels"),
        _ => format!("mean ratings lie between {low} and {high}"),
    }
}

/// Where a tendency has its highest and lowest mean, if that is not at its ends.
fn turn(factor: &FactorResults) -> String {
    let last = factor.levels.len() - 1;
    let (low, high) = least_and_most(factor);
    let inside = |index: usize| index != 0 && index != last;
    match effects::extremes(factor) {
        Some((most, least)) if inside(most) && inside(least) => format!(" (highest {high}, lowest {low})"),
        Some((most, _)) if inside(most) => format!(" (highest {high})"),
        Some((_, least)) if inside(least) => format!(" (lowest {low})"),
        _ => String::new(),
    }
}

/// `0.61 at 45°` for the level with the lowest mean, and with the highest; levels whose means are the same together.
fn least_and_most(factor: &FactorResults) -> (String, String) {
    let describe = |index: usize| {
        let value = factor.levels[index].summary.mean;
        let same: Vec<String> = (factor.levels.iter().filter(|level| (level.summary.mean - value).abs() < 1e-9))
            .map(|level| names::level(&factor.name, level.names.first().map_or("", String::as_str)))
            .collect();
        format!("{} at {}", mean(value), short_list(&same, 4))
    };
    effects::extremes(factor).map_or_else(Default::default, |(most, least)| (describe(least), describe(most)))
}

/// What a small probability means, said correctly.
fn rarity(factor: &FactorResults, evidence: &Evidence) -> String {
    let how = match evidence.p {
        p if p < 0.001 => "hardly ever",
        p if p < 0.01 => "rarely",
        _ => "not often",
    };
    format!(
        "differences as large would {how} come up if {} made none ({}: χ²({}) = {}, {})",
        names::factor(&factor.name),
        evidence.name,
        evidence.df,
        fixed(evidence.chi_squared, 1),
        p_is(evidence.p)
    )
}

/// The size of an effect, as odds or on the latent scale.
fn size(results: &Results, contrast: &Contrast, found: bool) -> String {
    let higher = &contrast.higher;
    if !contrast.estimate.is_finite() {
        let other = contrast.lower.as_deref().unwrap_or_default();
        return format!(" No finite number says how much higher ratings at {higher} are than at {other}.");
    }
    let odds = results.spec.link == Link::Logit;
    let value = |estimate: f64| if odds { ratio(estimate.exp()) } else { fixed(estimate, 2) };
    let interval = match contrast.interval {
        Some(_) if found => format!(" (95\u{a0}% interval {})", range(contrast.interval, value)),
        Some(_) => {
            format!(", and anything from {} fits these data (95\u{a0}% interval)", range(contrast.interval, value))
        }
        None => String::new(),
    };
    let estimate = value(contrast.estimate);
    let text = match (&contrast.lower, odds) {
        (Some(lower), true) => {
            format!(
                " The odds of a higher rating at {higher} are estimated as {estimate} times those at {lower}{interval}."
            )
        }
        (Some(lower), false) => {
            format!(
                " On the latent scale {higher} is estimated as {estimate} standard deviations above {lower}{interval}."
            )
        }
        (None, true) => {
            format!(" One unit more of {higher} multiplies the odds of a higher rating by {estimate}{interval}.")
        }
        (None, false) => {
            format!(" One unit more of {higher} shifts the latent rating by {estimate} standard deviations{interval}.")
        }
    };
    let chosen = if contrast.chosen {
        " These two levels were picked because their means differ most, so their difference is probably overestimated."
    } else {
        ""
    };
    text + chosen
}

/// Where the test that takes each participant as one observation comes to another conclusion.
fn second_opinion(results: &Results, factor: &FactorResults, evidence: &Evidence) -> Option<String> {
    let friedman = factor.friedman.filter(|_| effects::is_clustered(results))?;
    if evidence.name.starts_with("Friedman") || (friedman.p < ALPHA) == (evidence.p < ALPHA) {
        return None;
    }
    let other = if friedman.p < ALPHA { "does tell them apart" } else { "cannot tell the levels apart" };
    Some(format!(
        " Friedman’s test, for which each participant is one observation, {other} ({}): read this with care.",
        p_is(friedman.p)
    ))
}

/// Effects that depend on each other.
fn interactions(results: &Results) -> Vec<String> {
    let Ok(report) = &results.model else { return Vec::new() };
    if !results.is_inferential() || !effects::is_clustered(results) {
        return Vec::new();
    }
    let tested = report.terms.iter().filter(|test| test.part == Part::Location);
    (results.spec.terms.iter().filter(|term| term.variables.len() > 1))
        .filter_map(|term| {
            let test = tested.clone().find(|test| test.term == term.to_string())?;
            let together = list(&term.variables.iter().map(|v| names::factor(v.name())).collect::<Vec<_>>());
            let p = p_is(test.p?);
            Some(if test.p? < ALPHA {
                format!("The effects of {together} depend on each other (likelihood-ratio test, {p}).")
            } else {
                format!("This study cannot tell whether the effects of {together} depend on each other ({p}).")
            })
        })
        .collect()
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

fn interval_words(results: &Results, interval: Option<crate::analysis::bootstrap::Interval>) -> String {
    let level = percent(results.options.bootstrap.level);
    interval.map(|i| format!(" ({level} interval {})", range(Some(i), unit))).unwrap_or_default()
}

fn cautions(source: &Source, results: &Results) -> Vec<String> {
    let mut cautions = Vec::new();
    cautions.extend(simulated(source, results));
    cautions.extend(one_participant(source, results));
    cautions.extend(faults(source));
    cautions.extend(nothing_found(results));
    cautions.extend(about_model(results));
    cautions.extend(names::varied(results).filter_map(|factor| hopeless_pairs(results, factor)));
    cautions.extend(health::oddities(results));
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
pub(super) fn simulated(source: &Source, results: &Results) -> Option<String> {
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
pub(super) fn hopeless_pairs(results: &Results, factor: &FactorResults) -> Option<String> {
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
