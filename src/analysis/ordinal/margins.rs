//! Estimated marginal means of a model, and comparisons of levels: each is a mean over the cells of the other factors in
//! which all compared levels were rated, so that unequal numbers of ratings do not matter.

use std::collections::{BTreeMap, BTreeSet};

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use serde::Serialize;

use super::{
    design::{Column, is_level},
    estimates::reach,
    fitting::Fitted,
    likelihood_ratios::{TermTest, Withheld, chi_squared_limit},
    model::Model,
    profile::ratio_at_zero,
    terms::{Term, TermPart, Variable},
};
use crate::{
    analysis::{
        frame::{factors_of, find_factor},
        levels::values_of,
    },
    statistics::{Interval, Z_95, holm, normal_two_sided},
};

/// The model's expected rating at a level of a factor, for a participant whose random effects are 0.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Margin {
    pub factor: String,
    pub level: String,
    /// Mean over the cells of the other factors.
    pub mean: f64,
    /// The 95 % interval, which stays on the scale.
    pub interval: Option<Interval>,
}

/// The difference between two levels of a factor on the scale of the link, at a level of another factor or over all.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Comparison {
    pub factor: String,
    pub level: String,
    pub other: String,
    /// The other factor and its level, if the difference depends on it.
    pub at: Option<(String, String)>,
    /// Whether it is a mean over the levels of the factors with which this one interacts.
    pub average: bool,
    /// How much higher `level`, which is the later one in natural order, is rated than `other`.
    #[serde(serialize_with = "crate::text::as_cell")]
    pub estimate: f64,
    /// The model's expected ratings at both levels, for a participant whose random effects are 0; `None` for a number.
    pub expected: Option<[f64; 2]>,
    /// The standard error that p implies, with the normal distribution; p of the only difference of a term is the term's.
    pub se: Option<f64>,
    /// The 95 % interval, with the limit of the term's likelihood ratio: that of the profile where a coefficient has one, and
    /// otherwise symmetric; not corrected for the number of comparisons.
    pub interval: Option<Interval>,
    /// Two-sided probability.
    pub p: Option<f64>,
    /// The probability corrected for all comparisons of this factor (Holm).
    pub p_holm: Option<f64>,
    /// Why there is neither a probability nor an interval: the reason for the test of the factor or the interaction.
    pub withheld: Option<Withheld>,
}

/// A difference of more standard errors than this needs no likelihood ratio.
const CLEAR: f64 = 10.0;
/// If a factor has more pairs of levels than this, each level is compared only with the first one.
const MAX_COMPARISONS: usize = 120;

/// The design rows of each combination of the levels of some factors, in the cells of the other factors.
type Cells = BTreeMap<Vec<u32>, DMatrix<f64>>;

/// Returns, for each combination of the levels of some factors, the design rows in the cells of the other factors of the
/// model, with covariates at their means. If these factors interact with no others, they are all rated cells, because their
/// part of a row is the same in every cell; otherwise, those that were rated in every combination. None if there is no such
/// cell.
fn cells(fitted: &Fitted, factors: &[usize]) -> Option<Cells> {
    // The model is the same for all items, and a covariate has one value.
    let (counts, left_out) = (fitted.frame.counts, fitted.left_out());
    let is_other = |factor: &usize| !factors.contains(factor) && !left_out.contains(factor);
    let others: Vec<usize> = self::factors(fitted).into_iter().filter(is_other).collect();
    // A condition in each cell, and the combinations that were rated there.
    let mut by_cell = BTreeMap::new();
    for condition in fitted.frame.conditions() {
        let levels = &counts.conditions[condition as usize];
        let Some(own) = factors.iter().map(|&factor| levels[factor]).collect::<Option<Vec<u32>>>() else { continue };
        let other: Vec<Option<u32>> = others.iter().map(|&factor| levels[factor]).collect();
        by_cell.entry(other).or_insert_with(|| (levels, BTreeSet::new())).1.insert(own);
    }
    let all: BTreeSet<Vec<u32>> = by_cell.values().flat_map(|(_, rated)| rated.iter().cloned()).collect();
    let is_own = |part: &TermPart| find_factor(counts, &part.variable).is_ok_and(|(own, _)| factors.contains(&own));
    let interacts = |column: &Column| column.parts.iter().any(is_own) && !column.parts.iter().all(is_own);
    if fitted.x.columns.iter().any(interacts) {
        by_cell.retain(|_, (_, rated)| rated.len() == all.len());
    }
    if by_cell.is_empty() {
        return None;
    }
    let rows = |own: Vec<u32>| {
        let mut combinations: Vec<Vec<Option<u32>>> = by_cell.values().map(|(levels, _)| (*levels).clone()).collect();
        for levels in &mut combinations {
            factors.iter().zip(&own).for_each(|(&factor, &level)| levels[factor] = Some(level));
        }
        Some((own, fitted.x.at(&fitted.frame, &combinations, &left_out).ok()?))
    };
    all.into_iter().map(rows).collect()
}

/// Returns the estimated marginal means of every factor that varies in the model, but not of covariates.
pub(super) fn margins(fitted: &Fitted, model: &Model) -> Vec<Margin> {
    let values = values_of(&model.categories);
    let mut margins = Vec::new();
    let left_out = fitted.left_out();
    for factor in factors(fitted).into_iter().filter(|factor| !left_out.contains(factor)) {
        let Some(rows) = cells(fitted, &[factor]) else { continue };
        let description = &fitted.frame.counts.factors[factor];
        // A number has one slope, whatever the number of its values.
        let is_factor = |term: &Term| term.variables.contains(&Variable::Factor(description.name.clone()));
        let own = if fitted.spec.terms.iter().any(is_factor) { rows.len() - 1 } else { 1 };
        let between = usize::from(!fitted.frame.counts.is_within(factor)) * own;
        let reach = reach(fitted, 1 + between);
        for (level, x) in rows {
            let expected = model.expected(&x, &values);
            let interval = model.interval_of_mean(&expected, reach, &values);
            let level = description.levels[level[0] as usize].clone();
            margins.push(Margin { factor: description.name.clone(), level, mean: expected.mean, interval });
        }
    }
    margins
}

/// Returns the indices of the factors that the model uses as factors or numbers and that vary.
fn factors(fitted: &Fitted) -> BTreeSet<usize> {
    let all = fitted.spec.terms.iter().flat_map(|term| factors_of(fitted.frame.counts, term));
    all.filter(|factor| fitted.frame.levels(*factor).len() > 1).collect()
}

/// Returns the comparisons of all pairs of levels: of each factor whose effect is the same everywhere; on average over the
/// other factors if it is not, but has a test; and, for each interaction of two factors, of each factor at each level of the
/// other (simple effects); likewise of the lowest and the highest value of a number at each level of the factor with which it
/// interacts. For a simple effect, the limit is the larger one of the interaction and the main effect.
pub(super) fn comparisons(fitted: &Fitted, model: &Model, tests: &[TermTest]) -> Vec<Comparison> {
    let mut all = Vec::new();
    for test in tests {
        let (limit, is_marginal) = (test.limit(), fitted.spec.terms.is_marginal(&test.term));
        let with_main = |factor: &Variable| {
            let main = tests.iter().find(|main| main.term.variables == [factor.clone()]);
            main.map_or(limit, |main| Ok(limit?.max(main.limit()?)))
        };
        match &test.term.variables[..] {
            [factor @ Variable::Factor(_)] if !is_marginal || test.p.is_some() => {
                all.extend(compare(fitted, model, factor, Scope::Whole(test), limit));
            }
            _ if is_marginal => {}
            [number @ Variable::Number(_), factor @ Variable::Factor(_)]
            | [factor @ Variable::Factor(_), number @ Variable::Number(_)] => {
                all.extend(slopes(fitted, model, number, factor, with_main(number)).unwrap_or_default());
            }
            [first @ Variable::Factor(_), second @ Variable::Factor(_)] => {
                all.extend(compare(fitted, model, first, Scope::At(second), with_main(first)));
                all.extend(compare(fitted, model, second, Scope::At(first), with_main(second)));
            }
            _ => {}
        }
    }
    all
}

/// Where levels are compared.
#[derive(Clone, Copy)]
enum Scope<'a> {
    /// Everywhere, or on average over the factors with which this one interacts. The factor has this test.
    Whole(&'a TermTest),
    /// At each level of another factor.
    At(&'a Variable),
}

fn compare(
    fitted: &Fitted,
    model: &Model,
    factor: &Variable,
    scope: Scope<'_>,
    limit: Result<f64, Withheld>,
) -> Vec<Comparison> {
    let counts = fitted.frame.counts;
    let index = |variable: &Variable| counts.factor(variable.name()).map(|(index, _)| index);
    let other = if let Scope::At(other) = scope { index(other) } else { None };
    let Some(own) = index(factor) else { return Vec::new() };
    let Some(cells) = cells(fitted, &[own].into_iter().chain(other).collect::<Vec<_>>()) else {
        return Vec::new();
    };
    let mut levels = fitted.frame.levels(own).to_vec();
    // The baseline, which comes first, may be a later one.
    levels.sort_unstable();
    let strata =
        other.map_or_else(|| vec![None], |other| fitted.frame.levels(other).iter().copied().map(Some).collect());
    let name = |factor: usize, level: u32| counts.factors[factor].levels[level as usize].clone();
    let values = values_of(&model.categories);
    let rows = |level: u32, stratum: Option<u32>| cells.get(&[level].into_iter().chain(stratum).collect::<Vec<_>>());
    // If a column was dropped, a level without a coefficient is not necessarily the baseline.
    let is_main = |column: &Column| matches!(&column.parts[..], [part] if part.variable == *factor);
    if !matches!(scope, Scope::At(_)) && fitted.x.dropped.iter().any(is_main) {
        return Vec::new();
    }
    let column = |level: u32| {
        let name = name(own, level);
        fitted.x.columns.iter().position(|column| is_level(&column.parts, factor.name(), &name))
    };
    let test = if let Scope::Whole(test) = scope { Some(test) } else { None };
    let average = test.is_some_and(|test| fitted.spec.terms.is_marginal(&test.term));
    let ratio = |level: u32, lower: u32| match (test?, column(level), column(lower)) {
        (test, ..) if average => test.chi_squared.filter(|_| test.df == 1),
        (_, Some(one), other) => ratio_at_zero(fitted, one, other),
        (_, None, other) => ratio_at_zero(fitted, other?, None),
    };
    // A difference from the baseline is a coefficient.
    let interval = |level: u32, lower: u32| match (test.filter(|_| !average)?, column(level), column(lower)) {
        (_, Some(one), None) => model.coefficients[one].interval,
        (_, None, Some(other)) => Some(model.coefficients[other].interval?.map(|end| -end)),
        _ => None,
    };
    let pairs_of = |stratum: Option<u32>| {
        let pairs = |(place, &level): (usize, &u32)| levels[..place].iter().map(move |&lower| (stratum, level, lower));
        levels.iter().enumerate().flat_map(pairs).collect::<Vec<_>>()
    };
    let mut pairs: Vec<(Option<u32>, u32, u32)> = strata.into_iter().flat_map(pairs_of).collect();
    let are_many = pairs.len() > MAX_COMPARISONS;
    pairs.retain(|&(_, _, lower)| !are_many || lower == levels[0]);
    let compare = |(stratum, level, lower): (Option<u32>, u32, u32)| {
        let x = [rows(level, stratum)?, rows(lower, stratum)?];
        let (estimate, se) = estimated(model, &(x[0].row_mean() - x[1].row_mean()).transpose());
        // Where the likelihood ratio is known, the standard error that it implies, so that p and the interval are those of
        // the ratio.
        // A difference of many standard errors is clear without it, and many differences would take too long.
        let is_clear = are_many || estimate.abs() > CLEAR * se;
        let implied = if is_clear { None } else { ratio(level, lower).filter(|ratio| *ratio > 0.01) };
        let implied = implied.map(|ratio| estimate.abs() / ratio.sqrt());
        let at = other.zip(stratum).map(|(other, stratum)| (counts.factors[other].name.clone(), name(other, stratum)));
        let names = (factor.name(), [level, lower].map(|level| name(own, level)), at);
        let expected = Some(x.map(|x| model.expected(x, &values).mean));
        let own = Comparison { expected, average, ..Comparison::new(names, (estimate, implied.unwrap_or(se)), limit) };
        let interval = own.interval.and_then(|_| interval(level, lower)).or(own.interval);
        Some(Comparison { interval, ..own })
    };
    let mut all = corrected(pairs.into_par_iter().filter_map(compare).collect());
    if let Some(TermTest { df: 1, p: p @ Some(_), .. }) = test {
        // The only difference of a term has the term's probability.
        all.iter_mut().filter(|own| own.p.is_some()).for_each(|own| (own.p, own.p_holm) = (*p, *p));
    }
    all
}

/// Compares the lowest and the highest value of a number at each level of a factor, by the number's coefficient there. `None`
/// if the number interacts with another variable too, so that it has no single coefficient there.
fn slopes(
    fitted: &Fitted,
    model: &Model,
    number: &Variable,
    factor: &Variable,
    limit: Result<f64, Withheld>,
) -> Option<Vec<Comparison>> {
    let counts = fitted.frame.counts;
    let others = fitted.spec.terms.iter().flat_map(|term| term.variables.contains(number).then_some(&term.variables));
    if others.flatten().any(|variable| variable != number && variable != factor) {
        return None;
    }
    let ((own, is_inverse), (other, _)) = (find_factor(counts, number).ok()?, find_factor(counts, factor).ok()?);
    let numbers = fitted.frame.numbers(own, is_inverse).ok()?;
    let mut values = fitted.frame.levels(own).to_vec();
    values.sort_by(|a, b| numbers[*a as usize].total_cmp(&numbers[*b as usize]));
    let ends = [*values.last()?, *values.first()?];
    let name = |factor: usize, level: u32| counts.factors[factor].levels[level as usize].clone();
    let at_level = |at: u32| {
        let combination = |value: u32| {
            let mut combination = vec![None; counts.factors.len()];
            (combination[own], combination[other]) = (Some(value), Some(at));
            combination
        };
        // Only the columns of the number differ between both rows.
        let x = fitted.x.at(&fitted.frame, &ends.map(combination), &[]).ok()?;
        let (estimate, se) = estimated(model, &(x.row(0) - x.row(1)).transpose());
        let names = (&*counts.factors[own].name, ends.map(|value| name(own, value)));
        let at = Some((counts.factors[other].name.clone(), name(other, at)));
        Some(Comparison::new((names.0, names.1, at), (estimate, se), limit))
    };
    let mut levels = fitted.frame.levels(other).to_vec();
    levels.sort_unstable();
    Some(corrected(levels.into_iter().filter_map(at_level).collect()))
}

impl Comparison {
    /// Returns the model's expected rating at one of the two levels.
    pub fn expected_at(&self, level: &str) -> Option<f64> {
        let [own, other] = self.expected?;
        let of = [(&self.level, own), (&self.other, other)].into_iter().find(|(name, _)| *name == level);
        of.map(|(_, rating)| rating)
    }

    /// Creates a comparison of two levels, at a level of another factor, from the difference and its standard error.
    /// `limit` is that of the term's likelihood ratio: with few participants, it is larger than that of the χ² distribution.
    fn new(
        (factor, [level, other], at): (&str, [String; 2], Option<(String, String)>),
        (estimate, se): (f64, f64),
        limit: Result<f64, Withheld>,
    ) -> Self {
        let widening = limit.map_or(f64::NAN, |limit| (limit / chi_squared_limit(1)).sqrt());
        let se = Some(se * widening).filter(|se| se.is_finite() && *se > 0.0);
        Self {
            factor: factor.to_owned(),
            level,
            other,
            at,
            average: false,
            estimate,
            expected: None,
            se,
            interval: Interval::around(estimate, se, Z_95),
            p: se.map(|se| normal_two_sided(estimate / se)),
            p_holm: None,
            withheld: limit.err(),
        }
    }
}

/// Returns a weighted sum of the coefficients and its standard error.
fn estimated(model: &Model, weights: &DVector<f64>) -> (f64, f64) {
    let coefficients = model.coefficients.iter().map(|coefficient| &coefficient.estimate);
    let estimate = super::estimates::dot_ignoring_zero_weights(weights.iter(), coefficients);
    let first = model.thresholds.len();
    let covariance = |i: usize, j: usize| model.covariance[(first + i, first + j)];
    let used: Vec<usize> =
        (0..weights.len()).filter(|&i| covariance(i, i).is_finite() || weights[i].abs() > 1e-12).collect();
    let pairs = used.iter().flat_map(|i| used.iter().map(move |j| (*i, *j)));
    (estimate, pairs.map(|(i, j)| weights[i] * weights[j] * covariance(i, j)).sum::<f64>().sqrt())
}

/// Corrects the probabilities of the comparisons of a factor by Holm's method.
fn corrected(mut comparisons: Vec<Comparison>) -> Vec<Comparison> {
    let corrected = holm(&comparisons.iter().map(|comparison| comparison.p).collect::<Vec<_>>());
    comparisons.iter_mut().zip(corrected).for_each(|(comparison, p)| comparison.p_holm = p);
    comparisons
}
