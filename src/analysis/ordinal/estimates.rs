//! Converts the maxima to the scale of the data: estimates, standard errors, notes, and predictions with intervals.

use nalgebra::{DMatrix, DVector};
use serde::Serialize;

use super::{
    clm::{Fit, FitEnd, category_bounds, positive_definite},
    design,
    fitting::{Fitted, fit_counts},
    model::{Coefficient, Model, ModelError, ModelSpec, Note, RandomEffect, RandomSlope, Threshold},
};
use crate::{
    analysis::{counts::Counts, levels::values_of},
    statistics::{Interval, Z_95, normal_two_sided, t_quantile},
};

/// Fits a model.
///
/// # Errors
/// Returns a [`ModelError`] if the data or the terms allow no model. All other problems with the data are reported in
/// the model's notes.
pub fn fit(counts: &Counts, spec: &ModelSpec) -> Result<Model, ModelError> {
    Ok(report(&fit_counts(counts, spec, true)?))
}

/// Converts a fit to a model on the scale of the data.
pub(super) fn report(fitted: &Fitted) -> Model {
    let mut notes = fitted.notes.clone();
    let (mixed, best) = (fitted.usable(), fitted.best());
    note_design(fitted, &mut notes);
    note_separation(fitted, &mut notes);
    note_mixed(fitted, &mut notes);
    if best.end == FitEnd::Stalled {
        notes.push(Note::NotConverged { gradient: best.gradient });
    }
    let (estimates, covariance) = (estimates(fitted), covariance(fitted));
    if covariance.is_none() {
        notes.push(Note::Flat);
    }
    // Standard errors that ignore related ratings are too small.
    let covariance = covariance.filter(|_| !fitted.ignores_people());
    let size = estimates.len();
    let covariance = covariance.unwrap_or_else(|| DMatrix::from_element(size, size, f64::NAN));
    let se = |index: usize| Some(covariance[(index, index)].sqrt()).filter(|se| se.is_finite());
    let thresholds = fitted.frame.categories.len() - 1;
    let coefficient = |column: usize| {
        let (estimate, se) = (estimates[thresholds + column], se(thresholds + column));
        let z = se.map(|se| estimate / se);
        Coefficient {
            name: fitted.x.columns[column].name.clone(),
            term: fitted.term_of(column).clone(),
            parts: fitted.x.columns[column].parts.clone(),
            estimate,
            se,
            z,
            p: z.map(normal_two_sided),
            interval: Interval::around(estimate, se, Z_95),
        }
    };
    Model {
        link: fitted.spec.link,
        method: if mixed.is_some() { "clmm-laplace" } else { "clm" },
        nobs: fitted.frame.total(),
        subjects: fitted.frame.subjects.len(),
        loglik: best.loglik,
        gradient: best.gradient,
        parameters: size,
        thresholds: (fitted.frame.categories.windows(2).enumerate())
            .map(|(j, pair)| Threshold { name: pair.join("|"), estimate: estimates[j], se: se(j) })
            .collect(),
        coefficients: (0..fitted.x.columns.len()).map(coefficient).collect(),
        random: mixed.map(|mixed| random_effect(fitted, mixed, &covariance)),
        categories: fitted.frame.categories.clone(),
        notes,
        covariance,
    }
}

/// Describes the random effects. `covariance` is that of all parameters.
fn random_effect(fitted: &Fitted, mixed: &Fit, covariance: &DMatrix<f64>) -> RandomEffect {
    let part = &fitted.random;
    let size = part.components.len();
    let first = mixed.parameters.len() - part.parameters();
    let psi: Vec<f64> = mixed.parameters.iter().skip(first).zip(part.units()).map(|(psi, unit)| psi / unit).collect();
    // The Cholesky factor, and the place of each of its elements.
    let mut factor = DMatrix::zeros(size, size);
    let mut places = vec![Vec::new(); size];
    for (parameter, (row, column)) in part.elements().enumerate() {
        factor[(row, column)] = psi[parameter];
        places[row].push(parameter);
    }
    let variances = &factor * factor.transpose();
    let sd = |row: usize| variances[(row, row)].sqrt();
    let se = |row: usize| {
        // The derivative of a standard deviation with respect to an element of its row.
        let slope = |parameter: usize| psi[parameter] / sd(row);
        let pairs = places[row].iter().flat_map(|i| places[row].iter().map(move |j| (*i, *j)));
        let variance: f64 = pairs.map(|(i, j)| slope(i) * slope(j) * covariance[(first + i, first + j)]).sum();
        Some(variance.sqrt()).filter(|se| se.is_finite() && sd(row) > 0.0)
    };
    let effect = |row: usize| RandomSlope {
        name: part.components[row].name.clone(),
        term: part.components[row].term.clone(),
        sd: sd(row),
        se: se(row),
    };
    let correlation = |i: usize, j: usize| variances[(i, j)] / (sd(i) * sd(j));
    let correlations =
        part.correlated.then(|| (0..size).map(|i| (0..size).map(|j| correlation(i, j)).collect()).collect());
    let slopes = size - usize::from(part.is_crossed());
    RandomEffect {
        sd: sd(0),
        se: se(0),
        slopes: (1..slopes).map(effect).collect(),
        items: (slopes..size).map(effect).next(),
        correlations,
    }
}

/// Returns the matrix that converts the estimates of the search to the scale of the data.
fn to_data_scale(fitted: &Fitted) -> DMatrix<f64> {
    let (thresholds, size) = (fitted.frame.categories.len() - 1, fitted.best().parameters.len());
    let mut to_data_scale = design::to_data_scale(&fitted.standard, thresholds, size);
    for (psi, unit) in (thresholds + fitted.x.columns.len()..size).zip(fitted.random.units()) {
        to_data_scale[(psi, psi)] = unit.recip();
    }
    to_data_scale
}

/// Returns the estimates of all parameters on the scale of the data. A parameter without a finite estimate has the value
/// at which the search ended.
pub(super) fn finite_estimates(fitted: &Fitted) -> DVector<f64> {
    to_data_scale(fitted) * &fitted.best().parameters
}

/// Returns the estimates of all parameters on the scale of the data. A parameter without a finite estimate is infinite.
fn estimates(fitted: &Fitted) -> DVector<f64> {
    let mut estimates = finite_estimates(fitted);
    for (index, direction) in fitted.infinite() {
        estimates[index] = direction * f64::INFINITY;
    }
    estimates
}

/// Returns the covariance of all parameters on the scale of the data, or `None` if the information matrix cannot be
/// inverted. It is NaN for parameters without a finite estimate.
fn covariance(fitted: &Fitted) -> Option<DMatrix<f64>> {
    let Fit { information, free, .. } = fitted.best();
    // A fit that needed no errors has no information.
    if information.nrows() != free.len() {
        return None;
    }
    // With a singular covariance of correlated effects, the likelihood is flat in a direction that no effect needs.
    let inverse = match information.clone().cholesky() {
        Some(factor) => factor.inverse(),
        None if fitted.random.correlated => positive_definite(information)?.inverse(),
        None => return None,
    };
    let to_data_scale = to_data_scale(fitted).select_columns(free);
    let mut covariance = &to_data_scale * inverse * to_data_scale.transpose();
    for (index, _) in fitted.infinite() {
        covariance.row_mut(index).fill(f64::NAN);
        covariance.column_mut(index).fill(f64::NAN);
    }
    Some(covariance)
}

/// Returns the scalar product. An infinite value counts as 0 if its weight is 0 up to rounding.
pub(super) fn dot_ignoring_zero_weights<'a>(
    weights: impl Iterator<Item = &'a f64>,
    values: impl Iterator<Item = &'a f64>,
) -> f64 {
    weights
        .zip(values)
        .filter(|(weight, value)| value.is_finite() || weight.abs() > 1e-12)
        .map(|(weight, value)| weight * value)
        .sum()
}

fn note_design(fitted: &Fitted, notes: &mut Vec<Note>) {
    let design = &fitted.x;
    for (index, term) in fitted.spec.terms.iter().enumerate() {
        if !design.columns.iter().any(|column| column.term == index) {
            notes.push(Note::AliasedTerm { term: term.to_string(), of: term.clone() });
        } else {
            let dropped = design.dropped.iter().filter(|column| column.term == index);
            notes.extend(dropped.map(|column| Note::Aliased { column: column.name.clone() }));
        }
    }
}

fn note_separation(fitted: &Fitted, notes: &mut Vec<Note>) {
    let thresholds = fitted.frame.categories.len() - 1;
    for (index, direction) in fitted.infinite() {
        notes.push(match index.checked_sub(thresholds) {
            None => Note::SeparatedThreshold { threshold: fitted.frame.categories[index..index + 2].join("|") },
            Some(column) => Note::Separation {
                coefficient: fitted.x.columns[column].name.clone(),
                term: fitted.term_of(column).to_string(),
                positive: direction > 0.0,
            },
        });
    }
}

fn note_mixed(fitted: &Fitted, notes: &mut Vec<Note>) {
    notes.extend(fitted.ignores_people().then_some(Note::NoMixedModel));
    let part = &fitted.random;
    let Some(mixed) = fitted.usable().filter(|_| part.correlated) else { return };
    let psi = &mixed.parameters.as_slice()[mixed.parameters.len() - part.parameters()..];
    // The pivots of the covariance: the standard deviation of each effect given the ones before it.
    let mut pivots = part.elements().zip(psi).filter(|((row, column), _)| row == column);
    notes.extend(pivots.any(|(_, pivot)| pivot.abs() < 1e-2).then_some(Note::SingularCovariance));
}

/// The ratings that a model predicts for one condition. A mixed model predicts the ratings of an average participant,
/// with u = 0.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Prediction {
    /// Names of the levels, in the order of the factors; a missing value has an empty name.
    pub names: Vec<String>,
    /// Probability of each category that has ratings, in the order of [`Model::categories`].
    pub probabilities: Vec<f64>,
    /// Mean rating. A category counts as its number or, if the categories are not numbers, as its position, starting at
    /// 0.
    pub mean: f64,
    /// The 95 % interval of the mean by the delta method, which stays on the scale; `None` if a coefficient has no finite
    /// estimate.
    pub interval: Option<Interval>,
}

/// Returns a model's predictions for every condition on which it was fitted.
pub(super) fn predictions(fitted: &Fitted, model: &Model) -> Vec<Prediction> {
    let values = values_of(&model.categories);
    let conditions = fitted.frame.conditions();
    let x = fitted.x.matrix(&conditions);
    let reach = reach(fitted, 1);
    let predict = |(index, &condition): (usize, &u32)| {
        let expected = model.expected(&x.rows(index, 1).into_owned(), &values);
        let interval = model.interval_of_mean(&expected, reach, &values);
        let Expected { probabilities, mean, .. } = expected;
        let names = fitted.frame.counts.level_names(condition).into_iter().map(str::to_owned).collect();
        Prediction { names, probabilities, mean, interval }
    };
    conditions.iter().enumerate().map(predict).collect()
}

/// What a model expects of a participant whose random effects are 0, on average over some conditions.
pub(super) struct Expected {
    /// Probability of each category.
    pub probabilities: Vec<f64>,
    /// Mean rating.
    pub mean: f64,
    /// Gradient of the mean with respect to the thresholds and the coefficients.
    pub gradient: DVector<f64>,
}

impl Model {
    /// Returns what the model expects on average over some rows of the design. `values` are the numbers of the categories.
    pub(super) fn expected(&self, x: &DMatrix<f64>, values: &[f64]) -> Expected {
        let (n, thresholds) = (x.nrows() as f64, self.thresholds.len());
        let (mut probabilities, mut mean) = (vec![0.0; values.len()], 0.0);
        let mut gradient = DVector::zeros(thresholds + x.ncols());
        for row in x.row_iter() {
            let coefficients = self.coefficients.iter().map(|coefficient| &coefficient.estimate);
            let location = dot_ignoring_zero_weights(row.iter(), coefficients);
            let bounds: Vec<f64> = self.thresholds.iter().map(|threshold| threshold.estimate - location).collect();
            let mut own = 0.0;
            for (category, value) in values.iter().enumerate() {
                let (a, b) = category_bounds(&bounds, category);
                let p = self.link.between(a, b);
                probabilities[category] += p / n;
                own += p * value;
            }
            mean += own / n;
            // If the bound between two categories rises, the mean falls in proportion to the step between them.
            let by_bound = |(j, bound): (usize, &f64)| -(values[j + 1] - values[j]) * self.link.density(*bound);
            let by_bound = DVector::from_iterator(thresholds, bounds.iter().enumerate().map(by_bound));
            gradient.rows_mut(0, thresholds).axpy(n.recip(), &by_bound, 1.0);
            gradient.rows_mut(thresholds, x.ncols()).axpy(-by_bound.sum() / n, &row.transpose(), 1.0);
        }
        Expected { probabilities, mean, gradient }
    }

    /// Returns the interval of a mean rating from its gradient, on the logit of its place between the ends of the scale,
    /// so that it stays there. `reach` is the number of standard errors to either end.
    pub(super) fn interval_of_mean(&self, expected: &Expected, reach: f64, values: &[f64]) -> Option<Interval> {
        let Expected { mean, gradient, .. } = expected;
        let variance = self.covariance.view((0, 0), (gradient.len(), gradient.len())) * gradient;
        let se = gradient.dot(&variance).sqrt();
        let (low, high) = values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(*v), h.max(*v)));
        let span = high - low;
        let share = (mean - low) / span;
        let half = reach * se / (span * share * (1.0 - share));
        let end = |sign: f64| low + span / (1.0 + (-(share / (1.0 - share)).ln() - sign * half).exp());
        half.is_finite().then(|| Interval { low: end(-1.0), high: end(1.0) })
    }
}

/// Returns the number of standard errors to either end of a 95 % interval of a mean over participants, of whose means
/// `estimated` are estimated: those of maximum likelihood are too small with few participants, as in a normal sample whose
/// variance is divided by n instead of n minus `estimated`.
pub(super) fn reach(fitted: &Fitted, estimated: usize) -> f64 {
    // With items, the mean is over them as well.
    let (_, items) = fitted.random.effects();
    let people = (if items > 0 { items } else { usize::MAX }).min(fitted.frame.subjects.len()) as f64;
    let df = people - estimated as f64;
    if fitted.mixed.is_none() || df < 1.0 { Z_95 } else { (people / df).sqrt() * t_quantile(df) }
}
