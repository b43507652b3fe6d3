//! Describes the effect of a factor in sentences: the trend of the means, how likely it is by chance, and its size.

use super::names;
use crate::{
    analysis::{
        Link, Model, ModelReport, Part, Results, TermTest,
        interval::Interval,
        results::FactorResults,
        terms::{Term, Variable},
    },
    report::document::numbers::{fixed, list, mean, p_is, range, ratio, short_list},
};

/// Significance level: if p is below this, a difference counts as more than chance.
pub(super) const ALPHA: f64 = 0.05;
/// Minimum |τ| (Kendall) between means and levels for a trend to be called a tendency.
const TENDENCY: f64 = 0.7;

/// The test that a sentence relies on.
pub(super) struct Evidence {
    name: &'static str,
    chi_squared: f64,
    df: usize,
    pub p: f64,
}

/// A difference on the scale of the link function, between two levels or per unit of a numeric factor.
struct Contrast {
    /// The level with the higher ratings, or the name of the numeric factor.
    higher: String,
    /// The other level; `None` for a numeric factor.
    lower: Option<String>,
    /// The difference; positive for levels, and infinite if there is no finite estimate.
    estimate: f64,
    /// The 95 % interval of the estimate.
    interval: Option<Interval>,
    /// True if the levels were chosen because they are the extremes.
    chosen: bool,
}

/// Describes the effect of a factor.
pub(super) fn finding(results: &Results, factor: &FactorResults) -> String {
    let Some(evidence) = evidence(results, factor) else {
        let none = if results.is_inferential() { " It could not be tested." } else { "" };
        return format!("{}.{none}", means(results, factor));
    };
    let found = evidence.p < ALPHA;
    let name = names::factor(&factor.name);
    let mut text = if found {
        // Express a small probability in words.
        let how = match evidence.p {
            p if p < 0.001 => "hardly ever",
            p if p < 0.01 => "rarely",
            _ => "not often",
        };
        format!(
            "{}; if {name} made no difference, differences this large would {how} occur ({}: χ²({}) = {}, {}).",
            means(results, factor),
            evidence.name,
            evidence.df,
            fixed(evidence.chi_squared, 1),
            p_is(evidence.p)
        )
    } else {
        let [(least, low), (most, high)] = least_and_most(factor);
        let span = if least == most {
            format!("mean ratings are {least} at all levels")
        } else {
            format!("mean ratings lie between {least} at {low} and {most} at {high}")
        };
        let p = p_is(evidence.p);
        format!("By {name}, {span}, and this study cannot distinguish the levels ({}, {p}).", evidence.name)
    };
    // If no test distinguishes the levels, the two extremes may differ only by chance, so their contrast is not
    // reported.
    let contrast = contrast(results, factor).filter(|contrast| found || !contrast.chosen);
    text.extend(contrast.map(|contrast| size(results, &contrast, found)));
    text.extend(second_opinion(results, factor, &evidence));
    text
}

/// Describes the means in a sentence without its period. For a single participant, the sentence describes only these
/// ratings.
fn means(results: &Results, factor: &FactorResults) -> String {
    let name = names::factor(&factor.name);
    let (the_mean, of_these) = if results.is_inferential() {
        ("The mean rating", "the mean rating")
    } else {
        ("In these ratings, the mean", "the mean of these ratings")
    };
    let last = factor.levels.len() - 1;
    let at = |index: usize| {
        let level = &factor.levels[index];
        format!("{} at {}", mean(level.summary.mean), names::level_of(factor, level))
    };
    let ends = format!("from {} to {}", at(0), at(last));
    let [(least, low), (most, high)] = least_and_most(factor);
    match course(results, factor) {
        Some(tau) if tau.abs() >= 1.0 => {
            let verb = if tau > 0.0 { "rises" } else { "falls" };
            let steps = if last == 1 { "" } else { " at every step" };
            format!("{the_mean} {verb} with {name}{steps}, {ends}")
        }
        Some(tau) => {
            let verb = if tau > 0.0 { "rise" } else { "fall" };
            // Mention the highest and the lowest mean if they are not at the first or last level.
            let (highest, lowest) = extremes(factor);
            let inside = |index: usize| (1..last).contains(&index);
            let mut turns: Vec<String> = Vec::new();
            turns.extend(inside(highest).then(|| format!("highest {most} at {high}")));
            turns.extend(inside(lowest).then(|| format!("lowest {least} at {low}")));
            let turns = if turns.is_empty() { String::new() } else { format!(" ({})", turns.join(", ")) };
            format!("{the_mean} tends to {verb} with {name}, {ends}, though not at every step{turns}")
        }
        None if (&least, &low) == (&most, &high) => {
            format!("{the_mean} is {least}: the same at all levels of {name}")
        }
        None => format!("By {name}, {of_these} is highest ({most}) at {high} and lowest ({least}) at {low}"),
    }
}

/// Returns Kendall's τ-a between a factor's means and their positions, if there is at least a tendency; 1 if the mean
/// rises at every step.
fn course(results: &Results, factor: &FactorResults) -> Option<f64> {
    let means: Vec<f64> = factor.levels.iter().map(|level| level.summary.mean).collect();
    let mut sum = 0.0;
    for (index, first) in means.iter().enumerate() {
        for second in &means[index + 1..] {
            sum += f64::from(i8::from(second > first) - i8::from(second < first));
        }
    }
    let tau = sum / (means.len() * (means.len() - 1) / 2) as f64;
    (names::is_ordered(&results.measured.counts, &factor.name) && tau.abs() >= TENDENCY).then_some(tau)
}

/// Returns the indices of the levels with the highest and the lowest mean; among equal means, the first level is
/// chosen.
fn extremes(factor: &FactorResults) -> (usize, usize) {
    let by_mean = |l: &usize, r: &usize| factor.levels[*l].summary.mean.total_cmp(&factor.levels[*r].summary.mean);
    let indices = || 0..factor.levels.len();
    (indices().rev().max_by(by_mean).unwrap_or(0), indices().min_by(by_mean).unwrap_or(0))
}

/// Returns the lowest and the highest mean with their levels, such as `0.61` and `45°`; levels with equal means are
/// joined.
fn least_and_most(factor: &FactorResults) -> [(String, String); 2] {
    let (most, least) = extremes(factor);
    [least, most].map(|index| {
        let value = factor.levels[index].summary.mean;
        let same: Vec<String> = (factor.levels.iter().filter(|level| (level.summary.mean - value).abs() < 1e-9))
            .map(|level| names::level_of(factor, level))
            .collect();
        (mean(value), short_list(&same, 4))
    })
}

/// True if the model accounts for repeated measures, so that its p values generalize to other people.
pub(super) fn is_clustered(results: &Results) -> bool {
    results.model.as_ref().is_ok_and(|report| report.model.random.is_some())
}

/// Returns the likelihood-ratio test of the factor's main effect if the model accounts for repeated measures, and
/// Friedman's test otherwise. `None` for a single participant.
pub(super) fn evidence(results: &Results, factor: &FactorResults) -> Option<Evidence> {
    if !results.is_inferential() {
        return None;
    }
    if is_clustered(results)
        && let Some(test) = main_effect(results, &factor.name).and_then(|term| likelihood_ratio(results, term))
        && let (Some(chi_squared), Some(p)) = (test.lr, test.p)
    {
        return Some(Evidence { name: "likelihood-ratio test", chi_squared, df: test.df, p });
    }
    factor.friedman.map(|f| Evidence { name: "Friedman’s test", chi_squared: f.chi_squared, df: f.df, p: f.p })
}

fn likelihood_ratio<'a>(results: &'a Results, term: &Term) -> Option<&'a TermTest> {
    let name = term.to_string();
    results.model.as_ref().ok()?.terms.iter().find(|test| test.part == Part::Location && test.term == name)
}

/// Returns the term that contains only this factor, as levels or as a number.
fn main_effect<'a>(results: &'a Results, factor: &str) -> Option<&'a Term> {
    results.spec.terms.iter().find(|term| match term.variables.as_slice() {
        [Variable::Factor(name)] => name == factor,
        [Variable::Number(name)] => name == factor || (name == "inv_n" && factor == "depth"),
        _ => false,
    })
}

/// Returns the size of a factor's effect, between the ends of a trend or otherwise between the extremes; `None` if the
/// effect depends on an interaction.
fn contrast(results: &Results, factor: &FactorResults) -> Option<Contrast> {
    let report = results.model.as_ref().ok()?;
    let term = main_effect(results, &factor.name)?;
    if results.spec.terms.is_marginal(term) {
        return None;
    }
    match &term.variables[0] {
        Variable::Number(name) => slope(&report.model, term, name),
        Variable::Factor(_) => {
            let chosen = factor.levels.len() > 2 && course(results, factor).is_none();
            let (first, second) = if chosen { extremes(factor) } else { (0, factor.levels.len() - 1) };
            difference(report, factor, first, second).map(|contrast| Contrast { chosen, ..contrast })
        }
    }
}

fn slope(model: &Model, term: &Term, name: &str) -> Option<Contrast> {
    let coefficient = model.coefficients.iter().find(|c| c.term == term.to_string())?;
    let (estimate, interval) = (coefficient.estimate, Interval::wald(coefficient.estimate, coefficient.se));
    Some(Contrast { higher: name.to_owned(), lower: None, estimate, interval, chosen: false })
}

/// Computes the difference between two levels from their coefficients and the covariance of the coefficients.
fn difference(report: &ModelReport, factor: &FactorResults, first: usize, second: usize) -> Option<Contrast> {
    let model = &report.model;
    let own = model.coefficients.iter().filter(|c| c.term == factor.name).count();
    // One level is the baseline. If a column was dropped, a level without a coefficient is not necessarily the
    // baseline, so the difference is unknown.
    if own + 1 != factor.levels.len() || first == second {
        return None;
    }
    let find = |index: usize| {
        let name = format!("{}{}", factor.name, factor.levels[index].names[0]);
        model.coefficients.iter().position(|c| c.term == factor.name && c.name == name)
    };
    let (a, b) = (find(first), find(second));
    let value = |index: Option<usize>| index.map_or(0.0, |index| model.coefficients[index].estimate);
    let estimate = value(a) - value(b);
    if estimate.is_nan() {
        return None;
    }
    let covariance = |i: Option<usize>, j: Option<usize>| {
        let place = |index: usize| model.thresholds.len() + index;
        let both = i.zip(j).map(|(i, j)| model.covariance.get((place(i), place(j))).copied().unwrap_or(f64::NAN));
        both.unwrap_or_default()
    };
    let se = (covariance(a, a) + covariance(b, b) - 2.0 * covariance(a, b)).sqrt();
    let (first, second, estimate) = if estimate < 0.0 { (second, first, -estimate) } else { (first, second, estimate) };
    let name = |index: usize| names::level_of(factor, &factor.levels[index]);
    let (higher, lower) = (name(first), Some(name(second)));
    Some(Contrast { higher, lower, estimate, interval: Interval::wald(estimate, Some(se)), chosen: false })
}

/// States the size of an effect, as an odds ratio or on the latent scale.
fn size(results: &Results, contrast: &Contrast, found: bool) -> String {
    let higher = &contrast.higher;
    if !contrast.estimate.is_finite() {
        let other = contrast.lower.as_deref().unwrap_or_default();
        return format!(" The difference between ratings at {higher} and at {other} has no finite estimate.");
    }
    let odds = results.spec.link == Link::Logit;
    let value = |estimate: f64| if odds { ratio(estimate.exp()) } else { fixed(estimate, 2) };
    let ends = range(contrast.interval, value);
    let interval = match contrast.interval {
        Some(_) if found => format!(" (95\u{a0}% interval {ends})"),
        Some(_) => format!(", but anything from {ends} is compatible with these data (95\u{a0}% interval)"),
        None => String::new(),
    };
    let estimate = value(contrast.estimate);
    let size = match (&contrast.lower, odds) {
        (Some(lower), true) => {
            format!("The odds of a higher rating at {higher} are estimated as {estimate} times those at {lower}")
        }
        (Some(lower), false) => {
            format!("On the latent scale, {higher} is estimated as {estimate} standard deviations above {lower}")
        }
        (None, true) => {
            format!("Each additional unit of {higher} multiplies the odds of a higher rating by {estimate}")
        }
        (None, false) => {
            format!("Each additional unit of {higher} shifts the latent rating by {estimate} standard deviations")
        }
    };
    let chosen = if contrast.chosen {
        " These two levels were chosen because their means differ most, so their difference is probably overestimated."
    } else {
        ""
    };
    format!(" {size}{interval}.{chosen}")
}

/// Adds a caution if the test that treats each participant as one observation disagrees.
fn second_opinion(results: &Results, factor: &FactorResults, evidence: &Evidence) -> Option<String> {
    let friedman = factor.friedman.filter(|_| is_clustered(results))?;
    if (friedman.p < ALPHA) == (evidence.p < ALPHA) {
        return None;
    }
    let other = if friedman.p < ALPHA { "does distinguish the levels" } else { "cannot distinguish the levels" };
    Some(format!(
        " Friedman’s test, which treats each participant as one observation, {other} ({}). Interpret this with caution.",
        p_is(friedman.p)
    ))
}

/// Says which effects depend on each other.
pub(super) fn interactions(results: &Results) -> Vec<String> {
    let sentence = |term: &Term| {
        let p = likelihood_ratio(results, term)?.p?;
        let together = list(&term.variables.iter().map(|v| names::factor(v.name())).collect::<Vec<_>>());
        Some(if p < ALPHA {
            format!("The effects of {together} depend on each other (likelihood-ratio test, {}).", p_is(p))
        } else {
            format!("This study cannot tell whether the effects of {together} depend on each other ({}).", p_is(p))
        })
    };
    let shown = results.is_inferential() && is_clustered(results);
    results.spec.terms.iter().filter(|term| shown && term.variables.len() > 1).filter_map(sentence).collect()
}
