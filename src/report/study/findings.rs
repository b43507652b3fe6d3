//! Describes the effect of a factor in sentences: the trend of the means, how likely it is by chance, and its size.
//!
//! Rules: the test that leads is the likelihood ratio of a model in which participants may differ in the effect, or else
//! the exact rank test of the participants' means. A difference counts as found only if its p is below [`ALPHA`] and its
//! size has an interval. What is found is said of people; what one participant's trials show is said of that person.

use super::names;
use crate::{
    analysis::{
        Comparison, Link, ModelReport, Results, TermTest,
        rank_tests::PMethod,
        results::FactorResults,
        terms::{Term, Variable},
    },
    report::document::{
        Shown,
        numbers::{fixed, list, mean, p_is, percent, ratio, short_list, with_interval},
    },
};

/// Significance level: if p is below this, a difference counts as more than chance.
pub(super) const ALPHA: f64 = 0.05;

/// The test that a sentence relies on.
pub(super) struct Evidence {
    /// The test and its statistic, such as `likelihood-ratio test: χ²(2) = 7.1`.
    test: String,
    pub p: f64,
    /// Whether p comes from a limited number of simulated studies and cannot be smaller.
    least: bool,
    is_rank_test: bool,
}

/// The size of an effect.
pub(super) struct Size {
    /// A clause without its period.
    text: String,
    /// Whether it has an interval.
    has_interval: bool,
}

/// Describes the effect of a factor.
pub(super) fn finding(results: &Results, factor: &FactorResults) -> String {
    let name = names::factor(&factor.name);
    let Some(evidence) = evidence(results, factor) else {
        return format!("{}. It could not be tested.", means(results, factor));
    };
    let size = size(results, factor, evidence.is_rank_test);
    let p = evidence.p_text();
    if evidence.p < ALPHA && size.as_ref().is_none_or(|size| !size.has_interval) {
        return format!(
            "{}. The size of this effect cannot be estimated with an interval, so no conclusion is drawn ({}, {p}).",
            means(results, factor),
            evidence.test
        );
    }
    let mut text = if evidence.p < ALPHA {
        let whose = if results.is_inferential() { "" } else { " to this participant" };
        // Express a small probability in words.
        let how = match evidence.p {
            p if p < 0.001 => "hardly ever",
            p if p < 0.01 => "rarely",
            _ => "not often",
        };
        format!(
            "{}; if {name} made no difference{whose}, {} would {how} occur ({}, {p}).",
            means(results, factor),
            if evidence.is_rank_test { "orders this consistent" } else { "differences this large" },
            evidence.test
        )
    } else {
        let [(least, low), (most, high)] = least_and_most(factor);
        let span = if least == most {
            format!("mean ratings are {least} at all levels")
        } else {
            format!("mean ratings lie between {least} at {low} and {most} at {high}")
        };
        let what = if results.is_inferential() { "this study" } else { "these trials" };
        format!("By {name}, {span}, and {what} cannot distinguish the levels ({}, {p}).", evidence.test)
    };
    // If no test distinguishes the levels, the two extremes may differ only by chance, so their contrast is not
    // reported.
    let chosen = factor.contrast().1;
    if evidence.p < ALPHA || !chosen {
        text.extend(size.map(|size| format!(" {}.", size.text)));
    }
    if evidence.p < ALPHA && chosen {
        text += " These two levels were chosen because their means differ most, so their difference is probably \
                 overestimated.";
    }
    text.extend(second_opinion(results, factor, &evidence));
    text.extend(people_differ(results, factor, evidence.p < ALPHA));
    text
}

/// Says that participants differ in the effect, if the interval of the deviations excludes 0.
fn people_differ(results: &Results, factor: &FactorResults, found: bool) -> Option<String> {
    let random = results.model.as_ref().ok()?.model.random.as_ref()?;
    let slope = random.slopes.iter().find(|slope| slope.term == Term::factor(&factor.name))?;
    let interval = slope.interval.filter(|interval| interval.low > 0.0)?;
    let (name, interval) = (names::factor(&factor.name), with_interval(Some(interval), |sd| fixed(sd, 2)));
    let so = if found { "" } else { ", so the mean effect may hide opposite effects in individuals" };
    Some(format!(
        " Participants differ in the effect of {name}: their deviations at each level have a standard deviation of {} on the \
         latent scale{interval}{so}.",
        fixed(slope.sd, 2)
    ))
}

impl Evidence {
    fn p_text(&self) -> String {
        let text = p_is(self.p);
        // The smallest simulated probability is a bound.
        if self.least { text.replace('=', "≤") } else { text }
    }
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
    match factor.course() {
        Some(tau) if tau.abs() >= 1.0 => {
            let verb = if tau > 0.0 { "rises" } else { "falls" };
            let steps = if last == 1 { "" } else { " at every step" };
            format!("{the_mean} {verb} with {name}{steps}, {ends}")
        }
        Some(tau) => {
            let verb = if tau > 0.0 { "rise" } else { "fall" };
            // Mention the highest and the lowest mean if they are not at the first or last level.
            let (highest, lowest) = factor.extremes();
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

/// Returns the lowest and the highest mean with their levels, such as `0.61` and `45°`; levels with equal means are
/// joined.
fn least_and_most(factor: &FactorResults) -> [(Shown, String); 2] {
    let (most, least) = factor.extremes();
    [least, most].map(|index| {
        let value = factor.levels[index].summary.mean;
        let same: Vec<Shown> = (factor.levels.iter().filter(|level| (level.summary.mean - value).abs() < 1e-9))
            .map(|level| names::level_of(factor, level))
            .collect();
        (mean(value), short_list(&same, 4))
    })
}

/// True if the model accounts for repeated measures.
pub(super) fn is_clustered(results: &Results) -> bool {
    results.model.as_ref().is_ok_and(|report| report.model.random.is_some())
}

/// Returns whether a factor's likelihood ratio can be relied on: the model has a random effect for each way in which
/// participants may differ, or there is only one participant.
fn is_reliable(results: &Results, factor: &FactorResults, term: &Term) -> bool {
    if !results.is_inferential() {
        return true;
    }
    let Some(random) = results.model.as_ref().ok().and_then(|report| report.model.random.as_ref()) else {
        return false;
    };
    !factor.within || random.slopes.iter().any(|slope| slope.term.contains(term))
}

/// Returns the test that leads: the likelihood ratio of the factor's main effect if it can be relied on, and otherwise
/// Friedman's test.
pub(super) fn evidence(results: &Results, factor: &FactorResults) -> Option<Evidence> {
    let test = main_effect(results, &factor.name)
        .filter(|term| is_reliable(results, factor, term))
        .and_then(|term| likelihood_ratio(results, term));
    if let Some(test) = test
        && let (Some(ratio), Some(p)) = (test.lr, test.p)
    {
        let simulated = match test.draws {
            Some(draws) => format!(" in {draws} simulated studies"),
            None => String::new(),
        };
        let least = test.draws.is_some_and(|draws| p * (1 + draws) as f64 <= 1.0 + 1e-9);
        let test = format!("likelihood-ratio test{simulated}: χ²({}) = {}", test.df, fixed(ratio, 1));
        return Some(Evidence { test, p, least, is_rank_test: false });
    }
    let test = factor.friedman.filter(|_| factor.within && results.is_inferential())?;
    let exact = if test.method == PMethod::ChiSquared { "" } else { "exact " };
    let text = format!("{exact}Friedman test: χ²({}) = {}", test.df, fixed(test.chi_squared, 1));
    Some(Evidence { test: text, p: test.p, least: false, is_rank_test: true })
}

fn likelihood_ratio<'a>(results: &'a Results, term: &Term) -> Option<&'a TermTest> {
    let name = term.to_string();
    results.model.as_ref().ok()?.terms.iter().find(|test| test.term == name)
}

/// Returns the term that contains only this factor, as levels or as a number.
fn main_effect<'a>(results: &'a Results, factor: &str) -> Option<&'a Term> {
    results.spec.terms.iter().find(|term| match term.variables.as_slice() {
        [Variable::Factor(name)] => name == factor,
        [Variable::Number(name)] => name == factor || (name == "inv_n" && factor == "depth"),
        _ => false,
    })
}

/// Describes the size of a factor's effect, between the ends of a trend or otherwise between the extremes: from the
/// model, or as a difference of means if a rank test leads or the model has no such contrast.
fn size(results: &Results, factor: &FactorResults, prefer_means: bool) -> Option<Size> {
    let from_model = || results.model.as_ref().ok().and_then(|report| size_in_model(results, report, factor));
    let from_means = || difference_of_means(factor);
    if prefer_means { from_means().or_else(from_model) } else { from_model().or_else(from_means) }
}

fn size_in_model(results: &Results, report: &ModelReport, factor: &FactorResults) -> Option<Size> {
    let term = main_effect(results, &factor.name)?;
    if results.spec.terms.is_marginal(term) {
        return None;
    }
    let odds = results.spec.link == Link::Logit;
    if let [Variable::Number(name)] = &term.variables[..] {
        let coefficient =
            report.model.coefficients.iter().find(|c| c.parts.iter().map(|part| &part.variable).eq(&term.variables))?;
        let value = |estimate: f64| if odds { ratio(estimate.exp()) } else { fixed(estimate, 2) };
        let interval = with_interval(coefficient.interval, value);
        let estimate = value(coefficient.estimate);
        let text = if odds {
            format!("Each additional unit of {name} multiplies the odds of a higher rating by {estimate}{interval}")
        } else {
            format!(
                "Each additional unit of {name} shifts the latent rating by {estimate} standard deviations{interval}"
            )
        };
        return Some(Size { text, has_interval: coefficient.interval.is_some() });
    }
    let contrast = report.model.contrasts.iter().find(|contrast| contrast.factor == factor.name)?;
    if !contrast.estimate.is_finite() {
        return None;
    }
    // The higher level comes first.
    let flip = contrast.estimate < 0.0;
    let (higher, lower) = if flip { (&contrast.other, &contrast.level) } else { (&contrast.level, &contrast.other) };
    let [higher, lower] = [higher, lower].map(|level| names::level(&factor.name, level));
    let estimate = contrast.estimate.abs();
    let interval = contrast.interval.map(|i| if flip { i.negative() } else { i });
    let value = |estimate: f64| if odds { ratio(estimate.exp()) } else { fixed(estimate, 2) };
    let superiority = |estimate: f64| percent((100.0 * results.spec.link.superiority(estimate)).round() / 100.0);
    let of_pairs = format!(
        "on the latent scale, the model expects a rating at {higher} to exceed one at {lower} in {} of pairs{}",
        superiority(estimate),
        with_interval(interval, superiority)
    );
    let (size, interval_text) = (value(estimate), with_interval(interval, value));
    let text = if odds {
        format!(
            "The odds of a higher rating at {higher} are estimated as {size} times those at {lower}{interval_text}; {of_pairs}"
        )
    } else {
        format!(
            "On the latent scale, {higher} is estimated as {size} standard deviations above {lower}{interval_text}; {of_pairs}"
        )
    };
    Some(Size { text, has_interval: interval.is_some() })
}

/// Describes the mean of the participants' differences between two levels.
fn difference_of_means(factor: &FactorResults) -> Option<Size> {
    let ([first, second], _) = factor.contrast();
    let name = |index: usize| factor.levels[index].names.first().map_or("", String::as_str);
    let is_pair = |level: &str, other: &str| {
        (level == name(first) && other == name(second)) || (level == name(second) && other == name(first))
    };
    let pair = factor.pairs.as_ref()?.pairs.iter().find(|pair| is_pair(&pair.level, &pair.other))?;
    let flip = pair.difference < 0.0;
    let (higher, lower) = if flip { (&pair.other, &pair.level) } else { (&pair.level, &pair.other) };
    let [higher, lower] = [higher, lower].map(|level| names::level(&factor.name, level));
    let interval = pair.interval.map(|i| if flip { i.negative() } else { i });
    let text = format!(
        "The mean rating at {higher} is {} higher than at {lower}{}",
        mean(pair.difference.abs()),
        with_interval(interval, mean)
    );
    Some(Size { text, has_interval: interval.is_some() })
}

/// Adds a caution if the test that treats each participant as one observation disagrees, unless it could not have
/// found anything.
fn second_opinion(results: &Results, factor: &FactorResults, evidence: &Evidence) -> Option<String> {
    let friedman = factor.friedman.filter(|test| results.is_inferential() && test.least_p < ALPHA)?;
    if evidence.is_rank_test || !factor.within || (friedman.p < ALPHA) == (evidence.p < ALPHA) {
        return None;
    }
    let other = if friedman.p < ALPHA { "does distinguish the levels" } else { "cannot distinguish the levels" };
    Some(format!(
        " Friedman’s test, which uses only the order of each participant’s means, {other} ({}). Interpret this with caution.",
        p_is(friedman.p)
    ))
}

/// Says which effects depend on each other.
pub(super) fn interactions(results: &Results) -> Vec<String> {
    let sentence = |term: &Term| {
        let test = likelihood_ratio(results, term)?;
        let together = list(&term.variables.iter().map(|v| names::factor(v.name())).collect::<Vec<_>>());
        let what = if results.is_inferential() { "This study" } else { "These trials" };
        let Some(p) = test.p else {
            let reason = test.withheld.map_or_else(String::new, |reason| format!(": {reason}"));
            return Some(format!(
                "Whether the effects of {together} depend on each other could not be tested{reason}."
            ));
        };
        let simple = simple_effects(results, term);
        Some(match simple {
            _ if p >= ALPHA => {
                format!("{what} cannot tell whether the effects of {together} depend on each other ({}).", p_is(p))
            }
            Some(simple) => format!(
                "The effects of {together} depend on each other (likelihood-ratio test, {}): {simple}.",
                p_is(p)
            ),
            None => format!(
                "The likelihood-ratio test says that the effects of {together} depend on each other ({}), but the size of \
                 this cannot be estimated with an interval, so no conclusion is drawn.",
                p_is(p)
            ),
        })
    };
    let shown = !results.is_inferential() || is_clustered(results);
    results.spec.terms.iter().filter(|term| shown && term.variables.len() > 1).filter_map(sentence).collect()
}

/// Describes how much the last level of the first factor differs from the first level, at up to three levels of the
/// second factor.
fn simple_effects(results: &Results, term: &Term) -> Option<String> {
    const MAX_SHOWN: usize = 3;
    let report = results.model.as_ref().ok()?;
    let [first, second] = &term.variables[..] else { return None };
    let (_, factor) = results.measured.counts.factor(first.name())?;
    let (low, high) = (factor.levels.first()?, factor.levels.last()?);
    let is_shown = |c: &&Comparison| {
        let at_second = c.at.as_ref().is_some_and(|(other, _)| other == second.name());
        at_second && c.factor == first.name() && c.level == *high && c.other == *low
    };
    let part = |comparison: &Comparison| {
        let interval = comparison.interval?;
        let (_, stratum) = comparison.at.as_ref()?;
        let unit = match results.spec.link {
            Link::Logit => "logits",
            Link::Probit => "latent standard deviations",
        };
        Some(format!(
            "at {}, ratings at {} differ from those at {} by {} {unit}{}",
            names::level(second.name(), stratum),
            names::level(first.name(), high),
            names::level(first.name(), low),
            fixed(comparison.estimate, 2),
            with_interval(Some(interval), |x| fixed(x, 2))
        ))
    };
    let parts: Vec<String> = report.comparisons.iter().filter(is_shown).take(MAX_SHOWN).filter_map(part).collect();
    (!parts.is_empty()).then(|| parts.join("; "))
}
