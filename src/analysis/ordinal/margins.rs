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
    likelihood_ratios::{TermTest, Withheld},
    model::Model,
    profile::{Quantity, chi_squared_limit, ratio_at_zero},
    terms::{Term, TermPart, Variable},
};
use crate::{
    analysis::{
        counts::Counts,
        frame::find_factor,
        levels::{number_of, values_of},
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
    let counts: &Counts = fitted.frame.counts;
    // The model is the same for all items, and a covariate has one value.
    let left_out = fitted.left_out();
    let x = fitted.x.revalued(&fitted.frame, false, &left_out).ok()?;
    let is_other = |factor: &usize| !factors.contains(factor) && !left_out.contains(factor);
    let others: Vec<usize> = self::factors(fitted).into_iter().filter(is_other).collect();
    let mut by_cell: BTreeMap<Vec<Option<u32>>, BTreeMap<Vec<u32>, u32>> = BTreeMap::new();
    for condition in fitted.frame.conditions() {
        let levels = &counts.conditions[condition as usize];
        let Some(own) = factors.iter().map(|&factor| levels[factor]).collect::<Option<Vec<u32>>>() else { continue };
        let other = others.iter().map(|&factor| levels[factor]).collect();
        by_cell.entry(other).or_default().insert(own, condition);
    }
    let all: BTreeSet<&Vec<u32>> = by_cell.values().flat_map(BTreeMap::keys).collect();
    let is_own = |part: &TermPart| find_factor(counts, &part.variable).is_ok_and(|(own, _)| factors.contains(&own));
    let columns = &x.columns;
    let own_columns: Vec<usize> = (0..columns.len()).filter(|&c| columns[c].parts.iter().all(is_own)).collect();
    let uses = |column: &&Column| column.parts.iter().any(is_own);
    if columns.iter().filter(uses).count() == own_columns.len() {
        let conditions: Vec<u32> = by_cell.values().filter_map(|cell| cell.values().next().copied()).collect();
        let rows = x.matrix(&conditions);
        let at = |own: &Vec<u32>| {
            let mut rows = rows.clone();
            let found: Vec<u32> = by_cell.values().find_map(|cell| cell.get(own).copied()).into_iter().collect();
            for (column, value) in own_columns.iter().zip(x.matrix(&found).select_columns(&own_columns).iter()) {
                rows.column_mut(*column).fill(*value);
            }
            rows
        };
        return (!conditions.is_empty()).then(|| all.iter().map(|own| ((*own).clone(), at(own))).collect());
    }
    let whole: Vec<_> = by_cell.values().filter(|cell| cell.len() == all.len()).collect();
    let rows = |own: &Vec<u32>| x.matrix(&whole.iter().map(|cell| cell[own]).collect::<Vec<_>>());
    (!whole.is_empty()).then(|| all.iter().map(|own| ((*own).clone(), rows(own))).collect())
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
            let (mean, gradient) = expected(model, &x, &values);
            let interval = model.interval_of_mean(mean, &gradient, reach, &values);
            let level = description.levels[level[0] as usize].clone();
            margins.push(Margin { factor: description.name.clone(), level, mean, interval });
        }
    }
    margins
}

/// Returns the mean of the model's expected ratings in some design rows, and its gradient.
fn expected(model: &Model, x: &DMatrix<f64>, values: &[f64]) -> (f64, DVector<f64>) {
    let (mut mean, mut gradient) = (0.0, DVector::zeros(model.thresholds.len() + x.ncols()));
    for row in x.row_iter() {
        let expected = model.expected(&row.iter().copied().collect::<Vec<f64>>(), values);
        mean += expected.mean / x.nrows() as f64;
        gradient += expected.gradient / x.nrows() as f64;
    }
    (mean, gradient)
}

/// Returns the indices of the factors that the model uses as factors or numbers and that vary.
fn factors(fitted: &Fitted) -> BTreeSet<usize> {
    let variables = fitted.spec.terms.iter().flat_map(|term| &term.variables);
    let index = |variable: &Variable| find_factor(fitted.frame.counts, variable).ok();
    variables.filter_map(index).map(|(factor, _)| factor).filter(|f| fitted.frame.levels(*f).len() > 1).collect()
}

/// Returns the comparisons of all pairs of levels: of each factor whose effect is the same everywhere; on average over the
/// other factors if it is not, but has a test; and, for each interaction of two factors, of each factor at each level of the
/// other (simple effects); likewise of the lowest and the highest value of a number at each level of the factor with which it
/// interacts. For a simple effect, the limit is the larger one of the interaction and the main effect.
pub(super) fn comparisons(
    fitted: &Fitted,
    model: &Model,
    limits: &[Result<f64, Withheld>],
    tests: &[TermTest],
) -> Vec<Comparison> {
    let terms = &fitted.spec.terms;
    let mut all = Vec::new();
    for (term, &limit) in terms.iter().zip(limits) {
        if terms.is_marginal(term) {
            let test = tests.iter().find(|test| test.term == *term && test.p.is_some());
            if let ([factor @ Variable::Factor(_)], Some(test)) = (&term.variables[..], test) {
                all.extend(compare(fitted, model, factor, Scope::Average(test), limit));
            }
            continue;
        }
        let with_main = |factor: &Variable| {
            let main = terms.iter().position(|term| term.variables == [factor.clone()]);
            main.map_or(limit, |main| Ok(limit?.max(limits[main]?)))
        };
        match &term.variables[..] {
            [factor @ Variable::Factor(_)] => all.extend(compare(fitted, model, factor, Scope::All, limit)),
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
    /// Everywhere: the effect is the same.
    All,
    /// On average over the factors with which this one interacts, which has this test.
    Average(&'a TermTest),
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
    let ratio = |level: u32, lower: u32| match (scope, column(level), column(lower)) {
        (Scope::All, Some(one), Some(other)) => ratio_at_zero(fitted, Quantity::Difference(one, other)),
        (Scope::All, one, other) => ratio_at_zero(fitted, Quantity::Coefficient(one.or(other)?)),
        (Scope::Average(test), ..) if test.df == 1 => test.chi_squared,
        _ => None,
    };
    // A difference from the baseline is a coefficient.
    let interval = |level: u32, lower: u32| match (scope, column(level), column(lower)) {
        (Scope::All, Some(one), None) => model.coefficients[one].interval,
        (Scope::All, None, Some(other)) => Some(model.coefficients[other].interval?.map(|end| -end)),
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
        let expected = Some(x.map(|x| expected(model, x, &values).0));
        let average = matches!(scope, Scope::Average(_));
        let own = Comparison { expected, average, ..Comparison::new(names, (estimate, implied.unwrap_or(se)), limit) };
        let interval = own.interval.and_then(|_| interval(level, lower)).or(own.interval);
        Some(Comparison { interval, ..own })
    };
    corrected(pairs.into_par_iter().filter_map(compare).collect())
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
    let value = |level: &str| number_of(level).map(|value| if is_inverse { value.recip() } else { value });
    let names = |factor: usize| {
        let mut levels = fitted.frame.levels(factor).to_vec();
        levels.sort_unstable();
        levels.into_iter().map(move |level| &counts.factors[factor].levels[level as usize])
    };
    let mut values: Vec<(f64, &String)> = names(own).filter_map(|name| Some((value(name)?, name))).collect();
    values.sort_by(|a, b| a.0.total_cmp(&b.0));
    let ((low, lowest), (high, highest)) = (*values.first()?, *values.last()?);
    let at_level = |at: &String| {
        let is_own = |part: &TermPart| part.variable == *number || part.level.as_ref() == Some(at);
        let is_there = |column: &Column| {
            column.parts.iter().any(|part| part.variable == *number) && column.parts.iter().all(is_own)
        };
        let weights = fitted.x.columns.iter().map(|column| if is_there(column) { high - low } else { 0.0 });
        let (estimate, se) = estimated(model, &DVector::from_iterator(fitted.x.columns.len(), weights));
        let at = Some((counts.factors[other].name.clone(), at.clone()));
        Comparison::new((&counts.factors[own].name, [highest, lowest].map(Clone::clone), at), (estimate, se), limit)
    };
    Some(corrected(names(other).map(at_level).collect()))
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
