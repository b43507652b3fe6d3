//! Weighted least squares: the parameters of a model from readings.
//!
//! For a given shape, black and ranges follow in closed form; the shape's own parameters, at most two, by the method of
//! Levenberg and Marquardt.

use super::{
    models::{Curve, Family},
    sample::Sample,
};
use crate::light::Transfer;

/// Exponents and offsets that are tried.
const RANGES: [(f64, f64); 2] = [(0.3, 6.0), (-0.6, 0.4)];
/// Exponents and offsets to start from.
const STARTS: [[f64; 2]; 2] = [[2.2, 0.03], [2.2, -0.03]];
const MOST_STEPS: usize = 80;
/// A gain in the weighted sum of squares below this share is none.
const CONVERGED: f64 = 1e-13;
/// Damping that can no longer help.
const STUCK: f64 = 1e12;

/// A model fitted to a sample.
#[derive(Clone, Debug)]
pub(super) struct Fit {
    /// In the order of the sample's channels.
    pub curves: Vec<Curve>,
    /// Standard error of each channel's γ, for noise as large as what the fit leaves.
    pub gamma_se: Vec<Option<f64>>,
    /// Weighted sum of squares that is left, over the readings beyond the parameters.
    pub variance: f64,
    /// γ and offset of each shape.
    shapes: Vec<[f64; 2]>,
}

/// Fits a curve: one shape and one black for all channels where `shared`, else for each channel by itself. Starts from
/// another fit of the same model, where one is given. A table has the shapes of gain, offset and gamma.
pub(super) fn fit(family: Family, shared: bool, sample: &Sample, start: Option<&Fit>) -> Fit {
    if shared || sample.channels.len() == 1 {
        let starts = start.map_or(&STARTS[..], |fit| &fit.shapes);
        let fits = starts.iter().map(|start| descend(family, sample, *start));
        let best = fits.min_by(|a, b| a.variance.total_cmp(&b.variance));
        return best.unwrap_or_else(|| descend(family, sample, STARTS[0]));
    }
    let mut all = Fit { curves: Vec::new(), gamma_se: Vec::new(), variance: 0.0, shapes: Vec::new() };
    for (index, channel) in sample.channels.iter().enumerate() {
        let start = start.map(|start| Fit { shapes: vec![start.shapes[index]], ..start.clone() });
        let own = fit(family, true, &sample.of(*channel), start.as_ref());
        all.curves.extend(own.curves);
        all.gamma_se.extend(own.gamma_se);
        all.shapes.extend(own.shapes);
        all.variance += own.variance / sample.channels.len() as f64;
    }
    all
}

/// Free parameters of a shape.
fn free(family: Family) -> usize {
    match family {
        Family::Srgb => 0,
        Family::Gamma => 1,
        Family::Gog | Family::Table => 2,
    }
}

fn transfer(family: Family, [gamma, offset]: [f64; 2]) -> Transfer {
    let made = match free(family) {
        0 => Ok(Transfer::Srgb),
        1 => Transfer::gamma(gamma),
        _ => Transfer::gog(gamma, 1.0 - offset, offset),
    };
    // Within [`RANGES`] every shape is a display's.
    made.unwrap_or(Transfer::Srgb)
}

/// The shape with the black and the ranges that fit best.
fn curves(family: Family, sample: &Sample, shape: [f64; 2]) -> Vec<Curve> {
    let transfer = transfer(family, shape);
    // For each channel the weighted sums of 1, y, t, t², and t·y, t being the light of the shape.
    let mut sums = vec![[0.0; 5]; sample.channels.len()];
    for point in &sample.points {
        let (t, weight) = (transfer.linear_from_encoded(point.v), point.sd.powi(-2));
        let channel = sample.channels.iter().position(|channel| *channel == point.channel).unwrap_or(0);
        for (sum, value) in sums[channel].iter_mut().zip([1.0, point.y, t, t * t, t * point.y]) {
            *sum += weight * value;
        }
    }
    let (mut over, mut under) = (0.0, 0.0);
    for [n, y, t, tt, ty] in &sums {
        over += y - t * ty / tt;
        under += n - t * t / tt;
    }
    let black_cd_m2 = (over / under).max(0.0);
    let range = |[_, _, t, tt, ty]: &[f64; 5]| ((ty - black_cd_m2 * t) / tt).max(f64::MIN_POSITIVE);
    let curve = |sums| Curve { black_cd_m2, range_cd_m2: range(sums), transfer: transfer.clone() };
    sums.iter().map(curve).collect()
}

fn descend(family: Family, sample: &Sample, start: [f64; 2]) -> Fit {
    let residuals = |shape: [f64; 2]| sample.residuals(&curves(family, sample, shape));
    let square = |residuals: &[f64]| residuals.iter().map(|r| r * r).sum::<f64>();
    let free = free(family);
    let mut shape = start;
    let mut left = residuals(shape);
    let mut damping = 1e-4;
    let mut normal = [[1.0, 0.0], [0.0, 1.0]];
    for _ in 0..MOST_STEPS {
        // How the residuals fall with each parameter.
        let slopes: Vec<Vec<f64>> = (0..free)
            .map(|parameter| {
                let h = 1e-6;
                let moved = |by: f64| {
                    let mut shape = shape;
                    shape[parameter] += by;
                    residuals(shape)
                };
                moved(-h).iter().zip(moved(h)).map(|(down, up)| (down - up) / (2.0 * h)).collect()
            })
            .collect();
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let mut gradient = [0.0; 2];
        for i in 0..free {
            gradient[i] = dot(&slopes[i], &left);
            (0..free).for_each(|j| normal[i][j] = dot(&slopes[i], &slopes[j]));
        }
        let before = square(&left);
        let mut gained = None;
        while gained.is_none() && damping < STUCK {
            let next = step(shape, normal, gradient, damping);
            let after = residuals(next);
            if square(&after) < before {
                gained = Some(before - square(&after));
                (shape, left) = (next, after);
                damping = (damping * 0.1).max(1e-15);
            } else {
                damping *= 10.0;
            }
        }
        if gained.is_none_or(|gain| gain <= CONVERGED * before) {
            break;
        }
    }
    let parameters = free + sample.channels.len() + 1;
    let variance = square(&left) / (left.len() as f64 - parameters as f64).max(1.0);
    let [[a, b], [c, d]] = normal;
    let gamma_se = (free > 0).then(|| (variance * d / (a * d - b * c)).sqrt()).filter(|se| se.is_finite());
    let curves = curves(family, sample, shape);
    Fit { gamma_se: vec![gamma_se; curves.len()], curves, variance, shapes: vec![shape] }
}

/// A damped step from `shape`, within the ranges of the parameters.
fn step(shape: [f64; 2], [[a, b], [c, d]]: [[f64; 2]; 2], gradient: [f64; 2], damping: f64) -> [f64; 2] {
    let (a, d) = (a * (1.0 + damping), d * (1.0 + damping));
    let determinant = a * d - b * c;
    let by = [(d * gradient[0] - b * gradient[1]) / determinant, (a * gradient[1] - c * gradient[0]) / determinant];
    std::array::from_fn(|i| (shape[i] + by[i]).clamp(RANGES[i].0, RANGES[i].1))
}
