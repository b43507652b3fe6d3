//! Describes the effect of a factor in sentences: the trend of the means, how likely it is by chance, and its size.
//!
//! Rules: the test that leads is the likelihood ratio of the model, unless it is withheld because participants may differ in
//! ways for which the model does not allow, or the data are too few; or else the rank test of the participants' means. A difference counts as found only if its
//! p is below [`ALPHA`] and its size has an interval. What is found is said of people; what one participant's trials show is
//! said of that person.

use std::collections::BTreeSet;

use super::names;
use crate::{
    analysis::{
        Comparison, Link, Model, ModelReport, Note, Results, Slopes, TermTest, find_factor, number_of,
        results::FactorResults,
        terms::{Term, Variable},
    },
    report::document::{Shown, count, fixed, list, mean, p_is, ratio, short_list, whole_percent, with_interval},
    statistics::Interval,
};

/// Significance level: if p is below this, a difference counts as more than chance.
pub(super) const ALPHA: f64 = 0.05;

/// The test that a sentence relies on.
pub(super) struct Evidence {
    /// The test and its statistic, such as `likelihood-ratio test: χ²(2) = 7.1`.
    test: String,
    pub p: f64,
    pub is_rank_test: bool,
}

/// The size of an effect.
pub(super) struct Size {
    /// A clause without its period.
    pub text: String,
    /// The interval of the difference.
    interval: Option<Interval>,
    /// Whether it is a difference of means and not one in the model.
    is_of_means: bool,
}

/// Describes the effect of a factor.
pub(super) fn finding(results: &Results, factor: &FactorResults) -> String {
    let name = names::factor(results, &factor.name);
    let evidence = evidence(results, factor);
    let size = evidence.as_ref().and_then(|evidence| size(results, factor, evidence));
    let before = caveat(results, factor, size.as_ref()).unwrap_or_default();
    if is_unknown(factor) {
        let verdict = |evidence: Evidence| verdict(&name, &evidence.test, evidence.p);
        return before + &evidence.map_or_else(|| untested(results, &factor.name), verdict);
    }
    let Some(evidence) = evidence else {
        return format!("{before}{}. {}", means(results, factor), untested(results, &factor.name));
    };
    let p = p_is(evidence.p);
    let is_trend = !evidence.is_rank_test && is_slope(results, &factor.name);
    if evidence.p < ALPHA && size.as_ref().is_none_or(|size| size.interval.is_none()) {
        return format!(
            "{before}{}. The size of this effect cannot be estimated with an interval, so this summary draws no conclusion ({}, {p}).",
            means(results, factor),
            evidence.test
        );
    }
    let mut text = before
        + &if evidence.p < ALPHA {
            let whose = if results.is_inferential() { "" } else { " to this participant" };
            format!(
                "{}; if {name} made no difference{whose}, {} would be unlikely ({}, {p}).",
                means(results, factor),
                match (evidence.is_rank_test, factor.levels.len()) {
                    (true, _) => "orders this consistent",
                    (false, 2) => "a difference this large",
                    (false, _) if is_trend => "a linear trend this steep",
                    (false, _) => "differences this large",
                },
                evidence.test
            )
        } else {
            let who = if results.is_inferential() { "this study" } else { "these trials" };
            let what = if is_trend { "confirm a linear trend" } else { "distinguish the levels" };
            format!("{}, and {who} cannot {what} ({}, {p}).", span(results, factor), evidence.test)
        };
    // If no test distinguishes the levels, the two extremes may differ only by chance, so their contrast is not
    // reported.
    let is_of_levels = !is_trend || size.as_ref().is_some_and(|size| size.is_of_means);
    let chosen = factor.contrast().1 && is_of_levels;
    if evidence.p < ALPHA || !chosen {
        text.extend(size.map(|size| format!(" {}.", size.text)));
    }
    if evidence.p < ALPHA && chosen {
        text += " These two levels were chosen because their means differ most, so their difference is probably \
                 overestimated.";
    }
    text
}

/// True if neither raw nor marginal means can be compared, so that no direction is known.
fn is_unknown(factor: &FactorResults) -> bool {
    factor.marginal.is_none() && !factor.comparable && factor.within
}

/// Says that the raw means cannot be compared, if so; and that they mislead, if the size of the effect is clear.
fn caveat(results: &Results, factor: &FactorResults, size: Option<&Size>) -> Option<String> {
    if factor.marginal.is_none() && !is_unknown(factor) {
        return None;
    }
    let name = names::factor(results, &factor.name);
    let raw = FactorResults { marginal: None, ..factor.clone() };
    let ([first, second], _) = factor.contrast();
    let difference = |means: &[f64]| means[second] - means[first];
    let is_clear = size.and_then(|size| size.interval).is_some_and(|interval| !interval.contains(0.0));
    let reason = incomparable(results, factor);
    Some(if is_clear && difference(&raw.means()) * difference(&factor.means()) < 0.0 {
        format!(
            "The raw means by {name} mislead ({} and {}): {reason}, and {} the order is the opposite. ",
            mean_at(results, &raw, first),
            mean_at(results, &raw, second),
            if factor.within { "within participants" } else { "in the model" }
        )
    } else {
        format!("The raw means by {name} are not comparable: {reason}. ")
    })
}

/// Says why the raw means of a factor cannot be compared: other variables differ between its levels, or people lack levels.
fn incomparable(results: &Results, factor: &FactorResults) -> String {
    let (counts, lacking) = (results.modeled(), factor.matched.incomplete.len());
    let differing = |own: usize| -> Vec<String> {
        let name = |other: usize| {
            let name = &counts.factors[other].name;
            let is_tied = counts.determines(own, other) || counts.determines(other, own);
            let what = if results.covariates.contains(name) { "covariate" } else { "factor" };
            (counts.differs_between(other, own) && (results.spec.terms.has_number(name) || !is_tied))
                .then(|| format!("the {what} {}", names::factor(results, name)))
        };
        (0..counts.factors.len()).filter_map(name).collect()
    };
    let differing = counts.factor(&factor.name).map_or_else(Vec::new, |(own, _)| differing(own));
    let conditions = if results.measured.counts.factors.len() > 1 { " in the same conditions" } else { "" };
    match lacking {
        n if factor.within && n == results.people() => format!("no participant rated all of its levels{conditions}"),
        n if factor.within && n > 0 => {
            format!("{n} of {} did not rate every level{conditions}", count(results.people() as u64, "participant"))
        }
        _ if !differing.is_empty() => {
            let differ = if differing.len() == 1 { "differs" } else { "differ" };
            format!("{} {differ} between its levels", list(&differing))
        }
        _ if factor.within => format!("not everyone rated all of its levels{conditions}"),
        _ => "participants are not the same at its levels, and the model has another order".to_owned(),
    }
}

/// Says whether ratings depend on something, without a size.
pub(super) fn verdict(name: &str, test: &str, p: f64) -> String {
    let verdict = if p < ALPHA { "Ratings depend on" } else { "This study cannot tell whether ratings depend on" };
    format!("{verdict} {name} ({test}, {}).", p_is(p))
}

/// Returns why the model does not test a factor or covariate, if it does not.
pub(super) fn reason(results: &Results, factor: &str) -> Option<String> {
    if let Err(error) = &results.model {
        return Some(format!("there is no model ({error})"));
    }
    let Some(term) = main_effect(results, factor) else {
        return Some("it is not a term of the model".to_owned());
    };
    let withheld = likelihood_ratio(results, term).and_then(|test| test.withheld).map(|reason| reason.to_string());
    if withheld.is_none() && results.ignores_people() {
        return Some("as requested, the model ignores that ratings by the same participant are related".to_owned());
    }
    let items = "the model has no random slope for it, and rank tests cannot account for items";
    withheld.or_else(|| results.spec.items.as_ref().map(|_| items.to_owned()))
}

/// Says why a factor or covariate could not be tested.
pub(super) fn untested(results: &Results, factor: &str) -> String {
    let name = names::factor(results, factor);
    let nothing = || format!("no participant has comparable ratings at every level of {name}");
    let reason = reason(results, factor).unwrap_or_else(nothing);
    format!("The effect of {name} could not be tested: {reason}.")
}

/// Returns the mean at a level, such as `1.20 at 45°`.
fn mean_at(results: &Results, factor: &FactorResults, level: usize) -> String {
    format!("{} at {}", mean(factor.means()[level]), names::level_of(results, factor, &factor.levels[level]))
}

/// Describes the means in a sentence without its period. For a single participant, the sentence describes only these
/// ratings.
fn means(results: &Results, factor: &FactorResults) -> String {
    let name = names::factor(results, &factor.name);
    let the_mean = match (&factor.marginal, results.is_inferential()) {
        (Some(_), _) => "The rating that the model expects",
        (None, true) => "The mean rating",
        (None, false) => "In these ratings, the mean",
    };
    let last = factor.levels.len() - 1;
    let ends = || format!("from {} to {}", mean_at(results, factor, 0), mean_at(results, factor, last));
    match factor.course() {
        Some(tau) if tau.abs() >= 1.0 => {
            let verb = if tau > 0.0 { "rises" } else { "falls" };
            let steps = if last == 1 { "" } else { " at every step" };
            format!("{the_mean} {verb} with {name}{steps}, {}", ends())
        }
        Some(tau) => {
            let verb = if tau > 0.0 { "rise" } else { "fall" };
            format!("{the_mean} tends to {verb} with {name}, {}, though not at every step", ends())
        }
        None => span(results, factor),
    }
}

/// Describes the means without a direction.
fn span(results: &Results, factor: &FactorResults) -> String {
    let ratings = match (&factor.marginal, results.is_inferential()) {
        (Some(_), _) => "the ratings that the model expects",
        (None, true) => "mean ratings",
        (None, false) => "the means of these ratings",
    };
    let [(least, low), (most, high)] = least_and_most(results, factor);
    let span = match factor.levels.len() {
        _ if low == high => format!("are {least} at all levels"),
        2 => format!("are {} and {}", mean_at(results, factor, 0), mean_at(results, factor, 1)),
        // A slope is the same at every level.
        _ if is_slope(results, &factor.name) => format!("lie between {least} and {most}"),
        _ => format!("lie between {least} (at {low}) and {most} (at {high})"),
    };
    format!("By {}, {ratings} {span}", names::factor(results, &factor.name))
}

/// True if the model has the slope of a factor's numbers, and not the differences between its levels.
pub(super) fn is_slope(results: &Results, name: &str) -> bool {
    main_effect(results, name).is_some_and(|term| matches!(term.variables[..], [Variable::Number(_)]))
}

/// Returns the lowest and the highest mean with their levels, such as `0.61` and `45°`; levels with equal means are
/// joined.
fn least_and_most(results: &Results, factor: &FactorResults) -> [(Shown, String); 2] {
    let (most, least) = factor.extremes();
    let means = factor.means();
    [least, most].map(|index| {
        let same = factor.levels.iter().zip(&means).filter(|(_, value)| **value == means[index]);
        let same: Vec<Shown> = same.map(|(level, _)| names::level_of(results, factor, level)).collect();
        (mean(means[index]), short_list(&same, 4))
    })
}

/// True if the model accounts for repeated measures, or there are none.
pub(super) fn is_clustered(results: &Results) -> bool {
    let accounts = |model: &Model| !model.notes.contains(&Note::NoMixedModel);
    !results.ignores_people() && results.model.as_ref().is_ok_and(|report| accounts(&report.model))
}

/// Returns the likelihood ratio of a main effect, and its p, if it is not withheld and can be relied on: the model allows for all
/// ways in which participants may differ, unless the user said otherwise, or there is only one participant. `within`: it
/// varies within participants.
pub(super) fn in_model<'a>(results: &'a Results, name: &str, within: bool) -> Option<(&'a TermTest, f64)> {
    let allows = !within || results.spec.slopes != Slopes::None;
    let is_reliable = !results.is_inferential() || is_clustered(results) && allows;
    let test = likelihood_ratio(results, main_effect(results, name).filter(|_| is_reliable)?)?;
    Some((test, test.p?))
}

/// Returns the test that leads: the likelihood ratio of the factor's main effect if it can be relied on, and otherwise
/// Friedman's test.
pub(super) fn evidence(results: &Results, factor: &FactorResults) -> Option<Evidence> {
    if let Some((test, p)) = in_model(results, &factor.name, factor.within) {
        return Some(Evidence { test: ratio_test(test), p, is_rank_test: false });
    }
    let test = factor.friedman.filter(|_| factor.within && results.is_inferential())?;
    let name = if test.is_exact { "exact Friedman test" } else { "Friedman test" };
    let text = format!("{name}: χ²({}) = {}", test.df, fixed(test.chi_squared, 1));
    Some(Evidence { test: text, p: test.p, is_rank_test: true })
}

/// Returns the test with its statistic.
pub(super) fn ratio_test(test: &TermTest) -> String {
    let simulated = test.draws.map_or_else(String::new, |draws| format!(", p from {draws} simulated studies"));
    format!("likelihood-ratio test{simulated}: χ²({}) = {}", test.df, fixed(test.chi_squared, 1))
}

fn likelihood_ratio<'a>(results: &'a Results, term: &Term) -> Option<&'a TermTest> {
    results.model.as_ref().ok()?.terms.iter().find(|test| test.term == *term)
}

/// Returns the term that contains only this factor, as levels or as a number.
pub(super) fn main_effect<'a>(results: &'a Results, factor: &str) -> Option<&'a Term> {
    results.spec.terms.iter().find(|term| match term.variables.as_slice() {
        [Variable::Factor(name)] => name == factor,
        [Variable::Number(name)] => name == factor || (name == "inv_n" && factor == "depth"),
        _ => false,
    })
}

/// Describes the size of a factor's effect, between the ends of a trend or otherwise between the extremes: from the
/// model, or as a difference of means if a rank test leads or the model has no such contrast.
fn size(results: &Results, factor: &FactorResults, evidence: &Evidence) -> Option<Size> {
    let from_model = || results.model.as_ref().ok().and_then(|report| size_in_model(results, report, factor));
    let from_means = || difference_of_means(results, factor, evidence);
    if evidence.is_rank_test { from_means().or_else(from_model) } else { from_model().or_else(from_means) }
}

/// True if the size of a factor's effect is a difference of means with an interval.
pub(super) fn has_interval_of_means(results: &Results, factor: &FactorResults) -> bool {
    let size = evidence(results, factor).and_then(|evidence| size(results, factor, &evidence));
    size.is_some_and(|size| size.is_of_means && size.interval.is_some())
}

fn size_in_model(results: &Results, report: &ModelReport, factor: &FactorResults) -> Option<Size> {
    let term = main_effect(results, &factor.name)?;
    let is_average = results.spec.terms.is_marginal(term);
    if let [Variable::Number(_)] = &term.variables[..] {
        return if is_average { None } else { over_range(results, report, term) };
    }
    let pair = factor.contrast().0.map(|level| &factor.levels[level].names[0]);
    let is_own = |c: &&Comparison| {
        let is_of_factor = c.factor == factor.name && c.at.is_none() && c.average == is_average;
        is_of_factor && pair.contains(&&c.level) && pair.contains(&&c.other)
    };
    let contrast = report.comparisons.iter().find(is_own)?;
    if !contrast.estimate.is_finite() {
        return None;
    }
    let (estimate, interval) = (contrast.estimate, contrast.interval);
    let ([first, second], _) = factor.contrast();
    let means = factor.means();
    if estimate * (means[second] - means[first]) < 0.0 {
        // A sentence has one direction. A small difference may have another one in the model.
        return None;
    }
    let [later, earlier] = [&contrast.level, &contrast.other].map(|level| names::level(results, &factor.name, level));
    let value = |estimate: f64| on_scale(results, estimate);
    let superiority = |estimate: f64| {
        let share = results.spec.link.superiority(estimate);
        // Only an infinite difference is one in all pairs.
        whole_percent(if estimate.is_finite() { share.clamp(1e-6, 1.0 - 1e-6) } else { share })
    };
    let of_pairs = format!(
        "the latent response at {later} exceeds that at {earlier} in an estimated {} of pairs{}",
        superiority(estimate),
        with_interval(interval, superiority)
    );
    let (size, interval_text) = (value(estimate), with_interval(interval, value));
    let text = match results.spec.link {
        Link::Logit => format!(
            "the odds of a higher rating at {later} are an estimated {size} times those at {earlier}{interval_text}; {of_pairs}"
        ),
        Link::Probit => format!(
            "on the latent scale, {later} minus {earlier} is an estimated {size} standard deviations{interval_text}; {of_pairs}"
        ),
    };
    let text = if is_average { format!("on average over {}, {text}", partners(results, term)) } else { text };
    Some(Size { text: names::capitalized(&text), interval, is_of_means: false })
}

/// Lists the factors and covariates with which a term interacts.
fn partners(results: &Results, term: &Term) -> String {
    let larger = results.spec.terms.iter().filter(|larger| larger.contains(term));
    let others = larger.flat_map(|larger| &larger.variables).filter(|variable| !term.variables.contains(variable));
    let others: BTreeSet<String> = others.map(|variable| names::factor(results, variable.name())).collect();
    list(&Vec::from_iter(others))
}

/// Returns the range of a number, and a clause that begins a sentence about its effect from the lowest to the highest value, so
/// that its unit does not matter.
pub(super) fn range_of(results: &Results, variable: &Variable) -> Option<(f64, String)> {
    let counts = results.modeled();
    let (index, is_inverse) = find_factor(counts, variable).ok()?;
    let factor = &counts.factors[index];
    let number = |level: &String| number_of(level).map(|x| if is_inverse { x.recip() } else { x });
    let mut levels: Vec<(f64, &String)> = factor.levels.iter().filter_map(|l| Some((number(l)?, l))).collect();
    levels.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (first, last) = (levels.first()?, levels.last()?);
    let name = names::factor(results, &factor.name);
    let [low, high] =
        [first, last].map(|(_, level)| crate::report::names::rounded_level(results, &factor.name, level, 4));
    let what = match results.spec.link {
        Link::Logit => "the odds of a higher rating are multiplied by",
        Link::Probit => "the latent response shifts, in standard deviations, by",
    };
    Some((last.0 - first.0, format!("From {name} {low} to {high}, {what}")))
}

/// Describes the effect of a number over its range.
pub(super) fn over_range(results: &Results, report: &ModelReport, term: &Term) -> Option<Size> {
    let coefficient =
        report.model.coefficients.iter().find(|c| c.parts.iter().map(|part| &part.variable).eq(&term.variables))?;
    let (range, what) = range_of(results, term.variables.first()?)?;
    let value = |estimate: f64| on_scale(results, estimate);
    let interval = coefficient.interval.map(|i| Interval { low: range * i.low, high: range * i.high });
    let text = format!("{what} {}{}", value(range * coefficient.estimate), with_interval(interval, value));
    Some(Size { text, interval, is_of_means: false })
}

/// Formats a difference on the latent scale: as an odds ratio, or in standard deviations.
pub(super) fn on_scale(results: &Results, difference: f64) -> Shown {
    match results.spec.link {
        Link::Logit => ratio(difference.exp()),
        Link::Probit => fixed(difference, 2),
    }
}

/// Describes the mean of the participants' differences between two levels. Its t interval is given only if it says about 0
/// what the test says.
fn difference_of_means(results: &Results, factor: &FactorResults, evidence: &Evidence) -> Option<Size> {
    let ([earlier, later], _) = factor.contrast();
    let levels = [later, earlier].map(|place| factor.levels[place].names.first().map_or("", String::as_str));
    let (difference, interval) = factor.matched.difference(levels)?;
    let interval = interval.filter(|i| (i.low > 0.0 || i.high < 0.0) == (evidence.p < ALPHA));
    let [later, earlier] = levels.map(|level| names::level(results, &factor.name, level));
    // The means that were told before may be those of other conditions.
    let the = if factor.marginal.is_some() { "In the same conditions, the" } else { "The" };
    let text = match mean(difference).as_ref() {
        "0.00" => format!("{the} mean ratings at {later} and {earlier} differ by less than 0.005"),
        size => {
            format!("{the} mean rating at {later} minus that at {earlier} is {size}{}", with_interval(interval, mean))
        }
    };
    Some(Size { text, interval, is_of_means: true })
}
