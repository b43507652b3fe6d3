//! A psychometric function fitted to the answers of one person: the beta-binomial model of Schütt, Harmeling, Macke &
//! Wichmann (2016), Vision Res. 122, 105, with the priors of their program psignifit 4.
//!
//! The probability of a correct answer is ψ(x) = γ + (1 − γ − λ)·F(x; m, w): F(m) = ½, and the width w is the distance
//! between the levels with F = .05 and F = .95. The answers to each [`Point`] are beta-binomial with mean ψ and standard
//! deviation η·√(ψ(1 − ψ)) of the probability; η = 0 is the binomial distribution.
//!
//! Priors: m is uniform over the range of levels and falls as a cosine to 0 half a range beyond; w is uniform between
//! twice the least distance of two levels and the range, and falls as a cosine to 0 at that distance and at 3 ranges; λ,
//! a free γ, and η have the density 10(1 − λ)⁹.

use rand_chacha::ChaCha8Rng;
use rand_distr::{Binomial, Distribution as _};

pub use super::model::{Estimate, Guess, Model, Point};
use super::model::{Posterior, THRESHOLD, WIDTH, gap};
use crate::{statistics::Interval, system::checkpoint};

/// A fitted psychometric function.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fit {
    /// The most probable parameters.
    pub estimate: Estimate,
    /// The 95 % interval of the threshold, between the quantiles of its marginal posterior distribution.
    pub threshold: Interval,
    /// That of the width.
    pub width: Interval,
    /// The slope of ψ at the threshold, per unit of x; negative if F falls.
    pub slope: f64,
    /// Its 95 % interval.
    pub slope_interval: Interval,
    /// Whether the function rises within twice the distance of the two levels about the threshold, so that only the prior
    /// limits its slope.
    pub is_steep: bool,
}

/// How well a psychometric function fits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GoodnessOfFit {
    /// The deviance (Wichmann & Hill 2001, Percept. Psychophys. 63, 1293, eq. 6), of the best function with η = 0.
    pub deviance: f64,
    /// The share of simulated studies with at least this deviance; small if the answers vary more than binomially
    /// about every curve of this shape.
    pub p: f64,
}

/// Estimates a psychometric function without intervals, which is ten times as fast as [`fit`].
///
/// # Errors
///
/// There are trials at fewer than two levels.
pub fn estimate(points: &[Point], model: &Model) -> Result<Estimate, &'static str> {
    Ok(Posterior::new(points, model)?.most_probable())
}

/// Fits a psychometric function. The intervals are integrals of the posterior density over a grid that covers the
/// region in which the density is not negligible.
///
/// # Errors
///
/// As for [`estimate`].
pub fn fit(points: &[Point], model: &Model) -> Result<Fit, &'static str> {
    let posterior = Posterior::new(points, model)?;
    let maxima = posterior.maxima();
    let estimate = posterior.at(&maxima[0].1);
    let masses = posterior.masses(&maxima);
    // The slope is that of width 1, divided by the relative width.
    let steepest = model.slope_at_threshold(1.0, 0.0, 0.0).abs();
    let slope = masses.relative_width().map(|ln_width| steepest / ln_width.exp());
    Ok(Fit {
        estimate,
        threshold: masses.interval(THRESHOLD),
        width: masses.interval(WIDTH).map(f64::exp),
        slope: model.slope_at_threshold(estimate.width, estimate.lapse, estimate.guess),
        slope_interval: if model.falls { slope.map(|end| -end) } else { slope },
        is_steep: estimate.width < 2.0 * gap(posterior.points.iter(), estimate.threshold),
    })
}

impl Fit {
    /// Returns the most probable threshold; `None` if it lies outside its interval, so that the answers do not determine
    /// it: where the density falls to one side only, its highest place is at an end.
    pub fn determined_threshold(&self) -> Option<f64> {
        Some(self.estimate.threshold).filter(|threshold| self.threshold.contains(*threshold))
    }

    /// Returns the interval of the slope; `None` if the answers do not limit the slope.
    pub fn determined_slopes(&self) -> Option<Interval> {
        Some(self.slope_interval).filter(|_| !self.is_steep)
    }

    /// Returns the most probable slope; `None` without an interval, or if it lies outside.
    pub fn determined_slope(&self) -> Option<f64> {
        self.determined_slopes().filter(|interval| interval.contains(self.slope)).map(|_| self.slope)
    }
}

/// Tests whether the answers vary about the best psychometric function as the binomial distribution says: the deviance
/// is compared with those of `simulations` studies of this function, to each of which a function is fitted in the same
/// way (Wichmann & Hill 2001). 1,000 simulations determine a p of .05 to ±.014.
///
/// # Errors
///
/// As for [`estimate`].
pub fn goodness_of_fit(
    points: &[Point],
    model: &Model,
    simulations: usize,
    rng: &mut ChaCha8Rng,
) -> Result<GoodnessOfFit, &'static str> {
    let mut posterior = Posterior::new(points, model)?;
    // η = 0.
    let [threshold, width, lapse, guess, _] = posterior.maxima()[0].1;
    let best = posterior.search(&[threshold, width, lapse, guess, 0.0]);
    let observed = deviance(&posterior.points, model, &posterior.at(&best));
    let function = model.parameters(&posterior.at(&best));
    let chance = |point: &Point| model.curve.probability(point.x, &function).clamp(0.0, 1.0);
    let chances: Vec<f64> = posterior.points.iter().map(chance).collect();
    let mut larger = 0;
    for _ in 0..simulations {
        checkpoint();
        for (point, chance) in posterior.points.iter_mut().zip(&chances) {
            point.correct = Binomial::new(point.total.into(), *chance).map_or(0, |answers| answers.sample(rng) as u32);
        }
        let again = posterior.at(&posterior.search(&best));
        larger += usize::from(deviance(&posterior.points, model, &again) >= observed - 1e-9);
    }
    Ok(GoodnessOfFit { deviance: observed, p: (1 + larger) as f64 / (1 + simulations) as f64 })
}

/// Returns 2·Σ of the observed counts times the logarithms of their ratios to those that are expected.
fn deviance(points: &[Point], model: &Model, at: &Estimate) -> f64 {
    let term = |count: f64, expected: f64| if count > 0.0 { 2.0 * count * (count / expected).ln() } else { 0.0 };
    let terms = points.iter().zip(model.sigmoids(points, at.threshold, at.width)).map(|(point, sigmoid)| {
        let (n, k) = (f64::from(point.total), f64::from(point.correct));
        let chance = at.guess + (1.0 - at.guess - at.lapse) * sigmoid;
        term(k, n * chance) + term(n - k, n * (1.0 - chance))
    });
    terms.sum()
}
