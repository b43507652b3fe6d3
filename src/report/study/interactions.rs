//! Describes interactions in sentences: whether effects depend on each other, and the effect of one factor at each level
//! of the other.

use std::collections::BTreeMap;

use super::{
    findings::{
        self, ALPHA, evidence, in_model, is_clustered, is_slope, main_effect, on_scale, over_range, range_of,
        ratio_test, verdict,
    },
    names,
};
use crate::{
    analysis::{
        Comparison, Note, Results, TermTest, find_factor,
        results::{FactorResults, factor_results},
        summary::Group,
        terms::Variable,
    },
    report::document::{either, fixed, list, mean, p_is, with_interval},
    statistics::mean_and_sd,
};

/// Factors whose effects may depend on each other, and the test of it.
pub(super) struct Dependence<'a> {
    /// Names of the factors and covariates.
    pub names: Vec<&'a str>,
    /// The factors. If there are two, the effect of the first is described at each level of the second.
    pub factors: Vec<&'a FactorResults>,
    test: &'a TermTest,
    /// Whether the test is that of the scores.
    by_signs: bool,
    /// Whether the model has this interaction.
    pub is_modeled: bool,
}

impl Dependence<'_> {
    pub fn is_clear(&self) -> bool {
        self.test.p.is_some_and(|p| p < ALPHA)
    }

    /// Returns the test with its statistic.
    fn statistic(&self) -> String {
        let TermTest { df, chi_squared: lr, .. } = self.test;
        match self.by_signs {
            true => format!("score test over the participants’ signs: χ²({df}) = {}", fixed(*lr, 1)),
            false => ratio_test(self.test),
        }
    }

    /// Returns the names of the factors, such as `width and depth`.
    pub fn names(&self, results: &Results) -> String {
        list(&self.names.iter().map(|name| names::factor(results, name)).collect::<Vec<_>>())
    }
}

/// Returns all interactions that were tested: those in the model, and those that it leaves out.
pub(super) fn dependences<'a>(results: &'a Results) -> Vec<Dependence<'a>> {
    let Ok(report) = &results.model else { return Vec::new() };
    let find = |name: &&str| results.factors.iter().find(|factor| factor.name == *name);
    let counts = results.modeled();
    let tested = |test: &'a TermTest, by_signs: bool, is_modeled: bool| {
        let name = |variable: &Variable| Some(counts.factors[find_factor(counts, variable).ok()?.0].name.as_str());
        let names: Vec<&str> = test.term.variables.iter().map(name).collect::<Option<_>>()?;
        let factors = names.iter().filter_map(find).collect();
        Some(Dependence { factors, names, test, by_signs, is_modeled })
    };
    let shown = !results.is_inferential() || is_clustered(results);
    let modeled = report.terms.iter().filter(|test| shown && !test.term.is_main());
    let modeled = modeled.filter_map(|test| tested(test, false, true));
    let left_out = report.interactions.iter().filter_map(|own| tested(&own.test, own.by_signs, false));
    let mut all: Vec<Dependence<'a>> = modeled.chain(left_out).collect();
    // What holds for some of the factors on average says nothing where all of them depend on each other.
    let clear: Vec<Vec<&str>> = all.iter().filter(|found| found.is_clear()).map(|found| found.names.clone()).collect();
    let is_part = |names: &[&str]| clear.iter().any(|c| c.len() > names.len() && names.iter().all(|n| c.contains(n)));
    all.retain(|found| !is_part(&found.names));
    for Dependence { factors, is_modeled, .. } in &mut all {
        // Without the interaction in the model, only effects within participants have tests.
        factors.sort_by_key(|factor| {
            let is_tested = *is_modeled || factor.within;
            (is_slope(results, &factor.name) != *is_modeled, !is_tested, std::cmp::Reverse(factor.levels.len()))
        });
    }
    all
}

/// Returns the term of an interaction with all its parts. What is a number in the model is one here.
pub(super) fn product(results: &Results, names: &[&str]) -> String {
    let in_model = |name: &str| main_effect(results, name)?.variables.first().cloned();
    let variable = |name: &&str| in_model(name).unwrap_or_else(|| Variable::Factor((*name).to_owned()));
    names.iter().map(|name| variable(name).to_string()).collect::<Vec<_>>().join("*")
}

/// Returns whether the effect of a factor or covariate depends on another one, so that it has no single size.
pub(super) fn is_dependent(dependences: &[Dependence<'_>], name: &str) -> bool {
    dependences.iter().any(|found| found.is_clear() && found.names.contains(&name))
}

/// Says which interactions could not be tested; those with the same reason are in one sentence.
pub(super) fn untested(results: &Results, dependences: &[Dependence<'_>]) -> Vec<String> {
    let mut by_reason = BTreeMap::<String, Vec<String>>::new();
    for found in dependences.iter().filter(|found| found.test.p.is_none()) {
        let reason = found.test.withheld.map_or_else(String::new, |reason| format!(": {reason}"));
        let all = by_reason.entry(reason).or_default();
        all.push(format!("{}{}", if all.is_empty() { "" } else { "of " }, found.names(results)));
    }
    let told = |(reason, effects): (String, Vec<String>)| {
        format!("Whether the effects of {} depend on each other could not be tested{reason}.", either(&effects))
    };
    by_reason.into_iter().map(told).collect()
}

/// Describes an interaction: the effect of one factor at each level of the other; `None` if there is nothing to say.
pub(super) fn interaction(results: &Results, found: &Dependence<'_>) -> Option<String> {
    let together = found.names(results);
    let what = if results.is_inferential() { "This study" } else { "These trials" };
    let fact = format!("the effects of {together} depend on each other");
    let p = found.test.p?;
    if p >= ALPHA {
        let text = format!("{what} cannot tell whether {fact} ({}).", p_is(p));
        return found.is_modeled.then_some(text);
    }
    let whose = if results.is_inferential() { "" } else { " for this participant" };
    let mut text = format!("{}{whose} ({}, {}).", names::capitalized(&fact), found.statistic(), p_is(p));
    let number = found.names.iter().find(|name| found.is_modeled && is_slope(results, name));
    match (&found.factors[..], number) {
        ([.., at], Some(number)) if found.names.len() == 2 && !is_slope(results, &at.name) => {
            text.extend(slopes(results, number, at));
        }
        ([of, at], _) if found.names.len() == 2 => {
            text += &simple_effects(results, of, at, found.is_modeled && number.is_none());
        }
        ([.., at], _) if found.names.len() > 2 => {
            let level = &at.levels[0].names[0];
            text += &format!(
                " To describe how, analyze each level of one of them, for example with --only {}={level}.",
                at.name
            );
        }
        _ => {}
    }
    Some(text)
}

/// A factor at one level of another one.
struct Stratum<'a> {
    level: &'a Group,
    /// The factor, with the means that the tests are of.
    of: FactorResults,
    /// The comparison in the model that describes its effect.
    comparison: Option<&'a Comparison>,
}

/// Returns a factor at each level of another one at which it varies. `is_compared`: the model has comparisons of its levels there.
fn strata<'a>(
    results: &'a Results,
    of: &'a FactorResults,
    at: &'a FactorResults,
    is_compared: bool,
) -> Vec<Stratum<'a>> {
    let counts = &results.measured.counts;
    let (Some((own, _)), Some((other, factor))) = (counts.factor(&of.name), counts.factor(&at.name)) else {
        return Vec::new();
    };
    let stratum = |group: &'a Group| {
        let level = factor.levels.iter().position(|level| *level == group.names[0]).map(|level| level as u32);
        let found = factor_results(&results.measured.filtered(|_| true, |levels| levels[other] == level), own);
        let compared = || compared(results, &of.name, at, group).filter(|_| is_compared);
        let margin = |level: &str| {
            if is_compared {
                return compared().find_map(|own| own.expected_at(level));
            }
            let own = found.matched.levels.iter().position(|own| own == level)?;
            Some(mean_and_sd(&found.matched.rows.iter().map(|(_, row)| row[own]).collect::<Vec<_>>()).0)
        };
        let of = found.with_margins(margin, false);
        let pair = of.contrast().0.map(|level| of.levels.get(level).map_or("", |group| &group.names[0]));
        let comparison = compared().find(|own| pair == [&*own.other, &*own.level]);
        (of.levels.len() > 1).then_some(Stratum { level: group, of, comparison })
    };
    at.levels.iter().filter_map(stratum).collect()
}

/// Returns the model's comparisons of the levels of a factor, or of a number, at a level of another factor.
fn compared<'a>(
    results: &'a Results,
    of: &'a str,
    at: &'a FactorResults,
    level: &'a Group,
) -> impl Iterator<Item = &'a Comparison> {
    let is_here = move |(factor, own): &(String, String)| *factor == at.name && *own == level.names[0];
    let all = results.model.iter().flat_map(|report| &report.comparisons);
    all.filter(move |own| own.factor == of && own.at.as_ref().is_some_and(is_here))
}

/// Describes the effect of a factor at each level of another one, with the p of the model's comparisons, if it has such effects.
fn simple_effects(results: &Results, of: &FactorResults, at: &FactorResults, is_compared: bool) -> String {
    let strata = strata(results, of, at, is_compared);
    if strata.is_empty() {
        return String::new();
    }
    let is_raw = |stratum: &Stratum<'_>| stratum.of.marginal.is_none();
    let are_alike = strata.iter().all(is_raw) || !strata.iter().any(is_raw);
    let [name, at_name] = [of, at].map(|factor| names::factor(results, &factor.name));
    let part = |(place, Stratum { level, of: own, comparison }): (usize, &Stratum<'_>)| {
        let mean_at = |index: usize| {
            let level = names::level_of(results, of, &own.levels[index]);
            format!("{} at {name} {level}", mean(own.means()[index]))
        };
        let what = match (own.marginal.is_some(), is_compared) {
            _ if place > 0 && are_alike => "it",
            (true, true) => "the rating that the model expects",
            (true, false) => "the mean rating in the same conditions",
            (false, _) => "the mean rating",
        };
        let [first, second] = own.contrast().0.map(mean_at);
        let p = comparison.and_then(|own| own.p_holm).map_or_else(String::new, |p| format!(" ({})", p_is(p)));
        let level = names::level_of(results, at, level);
        format!("at {at_name} {level}, {what} is {first} and {second}{p}")
    };
    let parts: Vec<String> = strata.iter().enumerate().map(part).collect();
    let mut found = strata.iter().filter_map(|stratum| stratum.comparison);
    let test = match found.clone().find_map(|own| own.withheld) {
        Some(reason) => format!(" These differences have no p: {reason}."),
        None if found.all(|own| own.p_holm.is_none()) => String::new(),
        None => format!(
            " Each p is that of this difference in the model, corrected for all comparisons of {name} with Holm’s method."
        ),
    };
    let raw = if strata.iter().all(is_raw) {
        String::new()
    } else {
        format!(
            " The raw means by {name} are not comparable at every level of {at_name}: not everyone rated all levels in the same \
             conditions."
        )
    };
    let text = names::capitalized(&parts.join("; "));
    format!(" {text}.{raw}{test}")
}

/// Describes the effect of a number over its range at each level of a factor with which it interacts in the model.
fn slopes(results: &Results, number: &str, at: &FactorResults) -> Option<String> {
    let (_, what) = range_of(results, main_effect(results, number)?.variables.first()?)?;
    let value = |estimate: f64| on_scale(results, estimate);
    let at_level = |level: &Group| {
        let found = compared(results, number, at, level).next()?;
        let (factor, level) = (names::factor(results, &at.name), names::level_of(results, at, level));
        Some(format!("{}{} at {factor} {level}", value(found.estimate), with_interval(found.interval, value)))
    };
    let levels: Vec<String> = at.levels.iter().filter_map(at_level).collect();
    (!levels.is_empty()).then(|| format!(" {what} {}.", list(&levels)))
}

/// Describes the effect of a covariate, unless it depends on a factor. Its mean effect over a factor has no size.
pub(super) fn covariate(results: &Results, dependences: &[Dependence<'_>], name: &str) -> Option<String> {
    let report = results.model.as_ref().ok()?;
    let term = main_effect(results, name).filter(|_| !is_dependent(dependences, name))?;
    let shown = names::factor(results, name);
    let Some((test, p)) = in_model(results, name, false) else { return Some(findings::untested(results, name)) };
    let size = over_range(results, report, term).filter(|_| !results.spec.terms.is_marginal(term));
    let size = size.map_or_else(String::new, |size| format!(" {}.", size.text));
    Some(verdict(&shown, &ratio_test(test), p) + &size)
}

/// Returns the names of the factors and covariates of which no effect was found, and of those of which no linear trend was.
pub(super) fn unclear(results: &Results) -> [Vec<String>; 2] {
    let dependences = dependences(results);
    let of_factor = |factor: &FactorResults| {
        let evidence = evidence(results, factor)?;
        let is_linear = !evidence.is_rank_test && is_slope(results, &factor.name);
        Some((factor.name.clone(), evidence.p, is_linear))
    };
    let of_covariate = |name: &String| Some((name.clone(), in_model(results, name, false)?.1, false));
    let notes = results.model.iter().flat_map(|report| &report.model.notes);
    // The effect of a factor includes that of what it determines.
    let nested: Vec<&String> =
        notes.filter_map(|note| if let Note::Nested { factor, .. } = note { Some(factor) } else { None }).collect();
    let is_unclear = |(name, p, _): &(String, f64, bool)| {
        *p >= ALPHA && !is_dependent(&dependences, name) && !nested.contains(&name)
    };
    let all = names::varied(results).filter_map(of_factor).chain(results.covariates.iter().filter_map(of_covariate));
    let unclear: Vec<_> = all.filter(is_unclear).collect();
    [false, true].map(|linear| {
        let own = unclear.iter().filter(|(.., is_linear)| *is_linear == linear);
        own.map(|(name, ..)| names::factor(results, name)).collect()
    })
}
