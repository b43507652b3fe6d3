//! What a model says about each cell of the design: probabilities of the categories and the mean rating, with intervals.

use nalgebra::DVector;
use serde::Serialize;

use super::{
    clm::category_bounds,
    estimates::finite_product,
    fitting::Fitted,
    model::{Coefficient, Model},
};
use crate::{
    analysis::{bootstrap::Interval, levels},
    light::normal::Z_95,
};

/// The ratings of one condition that a model expects; of a mixed model, from a subject in the middle (u = 0).
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Prediction {
    /// Names of the levels, in the order of the factors; empty where the value is missing.
    pub names: Vec<String>,
    /// Probability of each category that has ratings, in the order of [`Model::categories`].
    pub probabilities: Vec<f64>,
    /// Mean rating, in the numbers of the categories, or their positions from 0 where they are texts.
    pub mean: f64,
    /// Its 95 % interval by the delta method; none where a coefficient has no finite estimate.
    pub interval: Option<Interval>,
}

/// A model's predictions for every condition that it was fitted on.
pub(super) fn predictions(fitted: &Fitted, model: &Model) -> Vec<Prediction> {
    let values: Vec<f64> = levels::numbers_of(&model.categories)
        .unwrap_or_else(|| (0..model.categories.len()).map(|index| index as f64).collect());
    let conditions = fitted.frame.conditions();
    let (x, z) = (fitted.x.matrix(&conditions), fitted.scale.matrix(&conditions));
    let row = |matrix: &nalgebra::DMatrix<f64>, index: usize| matrix.row(index).iter().copied().collect::<Vec<f64>>();
    (conditions.iter().enumerate())
        .map(|(index, &condition)| predict(fitted, model, &values, condition, &row(&x, index), &row(&z, index)))
        .collect()
}

fn predict(fitted: &Fitted, model: &Model, values: &[f64], condition: u32, x: &[f64], z: &[f64]) -> Prediction {
    let effect = |coefficients: &[Coefficient], row: &[f64]| {
        finite_product(row.iter(), coefficients.iter().map(|coefficient| &coefficient.estimate))
    };
    let (location, scale) = (effect(&model.coefficients, x), effect(&model.scale, z).exp());
    let bounds: Vec<f64> = model.thresholds.iter().map(|threshold| (threshold.estimate - location) / scale).collect();
    let probabilities: Vec<f64> = (0..values.len())
        .map(|category| {
            let (a, b) = category_bounds(&bounds, category);
            if b > 0.0 { model.link.cdf(-b) - model.link.cdf(-a) } else { model.link.cdf(a) - model.link.cdf(b) }
        })
        .collect();
    let mean = probabilities.iter().zip(values).map(|(p, value)| p * value).sum();
    let counts = fitted.frame.counts;
    let names = (counts.conditions[condition as usize].iter().zip(&counts.factors))
        .map(|(level, factor)| level.map(|level| factor.levels[level as usize].clone()).unwrap_or_default())
        .collect();
    let gradient = mean_gradient(model, values, &bounds, scale, x, z);
    let variance = model.covariance.view((0, 0), (gradient.len(), gradient.len())) * &gradient;
    let error = gradient.dot(&variance).sqrt();
    let reach = Z_95 * error;
    let interval = reach.is_finite().then_some(Interval { low: mean - reach, high: mean + reach });
    Prediction { names, probabilities, mean, interval }
}

/// The gradient of the mean rating by thresholds, coefficients and scale.
fn mean_gradient(model: &Model, values: &[f64], bounds: &[f64], scale: f64, x: &[f64], z: &[f64]) -> DVector<f64> {
    // The mean falls by the step between two categories where the bound between them rises.
    let by_bound: Vec<f64> = (bounds.iter().enumerate())
        .map(|(j, bound)| -(values[j + 1] - values[j]) * model.link.density(*bound))
        .collect();
    let sum: f64 = by_bound.iter().sum();
    let spread: f64 = by_bound.iter().zip(bounds).map(|(slope, bound)| slope * bound).sum();
    let thresholds = by_bound.iter().map(|slope| slope / scale);
    let location = x.iter().map(|x| -sum * x / scale);
    let spreads = z.iter().map(|z| -spread * z);
    DVector::from_iterator(bounds.len() + x.len() + z.len(), thresholds.chain(location).chain(spreads))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::{
        counts::CountsBuilder,
        ordinal::{estimates::report, fitting::fit_counts, link::Link, model::ModelSpec, terms::Terms},
    };

    fn predict(spec: &ModelSpec) -> Vec<Prediction> {
        let mut builder = CountsBuilder::new(&["width"]);
        for (width, tally) in [("0.1", [5, 3, 2, 1]), ("0.4", [2, 4, 6, 3]), ("0.8", [1, 1, 5, 9])] {
            for (rating, count) in tally.into_iter().enumerate() {
                builder.add("S1", &[width], &rating.to_string(), count).unwrap();
            }
        }
        let counts = builder.finish();
        let fitted = fit_counts(&counts, spec, true).unwrap();
        predictions(&fitted, &report(&fitted))
    }

    /// A model without terms has the proportions of the ratings, and the binomial error of the mean.
    #[test]
    fn a_model_without_terms_predicts_the_proportions_at_hand() {
        for link in [Link::Logit, Link::Probit] {
            let prediction = &predict(&ModelSpec { link, ..ModelSpec::new(Terms::default()) })[0];
            let n = 42.0;
            let expected = [8.0 / n, 8.0 / n, 13.0 / n, 13.0 / n];
            let mean: f64 = expected.iter().enumerate().map(|(k, p)| k as f64 * p).sum();
            let square: f64 = expected.iter().enumerate().map(|(k, p)| (k * k) as f64 * p).sum();
            for (p, expected) in prediction.probabilities.iter().zip(expected) {
                assert!((p - expected).abs() < 1e-9);
            }
            let interval = prediction.interval.unwrap();
            let error = (interval.high - interval.low) / (2.0 * Z_95);
            assert!((prediction.mean - mean).abs() < 1e-9);
            assert!((error - ((square - mean * mean) / n).sqrt()).abs() < 1e-9, "{error}");
        }
    }

    #[test]
    fn predictions_follow_the_terms() {
        let width = Terms::parse("width").unwrap();
        let predictions = predict(&ModelSpec { scale: width.clone(), ..ModelSpec::new(width) });
        assert_eq!(predictions.iter().map(|p| p.names[0].as_str()).collect::<Vec<_>>(), ["0.1", "0.4", "0.8"]);
        assert!(predictions.windows(2).all(|pair| pair[0].mean < pair[1].mean));
        for prediction in &predictions {
            assert!((prediction.probabilities.iter().sum::<f64>() - 1.0).abs() < 1e-12);
            let interval = prediction.interval.unwrap();
            assert!(interval.low < prediction.mean && prediction.mean < interval.high);
        }
    }
}
