//! Weighted least squares: the parameters of a model by the method of Levenberg and Marquardt.

use nalgebra::{DMatrix, DVector};

use super::{
    model::Model,
    sample::Sample,
    shape::{Curve, Family},
};

/// Steps at most.
const STEPS: usize = 80;
/// A gain in the weighted sum of squares below this share is none.
const CONVERGED: f64 = 1e-13;
/// Damping that can no longer help.
const STUCK: f64 = 1e12;

/// A fitted model.
#[derive(Clone, Debug)]
pub(super) struct Fit {
    pub model: Model,
    pub parameters: Vec<f64>,
    pub curves: Vec<Curve>,
    /// Σ ((y − μ)/sd)².
    pub deviance: f64,
    /// Readings.
    pub readings: usize,
}

impl Fit {
    /// Readings beyond the parameters.
    pub fn freedom(&self) -> f64 {
        self.readings as f64 - self.parameters.len() as f64
    }

    /// The best fit from several starts.
    pub fn new(model: Model, sample: &Sample) -> Self {
        let starts = [(2.2, 0.02), (2.2, -0.02), (1.6, 0.1)];
        let starts = if model.family == Family::Gog { &starts[..] } else { &starts[..1] };
        let fits = starts.iter().map(|(gamma, k)| Self::from(model, sample, model.start(sample, *gamma, *k)));
        fits.min_by(|a, b| a.deviance.total_cmp(&b.deviance))
            .unwrap_or_else(|| Self::from(model, sample, model.start(sample, 2.2, 0.0)))
    }

    /// The fit from a start.
    pub fn from(model: Model, sample: &Sample, mut parameters: Vec<f64>) -> Self {
        let width = sample.width();
        model.clamp(width, &mut parameters);
        let mut residuals = residuals(model, sample, &parameters);
        let mut deviance = residuals.norm_squared();
        let mut damping = 1e-4;
        for _ in 0..STEPS {
            let slopes = slopes(model, sample, &parameters);
            let (normal, gradient) = (slopes.tr_mul(&slopes), slopes.tr_mul(&residuals));
            let mut gained = None;
            while gained.is_none() && damping < STUCK {
                let Some(next) = step(model, width, &parameters, &normal, &gradient, damping) else {
                    damping *= 10.0;
                    continue;
                };
                let after = self::residuals(model, sample, &next);
                if after.norm_squared() < deviance {
                    gained = Some(deviance - after.norm_squared());
                    (parameters, deviance, residuals) = (next, after.norm_squared(), after);
                    damping = (damping * 0.1).max(1e-15);
                } else {
                    damping *= 10.0;
                }
            }
            if gained.is_none_or(|gain| gain <= CONVERGED * deviance) {
                break;
            }
        }
        let curves = model.curves(sample, &parameters);
        Self { model, parameters, curves, deviance, readings: sample.points.len() }
    }

    /// Variances and covariances of the parameters, for readings whose noise is `scale` times what was assumed.
    pub fn covariance(&self, sample: &Sample, scale: f64) -> Option<DMatrix<f64>> {
        let slopes = slopes(self.model, sample, &self.parameters);
        let inverse = slopes.tr_mul(&slopes).try_inverse()?;
        Some(inverse * (scale * scale))
    }
}

fn step(
    model: Model,
    width: usize,
    at: &[f64],
    normal: &DMatrix<f64>,
    gradient: &DVector<f64>,
    damping: f64,
) -> Option<Vec<f64>> {
    let mut damped = normal.clone();
    for i in 0..damped.nrows() {
        damped[(i, i)] += damping * normal[(i, i)].max(1e-12);
    }
    let move_by = damped.cholesky()?.solve(gradient);
    let mut next: Vec<f64> = at.iter().zip(move_by.iter()).map(|(at, by)| at + by).collect();
    model.clamp(width, &mut next);
    next.iter().all(|value| value.is_finite()).then_some(next)
}

fn residuals(model: Model, sample: &Sample, parameters: &[f64]) -> DVector<f64> {
    let curves = model.curves(sample, parameters);
    let each = sample.points.iter().map(|point| (point.y - curves[point.channel].cd_m2(point.v)) / point.sd);
    DVector::from_iterator(sample.points.len(), each)
}

/// How the weighted luminances change with the parameters.
fn slopes(model: Model, sample: &Sample, parameters: &[f64]) -> DMatrix<f64> {
    let mut slopes = DMatrix::zeros(sample.points.len(), parameters.len());
    for (column, value) in parameters.iter().enumerate() {
        let touches = model.touches(sample.width(), column);
        let h = 1e-6 * value.abs().max(1e-2);
        let moved = |by: f64| {
            let mut moved = parameters.to_vec();
            moved[column] += by;
            model.curves(sample, &moved)
        };
        let (up, down) = (moved(h), moved(-h));
        for (row, point) in sample.points.iter().enumerate() {
            if touches.is_none_or(|channel| channel == point.channel) {
                let (up, down) = (up[point.channel].cd_m2(point.v), down[point.channel].cd_m2(point.v));
                slopes[(row, column)] = (up - down) / (2.0 * h * point.sd);
            }
        }
    }
    slopes
}
