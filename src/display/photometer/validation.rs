//! Cross-validation: each level is left out in turn, and predicted from the others.
//!
//! Levels 0 and 1 stay: no curve knows black and white that were not read.

use super::{
    bend::{self, Stiffness},
    fit::Fit,
    response::Response,
    sample::Sample,
    shape::{Curve, Family},
};

/// How well a model predicts levels that it was not fitted to.
#[derive(Clone, Debug, PartialEq)]
pub struct CrossValidation {
    /// Root mean square error, 8-bit codes.
    pub rms_codes: f64,
    /// Root mean square error, cd/m².
    pub rms_cd_m2: f64,
    /// Largest error, 8-bit codes.
    pub largest_codes: f64,
    /// Mean squared error in units of the readings' noise: 1 or little more where the model is right.
    pub score: f64,
    /// That of each level and channel, in a fixed order.
    pub(super) each: Vec<f64>,
}

/// One level of one channel, predicted.
struct Miss {
    codes: f64,
    cd_m2: f64,
    weighted: f64,
}

/// Leaves out level by level; `None` where there is no level between 0 and 1.
pub(super) fn validate(sample: &Sample, fit: &Fit) -> Option<CrossValidation> {
    summary(sample, |rest| {
        let fit = Fit::from(fit.model, rest, fit.parameters.clone());
        fit.curves.into_iter().map(Response::Curve).collect()
    })
}

/// The same for the bent curve.
pub(super) fn validate_bent(sample: &Sample, fit: &Fit, stiffness: Stiffness) -> Option<CrossValidation> {
    summary(sample, |rest| {
        let fit = Fit::from(fit.model, rest, fit.parameters.clone());
        let curves = bend::with_read_black(rest, &fit.curves);
        bent(rest, &curves, stiffness).unwrap_or_else(|| curves.into_iter().map(Response::Curve).collect())
    })
}

/// Curves bent to readings.
pub(super) fn bent(sample: &Sample, curves: &[Curve], stiffness: Stiffness) -> Option<Vec<Response>> {
    let bends = bend::bends(&bend::shifts(sample, curves), stiffness)?;
    curves.iter().zip(&bends).map(|(curve, bend)| Response::bent(curve, bend).ok()).collect()
}

fn summary(sample: &Sample, fitted_to: impl Fn(&Sample) -> Vec<Response>) -> Option<CrossValidation> {
    let mut misses = Vec::new();
    for level in sample.inner_levels() {
        let is_left_out = |v: f64| (v - level).abs() < 1e-6;
        let responses = fitted_to(&sample.filtered(|point| !is_left_out(point.v)));
        for (channel, response) in responses.iter().enumerate() {
            let left_out = sample.filtered(|point| point.channel == channel && is_left_out(point.v));
            misses.extend(miss(&left_out, level, response));
        }
    }
    let n = misses.len() as f64;
    let rms = |of: fn(&Miss) -> f64| (misses.iter().map(|miss| of(miss).powi(2)).sum::<f64>() / n).sqrt();
    let each: Vec<f64> = misses.iter().map(|miss| miss.weighted.powi(2)).collect();
    (!misses.is_empty()).then(|| CrossValidation {
        rms_codes: rms(|miss| miss.codes),
        rms_cd_m2: rms(|miss| miss.cd_m2),
        largest_codes: misses.iter().map(|miss| miss.codes.abs()).fold(0.0, f64::max),
        score: each.iter().sum::<f64>() / n,
        each,
    })
}

fn miss(left_out: &Sample, level: f64, response: &Response) -> Option<Miss> {
    let n = left_out.points.len() as f64;
    let y = left_out.points.iter().map(|point| point.y).sum::<f64>() / n;
    let sd = left_out.points.first()?.sd / n.sqrt();
    let cd_m2 = y - response.cd_m2(level);
    Some(Miss { codes: 255.0 * (response.encoded(y) - level), cd_m2, weighted: cd_m2 / sd })
}

/// The better model: the simplest whose score is within one standard error of the best one's (Hastie, Tibshirani &
/// Friedman 2009, The Elements of Statistical Learning, §7.10), the error being that of the difference at the same
/// levels. `models` from the simplest on.
pub(super) fn better(models: &[(Family, Option<&CrossValidation>)]) -> Option<Family> {
    let known: Vec<(Family, &CrossValidation)> =
        models.iter().filter_map(|(family, validation)| Some((*family, (*validation)?))).collect();
    let (_, best) = known.iter().min_by(|a, b| a.1.score.total_cmp(&b.1.score))?;
    let as_good = |validation: &CrossValidation| {
        let differences: Vec<f64> = validation.each.iter().zip(&best.each).map(|(a, b)| a - b).collect();
        let n = differences.len() as f64;
        let mean = differences.iter().sum::<f64>() / n;
        let variance = differences.iter().map(|d| (d - mean).powi(2)).sum::<f64>() / (n - 1.0).max(1.0);
        mean <= (variance / n).sqrt()
    };
    known.iter().find(|(_, validation)| as_good(validation)).map(|(family, _)| *family)
}
