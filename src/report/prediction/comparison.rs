//! A criterion fitted to ratings, and how far the order of a prediction is theirs.

use crate::{
    analysis::{
        ModelSpec,
        counts::{Counts, MeasuredBuilder},
        fit,
        rank_tests::ranks,
        terms::Terms,
    },
    vision::{Criterion, VisionError},
};

/// Lesser visibilities count as this one when they are compared with ratings: below half of what is just seen there is
/// nothing to tell apart, and some who see nothing press another key than 0.
pub const LEAST: f64 = 0.5;

/// How a prediction compares with ratings.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// Where one rating gives way to the next, by maximum likelihood.
    pub criterion: Criterion,
    /// Conditions that both have.
    pub conditions: usize,
    /// Ratings of them.
    pub ratings: u64,
    /// Spearman's correlation of visibility and mean rating over conditions.
    pub rank_correlation: Option<f64>,
    /// The same with each participant alone, the mean over participants.
    pub with_subjects: Option<f64>,
    /// What any model could reach of that: the mean over participants of the correlation with the mean of the others,
    /// and with the mean of all (Nili et al. 2014, PLoS Comput. Biol. 10:e1003553). `None` for a single participant.
    pub ceiling: Option<[f64; 2]>,
}

/// Why nothing is predicted of ratings.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PredictionError {
    /// The stimuli are not known.
    #[error("the files bring no definition of an experiment, so nobody knows what was shown")]
    NoDefinition,
    /// It would take too long for a report.
    #[error(
        "{conditions} conditions are more than the {most} that a report predicts; `machband predict {name} --fit` predicts all"
    )]
    TooMany {
        /// Those of the definition.
        conditions: usize,
        /// Those that a report allows.
        most: usize,
        /// The definition.
        name: String,
    },
    /// A stimulus that cannot be seen.
    #[error("the model cannot see the stimuli: {0}")]
    Invisible(#[from] VisionError),
    /// The definition sets a parameter to a value that it cannot have.
    #[error("the definition’s conditions cannot be made: {0}")]
    Conditions(String),
    /// Nothing in common.
    #[error("the ratings have none of the conditions predicted; expected ratings of this experiment")]
    NoCondition,
    /// A factor without a column.
    #[error("the ratings do not record {0}, which the definition varies; expected a column of it")]
    Factor(String),
    /// Another scale.
    #[error("the scale has {0} {noun}; expected the four of the scale 0–3", noun = if *.0 == 1 { "category" } else { "categories" })]
    Categories(usize),
    /// No thresholds can be had.
    #[error("{0}; expected ratings that rise with visibility and use all of the scale")]
    NoFit(String),
}

/// Compares `visibilities`, one for each of the counts' conditions and `None` where it is not predicted, with ratings.
///
/// # Errors
/// Where they have nothing in common, or no criterion can be fitted.
pub(super) fn compare(counts: &Counts, visibilities: &[Option<f64>]) -> Result<Comparison, PredictionError> {
    check_categories(counts)?;
    let predicted = |condition: u32| visibilities.get(condition as usize).copied().flatten();
    let conditions = (0..counts.conditions.len() as u32).filter(|c| predicted(*c).is_some()).count();
    if conditions == 0 {
        return Err(PredictionError::NoCondition);
    }
    let ratings = counts.rows.iter().filter(|row| predicted(row.condition).is_some()).map(|row| row.count).sum();
    let means = means(counts, conditions_of(counts, visibilities));
    let pooled = pooled(&means);
    let model: Vec<f64> = conditions_of(counts, visibilities).map(|(_, visibility)| visibility).collect();
    let each: Vec<f64> = means.iter().filter_map(|mean| rank_correlation(mean, &model)).collect();
    Ok(Comparison {
        criterion: criterion(counts, predicted)?,
        conditions,
        ratings,
        rank_correlation: rank_correlation(&pooled, &model),
        with_subjects: mean(&each),
        ceiling: ceiling(&means, &pooled),
    })
}

/// Checks that ratings are on a scale that a criterion has thresholds for.
pub(super) fn check_categories(counts: &Counts) -> Result<(), PredictionError> {
    match counts.categories.len() {
        4 => Ok(()),
        other => Err(PredictionError::Categories(other)),
    }
}

fn conditions_of<'a>(counts: &'a Counts, visibilities: &'a [Option<f64>]) -> impl Iterator<Item = (u32, f64)> + 'a {
    (0..counts.conditions.len() as u32).filter_map(|c| Some((c, visibilities.get(c as usize).copied().flatten()?)))
}

fn criterion(counts: &Counts, predicted: impl Fn(u32) -> Option<f64>) -> Result<Criterion, PredictionError> {
    let fail = |error: &dyn std::fmt::Display| PredictionError::NoFit(error.to_string());
    let mut builder = MeasuredBuilder::new(&["visibility"]).with_categories(&counts.categories);
    for row in &counts.rows {
        let Some(visibility) = predicted(row.condition) else { continue };
        let log = visibility.max(LEAST).ln().to_string();
        let (subject, rating) = (&counts.subjects[row.subject as usize], &counts.categories[row.rating as usize]);
        builder.add_counts(subject, &[log], rating, row.count).map_err(|error| fail(&error))?;
    }
    let terms = Terms::parse("num:visibility").map_err(|error| fail(&error))?;
    let model = fit(&builder.finish().counts, &ModelSpec::new(terms)).map_err(|error| fail(&error))?;
    let slope = model.coefficients.first().map_or(f64::NAN, |coefficient| coefficient.estimate);
    if !(slope.is_finite() && slope > 0.0) {
        return Err(PredictionError::NoFit(format!("ratings change by {slope:.3} with the logarithm of visibility")));
    }
    let thresholds: Vec<f64> = model.thresholds.iter().map(|threshold| (threshold.estimate / slope).exp()).collect();
    match <[f64; 3]>::try_from(thresholds) {
        Ok(thresholds) if thresholds.iter().all(|t| t.is_finite() && *t > 0.0) => {
            Ok(Criterion { thresholds, spread: 1.0 / slope })
        }
        _ => Err(PredictionError::NoFit("some rating was never given".to_owned())),
    }
}

/// Mean rating of every participant in every condition; NaN where there is none.
fn means(counts: &Counts, conditions: impl Iterator<Item = (u32, f64)>) -> Vec<Vec<f64>> {
    let places: Vec<u32> = conditions.map(|(condition, _)| condition).collect();
    let mut sums = vec![vec![(0.0, 0.0); places.len()]; counts.subjects.len()];
    for row in &counts.rows {
        if let Ok(place) = places.binary_search(&row.condition) {
            let (sum, n) = &mut sums[row.subject as usize][place];
            *sum += f64::from(row.rating) * row.count as f64;
            *n += row.count as f64;
        }
    }
    sums.into_iter().map(|cells| cells.into_iter().map(|(sum, n)| sum / n).collect()).collect()
}

/// Mean over participants, of those who have it.
fn pooled(means: &[Vec<f64>]) -> Vec<f64> {
    let conditions = means.first().map_or(0, Vec::len);
    (0..conditions)
        .map(|c| {
            let known: Vec<f64> = means.iter().map(|mean| mean[c]).filter(|value| value.is_finite()).collect();
            mean(&known).unwrap_or(f64::NAN)
        })
        .collect()
}

fn ceiling(means: &[Vec<f64>], pooled_over_all: &[f64]) -> Option<[f64; 2]> {
    if means.len() < 2 {
        return None;
    }
    let others = |i: usize| {
        let rest: Vec<Vec<f64>> =
            means.iter().enumerate().filter(|(j, _)| *j != i).map(|(_, mean)| mean.clone()).collect();
        pooled(&rest)
    };
    let lower: Vec<f64> = means.iter().enumerate().filter_map(|(i, mean)| rank_correlation(mean, &others(i))).collect();
    let upper: Vec<f64> = means.iter().filter_map(|mean| rank_correlation(mean, pooled_over_all)).collect();
    Some([mean(&lower)?, mean(&upper)?])
}

pub(super) fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

/// Spearman's correlation, ties at their mean rank, of the pairs that both have; `None` where one does not vary.
#[must_use]
pub fn rank_correlation(a: &[f64], b: &[f64]) -> Option<f64> {
    let pairs: Vec<(f64, f64)> =
        a.iter().copied().zip(b.iter().copied()).filter(|(a, b)| a.is_finite() && b.is_finite()).collect();
    let (a, b): (Vec<f64>, Vec<f64>) = pairs.into_iter().unzip();
    let (a, b) = (ranks(&a).0, ranks(&b).0);
    let (mean_a, mean_b) = (mean(&a)?, mean(&b)?);
    let sum = |x: &[f64], mean_x: f64, y: &[f64], mean_y: f64| -> f64 {
        x.iter().zip(y).map(|(x, y)| (x - mean_x) * (y - mean_y)).sum()
    };
    let (aa, bb) = (sum(&a, mean_a, &a, mean_a), sum(&b, mean_b, &b, mean_b));
    (aa > 0.0 && bb > 0.0).then(|| sum(&a, mean_a, &b, mean_b) / (aa * bb).sqrt())
}
