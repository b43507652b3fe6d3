//! What the results say of one factor: the course of its means, the test that counts, the size of the effect.

use super::names;
use crate::{
    analysis::{
        Model, ModelReport, Part, Results, TermTest,
        bootstrap::Interval,
        results::FactorResults,
        terms::{Term, Variable},
    },
    light::random::Z_95,
};

/// Kendall's τ of means and levels from which a course is called a tendency.
const TENDENCY: f64 = 0.7;

/// The course of the means along ordered levels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Course {
    /// Up at every step.
    Rises,
    /// Down at every step.
    Falls,
    /// Up on the whole.
    TendsUp,
    /// Down on the whole.
    TendsDown,
    /// Neither, or the levels have no order.
    None,
}

/// The test whose probability a sentence may rely on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Evidence {
    /// What it is called.
    pub name: &'static str,
    /// χ².
    pub chi_squared: f64,
    /// Degrees of freedom.
    pub df: usize,
    /// Probability.
    pub p: f64,
}

/// A difference on the scale of the link: of two levels, or of one unit of a number.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Contrast {
    /// The level with the higher ratings, or the number's name.
    pub higher: String,
    /// The other level; none for a number.
    pub lower: Option<String>,
    /// Positive for levels; infinite where it has no finite estimate.
    pub estimate: f64,
    /// Its 95 % interval.
    pub interval: Option<Interval>,
    /// Whether the levels were chosen for being the extremes.
    pub chosen: bool,
}

/// The course of a factor's means.
pub(super) fn course(results: &Results, factor: &FactorResults) -> Course {
    let means: Vec<f64> = factor.levels.iter().map(|level| level.summary.mean).collect();
    if means.len() < 2 || !names::is_ordered(&results.measured.counts, &factor.name) {
        return Course::None;
    }
    if means.windows(2).all(|pair| pair[1] > pair[0]) {
        return Course::Rises;
    }
    if means.windows(2).all(|pair| pair[1] < pair[0]) {
        return Course::Falls;
    }
    match kendall(&means) {
        tau if tau >= TENDENCY => Course::TendsUp,
        tau if tau <= -TENDENCY => Course::TendsDown,
        _ => Course::None,
    }
}

/// Kendall's τ-a of values and their positions.
fn kendall(values: &[f64]) -> f64 {
    let mut sum = 0.0;
    for (index, first) in values.iter().enumerate() {
        for second in &values[index + 1..] {
            sum += f64::from(i8::from(second > first) - i8::from(second < first));
        }
    }
    sum / (values.len() * (values.len() - 1) / 2) as f64
}

/// Indices of the levels with the highest and the lowest mean.
pub(super) fn extremes(factor: &FactorResults) -> Option<(usize, usize)> {
    let mean = |index: &usize| factor.levels[*index].summary.mean;
    let indices = || 0..factor.levels.len();
    // Of equal means the first level stands for both.
    let highest = indices().rev().max_by(|l, r| mean(l).total_cmp(&mean(r)))?;
    let lowest = indices().min_by(|l, r| mean(l).total_cmp(&mean(r)))?;
    Some((highest, lowest))
}

/// Whether the model knows which ratings belong together: its probabilities hold for people, not for ratings alone.
pub(super) fn is_clustered(results: &Results) -> bool {
    results.model.as_ref().is_ok_and(|report| report.model.random.is_some())
}

/// The likelihood-ratio test of the factor's main effect, if the model knows which ratings belong together; otherwise
/// Friedman's. None from one participant.
pub(super) fn evidence(results: &Results, factor: &FactorResults) -> Option<Evidence> {
    if !results.is_inferential() {
        return None;
    }
    if is_clustered(results)
        && let Some(test) = likelihood_ratio(results, factor)
        && let (Some(chi_squared), Some(p)) = (test.lr, test.p)
    {
        return Some(Evidence { name: "likelihood-ratio test", chi_squared, df: test.df, p });
    }
    factor.friedman.map(|f| Evidence { name: "Friedman’s test", chi_squared: f.chi_squared, df: f.df, p: f.p })
}

fn likelihood_ratio<'a>(results: &'a Results, factor: &FactorResults) -> Option<&'a TermTest> {
    let report = results.model.as_ref().ok()?;
    let term = main_effect(results, &factor.name)?.to_string();
    report.terms.iter().find(|test| test.part == Part::Location && test.term == term)
}

/// The term of a factor alone, as levels or as a number.
fn main_effect<'a>(results: &'a Results, factor: &str) -> Option<&'a Term> {
    results.spec.terms.iter().find(|term| match term.variables.as_slice() {
        [Variable::Factor(name)] => name == factor,
        [Variable::Number(name)] => name == factor || (name == "inv_n" && factor == "depth"),
        _ => false,
    })
}

/// The size of a factor's effect: the ends of a course, else the extremes; none where an interaction makes it several.
pub(super) fn contrast(results: &Results, factor: &FactorResults) -> Option<Contrast> {
    let report = results.model.as_ref().ok()?;
    let term = main_effect(results, &factor.name)?;
    if results.spec.terms.is_marginal(term) {
        return None;
    }
    match &term.variables[0] {
        Variable::Number(name) => slope(&report.model, term, name),
        Variable::Factor(_) => {
            let ends = (0, factor.levels.len().checked_sub(1)?);
            let chosen = factor.levels.len() > 2 && course(results, factor) == Course::None;
            let (first, second) = if chosen { extremes(factor)? } else { ends };
            difference(report, factor, first, second).map(|contrast| Contrast { chosen, ..contrast })
        }
    }
}

fn slope(model: &Model, term: &Term, name: &str) -> Option<Contrast> {
    let coefficient = model.coefficients.iter().find(|c| c.term == term.to_string())?;
    let (estimate, interval) = (coefficient.estimate, interval_95(coefficient.estimate, coefficient.se));
    Some(Contrast { higher: name.to_owned(), lower: None, estimate, interval, chosen: false })
}

/// The difference of two levels, from their coefficients and the covariance of these.
fn difference(report: &ModelReport, factor: &FactorResults, first: usize, second: usize) -> Option<Contrast> {
    let model = &report.model;
    let own = model.coefficients.iter().filter(|c| c.term == factor.name).count();
    // One level is the baseline; with a column left out, a level without a coefficient need not be it.
    if own + 1 != factor.levels.len() || first == second {
        return None;
    }
    let level = |index: usize| factor.levels[index].names.first().map_or("", String::as_str);
    let find = |index: usize| {
        let name = format!("{}{}", factor.name, level(index));
        model.coefficients.iter().position(|c| c.term == factor.name && c.name == name)
    };
    let (a, b) = (find(first), find(second));
    let value = |index: Option<usize>| index.map_or(0.0, |index| model.coefficients[index].estimate);
    let estimate = value(a) - value(b);
    if estimate.is_nan() {
        return None;
    }
    let covariance = |i: Option<usize>, j: Option<usize>| match (i, j) {
        (Some(i), Some(j)) => {
            let place = |index: usize| model.thresholds.len() + index;
            model.covariance.get((place(i), place(j))).copied().unwrap_or(f64::NAN)
        }
        _ => 0.0,
    };
    let se = (covariance(a, a) + covariance(b, b) - 2.0 * covariance(a, b)).sqrt();
    let (first, second, estimate) = if estimate < 0.0 { (second, first, -estimate) } else { (first, second, estimate) };
    let name = |index: usize| names::level(&factor.name, level(index));
    let (higher, lower) = (name(first), Some(name(second)));
    Some(Contrast { higher, lower, estimate, interval: interval_95(estimate, Some(se)), chosen: false })
}

/// The 95 % interval of an estimate; none without a standard error.
pub(super) fn interval_95(estimate: f64, se: Option<f64>) -> Option<Interval> {
    let reach = Z_95 * se.filter(|se| se.is_finite() && estimate.is_finite())?;
    Some(Interval { low: estimate - reach, high: estimate + reach })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kendall_counts_steps_up_and_down() {
        assert_eq!(kendall(&[1.0, 2.0, 3.0]), 1.0);
        assert_eq!(kendall(&[3.0, 2.0, 2.5, 1.0]), -4.0 / 6.0);
        assert_eq!(kendall(&[1.0, 1.0]), 0.0);
    }
}
