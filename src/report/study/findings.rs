//! What a factor does, in sentences: the course of its means, how rare that would be by chance, how large it is.

use super::{
    effects::{self, Contrast, Course, Evidence},
    limits::ALPHA,
    names,
};
use crate::{
    analysis::{Link, Part, Results, results::FactorResults},
    report::document::numbers::{fixed, list, mean, p_is, range, ratio, short_list},
};

/// What a factor does.
pub(super) fn finding(results: &Results, factor: &FactorResults) -> String {
    let course = effects::course(results, factor);
    let Some(evidence) = effects::evidence(results, factor) else {
        let none = if results.is_inferential() { " It could not be tested." } else { "" };
        return format!("{}.{none}", means(factor, course, !results.is_inferential()));
    };
    let found = evidence.p < ALPHA;
    let mut text = if found {
        format!("{}; {}.", means(factor, course, false), rarity(factor, &evidence))
    } else {
        format!(
            "By {}, {}, and this study cannot tell the levels apart ({}, {}).",
            names::factor(&factor.name),
            span(factor),
            evidence.name,
            p_is(evidence.p)
        )
    };
    // Of many levels that no test tells apart, the two most different ones would look different by themselves.
    let contrast = effects::contrast(results, factor).filter(|contrast| found || !contrast.chosen);
    text.extend(contrast.map(|contrast| size(results, &contrast, found)));
    text.extend(second_opinion(results, factor, &evidence));
    text
}

/// The means in words, without the full stop; of one participant they are those of these ratings and no more.
fn means(factor: &FactorResults, course: Course, only_these: bool) -> String {
    let name = names::factor(&factor.name);
    let (the_mean, of_these) = if only_these {
        ("In these ratings the mean", "the mean of these ratings")
    } else {
        ("The mean rating", "the mean rating")
    };
    let at = |index: usize| {
        let level = &factor.levels[index];
        format!("{} at {}", mean(level.summary.mean), names::level_of(factor, level))
    };
    let ends = format!("from {} to {}", at(0), at(factor.levels.len() - 1));
    let steps = if factor.levels.len() == 2 { "" } else { " at every step" };
    match course {
        Course::Rises => format!("{the_mean} rises with {name}{steps}, {ends}"),
        Course::Falls => format!("{the_mean} falls with {name}{steps}, {ends}"),
        Course::TendsUp => {
            format!("{the_mean} tends to rise with {name}, {ends}, though not at every step{}", turn(factor))
        }
        Course::TendsDown => {
            format!("{the_mean} tends to fall with {name}, {ends}, though not at every step{}", turn(factor))
        }
        Course::None => {
            let (low, high) = least_and_most(factor);
            if low == high {
                format!("{the_mean} is {low}: the same at all levels of {name}")
            } else {
                format!("By {name}, {of_these} is highest, {high}, and lowest, {low}")
            }
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
    let Some((most, least)) = effects::extremes(factor) else { return String::new() };
    let (low, high) = least_and_most(factor);
    let inside = 1..factor.levels.len() - 1;
    let parts = [(most, format!("highest {high}")), (least, format!("lowest {low}"))];
    let parts: Vec<String> =
        parts.into_iter().filter(|(index, _)| inside.contains(index)).map(|(_, text)| text).collect();
    if parts.is_empty() { String::new() } else { format!(" ({})", parts.join(", ")) }
}

/// `0.61 at 45°` for the level with the lowest mean, and with the highest; levels whose means are the same together.
fn least_and_most(factor: &FactorResults) -> (String, String) {
    let describe = |index: usize| {
        let value = factor.levels[index].summary.mean;
        let same: Vec<String> = (factor.levels.iter().filter(|level| (level.summary.mean - value).abs() < 1e-9))
            .map(|level| names::level_of(factor, level))
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
        "if {} made no difference, differences as large would {how} come up ({}: χ²({}) = {}, {})",
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
    let ends = range(contrast.interval, value);
    let interval = match contrast.interval {
        Some(_) if found => format!(" (95\u{a0}% interval {ends})"),
        Some(_) => format!(", and anything from {ends} fits these data (95\u{a0}% interval)"),
        None => String::new(),
    };
    let estimate = value(contrast.estimate);
    let size = match (&contrast.lower, odds) {
        (Some(lower), true) => {
            format!("The odds of a higher rating at {higher} are estimated as {estimate} times those at {lower}")
        }
        (Some(lower), false) => {
            format!("On the latent scale {higher} is estimated as {estimate} standard deviations above {lower}")
        }
        (None, true) => format!("One unit more of {higher} multiplies the odds of a higher rating by {estimate}"),
        (None, false) => {
            format!("One unit more of {higher} shifts the latent rating by {estimate} standard deviations")
        }
    };
    let chosen = if contrast.chosen {
        " These two levels were picked because their means differ most, so their difference is probably overestimated."
    } else {
        ""
    };
    format!(" {size}{interval}.{chosen}")
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
pub(super) fn interactions(results: &Results) -> Vec<String> {
    let Ok(report) = &results.model else { return Vec::new() };
    if !results.is_inferential() || !effects::is_clustered(results) {
        return Vec::new();
    }
    let sentence = |term: &crate::analysis::terms::Term| {
        let name = term.to_string();
        let p = report.terms.iter().find(|test| test.part == Part::Location && test.term == name)?.p?;
        let together = list(&term.variables.iter().map(|v| names::factor(v.name())).collect::<Vec<_>>());
        Some(if p < ALPHA {
            format!("The effects of {together} depend on each other (likelihood-ratio test, {}).", p_is(p))
        } else {
            format!("This study cannot tell whether the effects of {together} depend on each other ({}).", p_is(p))
        })
    };
    results.spec.terms.iter().filter(|term| term.variables.len() > 1).filter_map(sentence).collect()
}
