//! What a factor does, in sentences: the course of its means, how rare that would be by chance, how large it is.

use super::{
    effects::{self, Contrast, Course, Evidence},
    names,
    summary::ALPHA,
};
use crate::analysis::{Link, Part, Results, results::FactorResults};
use crate::report::document::numbers::{fixed, list, mean, p_is, range, ratio, short_list};

/// What a factor does.
pub(crate) fn finding(results: &Results, factor: &FactorResults) -> String {
    let course = effects::course(results, factor);
    let Some(evidence) = effects::evidence(results, factor) else {
        let none = if results.is_inferential() { " No test of it could be made." } else { "" };
        return format!("{}.{none}", means(factor, course, !results.is_inferential()));
    };
    // Of many levels that no test tells apart, the two most different ones would look different by themselves.
    let contrast = effects::contrast(results, factor).filter(|contrast| evidence.p < ALPHA || !contrast.chosen);
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
pub(crate) fn interactions(results: &Results) -> Vec<String> {
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
