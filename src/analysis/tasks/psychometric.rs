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

use std::{array::from_fn, f64::consts::PI};

use rand::RngExt as _;
use rand_chacha::ChaCha8Rng;
use serde::Serialize;

use super::numeric::{highest, legendre};
use crate::{
    experiment::task::curve::{Curve, Psychometric},
    statistics::Interval,
};

/// The answers at one level, or in one block of trials at a level.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Point {
    /// The level, on the scale of the curve: its decadic logarithm on a logarithmic axis.
    pub x: f64,
    /// Number of correct answers, or of answers yes.
    pub correct: u32,
    /// Number of trials.
    pub total: u32,
}

/// γ, the probability of a correct answer, or of yes, at a level that cannot be seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Guess {
    /// A known probability, at least 0 and below 1: 1/n for n alternatives.
    Fixed(f64),
    /// Estimated, 0…½, as for answers yes and no.
    Free,
}

/// What is known about a psychometric function before the answers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Model {
    /// The shape of F.
    pub curve: Curve,
    /// γ.
    pub guess: Guess,
    /// Whether F falls with x. It is mirrored, as by a negative slope in [`Psychometric`].
    pub falls: bool,
    /// Whether η is free; otherwise it is 0. Blocks of a few trials say little about it, and single trials nothing.
    pub overdispersed: bool,
    /// The lowest and the highest level that could have been shown; those of the points if `None`. After an adaptive
    /// procedure, the points cover only a part of the range, which would make the priors too narrow.
    pub range: Option<[f64; 2]>,
}

/// Why a function cannot be fitted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum FitError {
    /// A level is infinite or not a number.
    #[error("a level is not a finite number")]
    Level,
    /// There are more correct answers than trials.
    #[error("a level has more correct answers than trials")]
    Count,
    /// All trials are at one level, or there are none.
    #[error("expected trials at two or more levels")]
    Levels,
    /// The range is empty or not finite.
    #[error("the range of levels must be two finite numbers in ascending order")]
    Range,
    /// γ is not a probability below 1.
    #[error("the probability of a correct guess must be at least 0 and below 1")]
    Guess,
    /// There are too few people.
    #[error("expected two or more people")]
    People,
}

/// The parameters of a psychometric function: those at which the posterior density is highest.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Estimate {
    /// m, the level with F = ½, on the scale of x.
    pub threshold: f64,
    /// w, the distance between the levels with F = .05 and .95, on the scale of x; above 0.
    pub width: f64,
    /// λ, 0…½.
    pub lapse: f64,
    /// γ, 0…½ if it is free.
    pub guess: f64,
    /// η, 0…1; 0 if the answers vary as the binomial distribution says.
    pub overdispersion: f64,
}

/// A fitted psychometric function.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
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
    /// Whether the interval of the threshold reaches beyond the range of levels. There, the prior limits it, not the
    /// answers.
    pub is_extrapolated: bool,
}

/// How well a psychometric function fits.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct GoodnessOfFit {
    /// The deviance (Wichmann & Hill 2001, Percept. Psychophys. 63, 1293, eq. 6), of the best function with η = 0.
    pub deviance: f64,
    /// The share of simulated studies with at least this deviance; small if the answers vary more than binomially
    /// about every curve of this shape.
    pub p: f64,
}

impl Guess {
    /// Returns γ, which is `free` if it is estimated.
    pub(super) fn or(self, free: f64) -> f64 {
        match self {
            Self::Fixed(guess) => guess,
            Self::Free => free,
        }
    }
}

impl Model {
    /// Returns β of F = [`Curve::sigmoid`]`(z + β(x − m))` for a width, and z, where the sigmoid is ½.
    fn slope(&self, width: f64) -> (f64, f64) {
        let [low, half, high] = [0.05, 0.5, 0.95].map(|share| self.curve.inverse(share));
        let sign = if self.falls { -1.0 } else { 1.0 };
        (sign * (high - low) / width, half)
    }

    /// Returns F at each point.
    pub(super) fn sigmoids(&self, points: &[Point], threshold: f64, width: f64) -> impl Iterator<Item = f64> {
        let (slope, half) = self.slope(width);
        points.iter().map(move |point| self.curve.sigmoid(half + slope * (point.x - threshold)))
    }

    /// Returns the slope of ψ at the threshold, per unit of x.
    fn slope_at_threshold(&self, width: f64, lapse: f64, guess: f64) -> f64 {
        const STEP: f64 = 1e-4;
        let (slope, half) = self.slope(width);
        let rise = self.curve.sigmoid(half + STEP) - self.curve.sigmoid(half - STEP);
        (1.0 - guess - lapse) * slope * rise / (2.0 * STEP)
    }

    /// Returns these parameters as the experiment uses them; its threshold is that of [`Curve`].
    #[must_use]
    pub fn parameters(&self, estimate: &Estimate) -> Psychometric {
        let (slope, half) = self.slope(estimate.width);
        let Estimate { threshold, lapse, guess, .. } = *estimate;
        Psychometric { threshold: threshold - half / slope, slope, guess, lapse }
    }
}

/// Estimates a psychometric function without intervals, which is about a hundred times as fast as [`fit`].
///
/// # Errors
///
/// A level, a count, the range or γ is impossible, or there are trials at fewer than two levels.
pub fn estimate(points: &[Point], model: &Model) -> Result<Estimate, FitError> {
    Ok(Posterior::new(points, model)?.maxima()[0].1)
}

/// Fits a psychometric function. The intervals are integrals of the posterior density over a grid that covers the
/// region in which the density is not negligible.
///
/// # Errors
///
/// As for [`estimate`].
pub fn fit(points: &[Point], model: &Model) -> Result<Fit, FitError> {
    let posterior = Posterior::new(points, model)?;
    let maxima = posterior.maxima();
    let estimate = maxima[0].1;
    let masses = posterior.masses(&maxima);
    let threshold = masses.interval(THRESHOLD);
    let [low, high] = posterior.priors.range;
    // The slope is that of width 1, divided by the relative width.
    let steepest = model.slope_at_threshold(1.0, 0.0, 0.0).abs();
    let relative = exp(masses.relative_width());
    let slope = Interval { low: steepest / relative.high, high: steepest / relative.low };
    Ok(Fit {
        estimate,
        threshold,
        width: exp(masses.interval(WIDTH)),
        slope: model.slope_at_threshold(estimate.width, estimate.lapse, estimate.guess),
        slope_interval: if model.falls { slope.negative() } else { slope },
        is_extrapolated: threshold.low < low || threshold.high > high,
    })
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
) -> Result<GoodnessOfFit, FitError> {
    let mut posterior = Posterior::new(points, model)?;
    let best = posterior.search(posterior.maxima()[0].1, false);
    let deviance = posterior.deviance(&best);
    let function = model.parameters(&best);
    let chances: Vec<f64> = posterior.points.iter().map(|point| model.curve.probability(point.x, &function)).collect();
    let mut larger = 0;
    for _ in 0..simulations {
        for (point, &chance) in posterior.points.iter_mut().zip(&chances) {
            point.correct = (0..point.total).filter(|_| rng.random::<f64>() < chance).count() as u32;
        }
        let again = posterior.search(best, false);
        larger += usize::from(posterior.deviance(&again) >= deviance - 1e-9);
    }
    Ok(GoodnessOfFit { deviance, p: (1 + larger) as f64 / (1 + simulations) as f64 })
}

/// The axes of a grid.
const THRESHOLD: usize = 0;
const WIDTH: usize = 1;
const LAPSE: usize = 2;
const GUESS: usize = 3;
const ETA: usize = 4;
/// The exponent of the priors of λ, γ and η, whose distribution function is 1 − (1 − λ)¹⁰.
const SHARPNESS: f64 = 10.0;
/// The greatest λ and free γ.
pub(super) const MAX_LAPSE: f64 = 0.5;
/// Numbers of nodes of the grids: those that find the region, and the last.
const COARSE: [usize; 5] = [13, 13, 4, 4, 5];
const FINE: [usize; 5] = [26, 26, 6, 6, 4];
const FIXED: [usize; 5] = [28, 28, 10, 1, 6];
/// The grid leaves out where the marginal density is lower than this share of its highest value.
const NEGLIGIBLE: f64 = 1e-3;
const NEGLIGIBLE_SHARE: f64 = 5e-3;
/// Maxima whose logarithm is lower than the highest by more than this are not the start of the grid.
const FAR: f64 = 10.0;
/// Maximum number of grids that find the region.
const MAX_ROUNDS: usize = 12;

/// The prior distributions.
#[derive(Clone, Copy)]
pub(super) struct Priors {
    /// The lowest and the highest level.
    pub range: [f64; 2],
    /// The least width.
    least_width: f64,
    /// Whether γ is estimated.
    pub has_free_guess: bool,
    /// The greatest λ.
    max_lapse: f64,
}

impl Priors {
    /// Returns the priors for these data.
    pub fn new(points: &[Point], model: &Model) -> Result<Self, FitError> {
        check(points, model)?;
        let mut levels: Vec<f64> = points.iter().filter(|point| point.total > 0).map(|point| point.x).collect();
        levels.sort_by(f64::total_cmp);
        let steps = levels.windows(2).map(|pair| pair[1] - pair[0]).filter(|step| *step > 0.0);
        let nearest = steps.min_by(f64::total_cmp).ok_or(FitError::Levels)?;
        // psignifit's rule for a range that was stated.
        let stated = |[low, high]: [f64; 2]| ([low, high], (high - low) / 100.0);
        let (range, least_width) = model.range.map_or(([levels[0], levels[levels.len() - 1]], nearest), stated);
        let (has_free_guess, max_lapse) = match model.guess {
            Guess::Fixed(guess) => (false, MAX_LAPSE.min(1.0 - guess)),
            Guess::Free => (true, MAX_LAPSE),
        };
        Ok(Self { range, least_width, has_free_guess, max_lapse })
    }

    /// The logarithm of the density of the parameters, except for a constant.
    pub fn ln_density(&self, at: &Estimate) -> f64 {
        let shares = [at.lapse, if self.has_free_guess { at.guess } else { 0.0 }, at.overdispersion];
        let greatest = [self.max_lapse, MAX_LAPSE, 1.0];
        if shares.iter().zip(greatest).any(|(share, greatest)| *share >= greatest) {
            return f64::NEG_INFINITY;
        }
        let ln_shares = shares.iter().map(|share| (SHARPNESS - 1.0) * (-share).ln_1p());
        self.ln_place(at.threshold, at.width) + ln_shares.sum::<f64>()
    }

    /// The part of the threshold and the width.
    fn ln_place(&self, threshold: f64, width: f64) -> f64 {
        let [low, high] = self.range;
        let (span, least) = (high - low, self.least_width);
        let fall = |share: f64| if share < 1.0 { ((1.0 + (PI * share).cos()) / 2.0).ln() } else { f64::NEG_INFINITY };
        let outside = (low - threshold).max(threshold - high).max(0.0);
        let beyond = if width >= span { (width - span) / (2.0 * span) } else { (2.0 - width / least).max(0.0) };
        fall(2.0 * outside / span) + fall(beyond)
    }
}

/// The posterior density of a study.
struct Posterior<'a> {
    model: &'a Model,
    points: Vec<Point>,
    priors: Priors,
}

impl<'a> Posterior<'a> {
    fn new(points: &[Point], model: &'a Model) -> Result<Self, FitError> {
        let priors = Priors::new(points, model)?;
        Ok(Self { model, priors, points: points.iter().copied().filter(|point| point.total > 0).collect() })
    }

    /// The bounds of the parameters on the axes of a grid: the threshold, the logarithm of the width, and the
    /// probabilities to which λ, γ and η correspond in their priors.
    fn bounds(&self) -> [[f64; 2]; 5] {
        let Priors { range: [low, high], least_width, has_free_guess, max_lapse } = self.priors;
        let span = high - low;
        let guess = if has_free_guess { prior_share(MAX_LAPSE) } else { 0.0 };
        let eta = if self.has_eta() { 1.0 } else { 0.0 };
        let threshold = [low - span / 2.0, high + span / 2.0];
        [threshold, [least_width.ln(), (3.0 * span).ln()], [0.0, prior_share(max_lapse)], [0.0, guess], [0.0, eta]]
    }

    /// Whether η matters: a single trial cannot vary more than binomially.
    fn has_eta(&self) -> bool {
        self.model.overdispersed && self.points.iter().any(|point| point.total > 1)
    }

    /// F at each point.
    fn sigmoids(&self, threshold: f64, width: f64) -> Vec<f64> {
        self.model.sigmoids(&self.points, threshold, width).collect()
    }

    /// The logarithm of the likelihood except for the term of [`Self::ln_total`], for 1/ν = `step`. The beta-binomial
    /// probability is Π(ψ + j/ν)·Π(1 − ψ + j/ν)/Π(1 + j/ν), over the correct answers, the others, and all.
    fn ln_likelihood(&self, sigmoids: &[f64], guess: f64, lapse: f64, step: f64) -> f64 {
        let mut product = Product { factor: 1.0, ln: 0.0 };
        for (point, sigmoid) in self.points.iter().zip(sigmoids) {
            let chance = guess + (1.0 - guess - lapse) * sigmoid;
            product.answers(point, chance, step);
        }
        product.ln()
    }

    /// The denominators of the beta-binomial probabilities.
    fn ln_total(&self, step: f64) -> f64 {
        let mut product = Product { factor: 1.0, ln: 0.0 };
        self.points.iter().for_each(|point| product.multiply(1.0, step, point.total));
        -product.ln()
    }

    /// The logarithm of the posterior density, except for a constant.
    fn ln_density(&self, at: &Estimate) -> f64 {
        let prior = self.priors.ln_density(at);
        if prior == f64::NEG_INFINITY {
            return prior;
        }
        let step = step_of(at.overdispersion);
        let sigmoids = self.sigmoids(at.threshold, at.width);
        prior + self.ln_likelihood(&sigmoids, at.guess, at.lapse, step) + self.ln_total(step)
    }

    /// Searches for maxima of the density from several starts: it can have one with few lapses and another one with many,
    /// or one with η = 0 and another one above. The highest comes first.
    fn maxima(&self) -> Vec<(f64, Estimate)> {
        let [[low, high], [narrow, wide], ..] = self.bounds();
        let start = |threshold: f64, width: f64, [lapse, overdispersion]: [f64; 2]| Estimate {
            threshold: low + threshold * (high - low),
            width: (narrow + width * (wide - narrow)).exp(),
            lapse: lapse * self.priors.max_lapse,
            guess: self.model.guess.or(0.02),
            overdispersion,
        };
        let searched = |shares: [f64; 2]| {
            let nodes = (1..12).flat_map(|i| (1..12).map(move |j| [f64::from(i) / 12.0, f64::from(j) / 12.0]));
            let starts = nodes.map(|[threshold, width]| start(threshold, width, shares));
            let (_, best) = self.highest_first(starts)[0];
            self.search(best, shares[1] > 0.0)
        };
        let shares = [[0.0, 0.0], [0.03, 0.0], [0.3, 0.0], [0.03, 0.1], [0.03, 0.3]];
        self.highest_first(shares[..if self.has_eta() { 5 } else { 3 }].iter().copied().map(searched))
    }

    fn highest_first(&self, estimates: impl Iterator<Item = Estimate>) -> Vec<(f64, Estimate)> {
        let mut all: Vec<(f64, Estimate)> = estimates.map(|estimate| (self.ln_density(&estimate), estimate)).collect();
        all.sort_by(|l, r| r.0.total_cmp(&l.0));
        all
    }

    /// Searches for the highest density from a start, with η = 0 if it is not free. Squares keep the shares positive.
    fn search(&self, start: Estimate, free_eta: bool) -> Estimate {
        let [[low, high], ..] = self.bounds();
        let free_guess = self.priors.has_free_guess;
        let estimate = |x: &[f64; 5]| Estimate {
            threshold: x[THRESHOLD],
            width: x[WIDTH].exp(),
            lapse: x[LAPSE].powi(2),
            guess: self.model.guess.or(x[GUESS].powi(2)),
            overdispersion: if free_eta { x[ETA].powi(2) } else { 0.0 },
        };
        let shares = [start.lapse, start.guess, start.overdispersion].map(f64::sqrt);
        let x = [start.threshold, start.width.ln(), shares[0], shares[1], shares[2]];
        let step = |free: bool| if free { 0.1 } else { 0.0 };
        let steps = [(high - low) / 40.0, 0.2, 0.1, step(free_guess), step(free_eta)];
        estimate(&highest(|x| self.ln_density(&estimate(x)), x, steps, 1e-9).0)
    }

    /// 2·Σ of the logarithms of the ratios of the observed proportion to ψ.
    fn deviance(&self, at: &Estimate) -> f64 {
        let term = |count: f64, expected: f64| if count > 0.0 { 2.0 * count * (count / expected).ln() } else { 0.0 };
        let sigmoids = self.sigmoids(at.threshold, at.width);
        let terms = self.points.iter().zip(sigmoids).map(|(point, sigmoid)| {
            let (n, k) = (f64::from(point.total), f64::from(point.correct));
            let chance = at.guess + (1.0 - at.guess - at.lapse) * sigmoid;
            term(k, n * chance) + term(n - k, n * (1.0 - chance))
        });
        terms.sum()
    }

    /// Computes the mass at each node of a grid over the region in which the density is not negligible. The search
    /// begins around the maxima, because a grid over all parameters would miss a narrow one.
    fn masses(&self, maxima: &[(f64, Estimate)]) -> Masses {
        let all = self.bounds();
        let near =
            maxima.iter().filter(|(ln, _)| *ln > maxima[0].0 - FAR).map(|(_, maximum)| self.surroundings(maximum));
        let hull = |[low, high]: [f64; 2], other: [f64; 2]| [low.min(other[0]), high.max(other[1])];
        let first = all.map(|[low, high]| [high, low]);
        let mut bounds = near.fold(first, |bounds, other| from_fn(|axis| hull(bounds[axis], other[axis])));
        for _ in 0..MAX_ROUNDS {
            let masses = self.masses_at(&bounds, COARSE);
            let next: [[f64; 2]; 5] = from_fn(|axis| masses.region(axis, bounds[axis], all[axis]));
            let change = |(old, new): (&[f64; 2], &[f64; 2])| {
                (old[0] - new[0]).abs().max((old[1] - new[1]).abs()) / (old[1] - old[0])
            };
            let has_changed = bounds.iter().zip(&next).any(|pair| change(pair) > 0.1);
            bounds = next;
            if !has_changed {
                break;
            }
        }
        self.masses_at(&bounds, if self.priors.has_free_guess { FINE } else { FIXED })
    }

    /// Returns, for each axis, how far from a maximum the density remains high if the other parameters do not change.
    fn surroundings(&self, maximum: &Estimate) -> [[f64; 2]; 5] {
        let shares =
            [maximum.lapse, if self.priors.has_free_guess { maximum.guess } else { 0.0 }, maximum.overdispersion];
        let [lapse, guess, eta] = shares.map(prior_share);
        let center = [maximum.threshold, maximum.width.ln(), lapse, guess, eta];
        let ln_density = |x: &[f64; 5]| {
            let [lapse, guess, overdispersion] = [x[LAPSE], x[GUESS], x[ETA]].map(prior_quantile);
            let at = Estimate {
                threshold: x[THRESHOLD],
                width: x[WIDTH].exp(),
                lapse,
                guess: self.model.guess.or(guess),
                overdispersion,
            };
            self.ln_density(&at)
        };
        let least = ln_density(&center) - 2.0;
        from_fn(|axis| {
            let [low, high] = self.bounds()[axis];
            [low, high].map(|end| {
                let along = |share: f64| {
                    let mut x = center;
                    x[axis] += share * (end - center[axis]);
                    x
                };
                let shares = (0..14).map(|halvings| 0.5_f64.powi(halvings));
                // The end itself may be impossible.
                shares.map(along).find(|x| ln_density(x) > least).unwrap_or(center)[axis]
            })
        })
    }

    fn masses_at(&self, bounds: &[[f64; 2]; 5], sizes: [usize; 5]) -> Masses {
        let rule = |axis: usize| {
            if axis <= WIDTH { uniform(bounds[axis], sizes[axis]) } else { gauss(bounds[axis], sizes[axis]) }
        };
        let axes: [Vec<(f64, f64)>; 5] = from_fn(rule);
        let lapses: Vec<f64> = axes[LAPSE].iter().map(|(share, _)| prior_quantile(*share)).collect();
        let guesses: Vec<f64> =
            axes[GUESS].iter().map(|(share, _)| self.model.guess.or(prior_quantile(*share))).collect();
        let steps = axes[ETA].iter().map(|(share, _)| step_of(prior_quantile(*share)));
        let steps: Vec<(f64, f64)> = steps.map(|step| (step, self.ln_total(step))).collect();
        let mut densities = Vec::with_capacity(axes.iter().map(Vec::len).product());
        for (threshold, _) in &axes[THRESHOLD] {
            for (ln_width, _) in &axes[WIDTH] {
                // The density is per unit of the logarithm.
                let prior = self.priors.ln_place(*threshold, ln_width.exp()) + ln_width;
                let sigmoids = self.sigmoids(*threshold, ln_width.exp());
                for &lapse in &lapses {
                    for &guess in &guesses {
                        let density = |(step, total): &(f64, f64)| {
                            prior + total + self.ln_likelihood(&sigmoids, guess, lapse, *step)
                        };
                        densities.extend(steps.iter().map(density));
                    }
                }
            }
        }
        Masses::new(axes, &densities, [lapses, guesses])
    }
}

/// Estimates a function with the priors of a larger study.
pub(super) fn estimate_with(points: &[Point], model: &Model, priors: Priors) -> Estimate {
    Posterior { model, points: points.to_vec(), priors }.maxima()[0].1
}

/// Returns the logarithm of the binomial likelihood of these points, without the coefficients.
pub(super) fn ln_binomial(model: &Model, points: &[Point], at: &Estimate) -> f64 {
    let mut product = Product { factor: 1.0, ln: 0.0 };
    for (point, sigmoid) in points.iter().zip(model.sigmoids(points, at.threshold, at.width)) {
        product.answers(point, at.guess + (1.0 - at.guess - at.lapse) * sigmoid, 0.0);
    }
    product.ln()
}

fn check(points: &[Point], model: &Model) -> Result<(), FitError> {
    if points.iter().any(|point| !point.x.is_finite()) {
        return Err(FitError::Level);
    }
    if points.iter().any(|point| point.correct > point.total) {
        return Err(FitError::Count);
    }
    if model.range.is_some_and(|[low, high]| !(low < high && (high - low).is_finite())) {
        return Err(FitError::Range);
    }
    match model.guess {
        Guess::Fixed(guess) if !(0.0..1.0).contains(&guess) => Err(FitError::Guess),
        _ => Ok(()),
    }
}

/// The distribution function of the priors of λ, γ and η.
fn prior_share(value: f64) -> f64 {
    -(SHARPNESS * (-value).ln_1p()).exp_m1()
}

/// The inverse of [`prior_share`].
fn prior_quantile(share: f64) -> f64 {
    -((-share).ln_1p() / SHARPNESS).exp_m1()
}

/// Returns 1/ν for η; 0 where the beta-binomial distribution is binomial in floating point, as in psignifit.
fn step_of(eta: f64) -> f64 {
    let square = eta * eta;
    if square <= 1e-9 { 0.0 } else { square / (1.0 - square) }
}

/// Returns equidistant nodes, and the weights of the trapezoidal rule.
fn uniform([low, high]: [f64; 2], nodes: usize) -> Vec<(f64, f64)> {
    let step = (high - low) / (nodes - 1) as f64;
    let weight = |i: usize| if i == 0 || i == nodes - 1 { step / 2.0 } else { step };
    (0..nodes).map(|i| (low + step * i as f64, weight(i))).collect()
}

/// Returns the nodes and weights of the Gauss–Legendre rule between two ends; a single node if they are equal.
fn gauss([low, high]: [f64; 2], nodes: usize) -> Vec<(f64, f64)> {
    if low == high {
        return vec![(low, 1.0)];
    }
    legendre(nodes).into_iter().map(|(node, weight)| (low + (high - low) * node, (high - low) * weight)).collect()
}

/// A product whose logarithm is wanted. Few logarithms are computed.
struct Product {
    /// A part of the product, above 1e-140 after each multiplication that leaves it above 0.
    factor: f64,
    /// The logarithm of the rest.
    ln: f64,
}

impl Product {
    fn ln(&self) -> f64 {
        self.ln + self.factor.ln()
    }

    /// Multiplies with the numerator of the probability of a point's answers.
    fn answers(&mut self, point: &Point, chance: f64, step: f64) {
        self.multiply(chance, step, point.correct);
        self.multiply(1.0 - chance, step, point.total - point.correct);
    }

    /// Multiplies with start·(start + step)·…, `count` factors. Beyond the first 16, their logarithms are summed by the
    /// formula of Euler and Maclaurin.
    fn multiply(&mut self, start: f64, step: f64, count: u32) {
        let direct = count.min(16);
        let mut next = start;
        for _ in 0..direct {
            self.factor *= next;
            next += step;
        }
        if self.factor < 1e-140 {
            self.ln += self.factor.ln();
            self.factor = 1.0;
        }
        let rest = f64::from(count - direct);
        if rest > 0.0 && step == 0.0 {
            self.ln += rest * start.ln();
        } else if rest > 0.0 {
            let end = next + rest * step;
            let (ln, ln_end) = (next.ln(), end.ln());
            let integral = (end * ln_end - next * ln) / step - rest;
            self.ln += integral - (ln_end - ln) / 2.0 + step / 12.0 * (1.0 / end - 1.0 / next);
        }
    }
}

/// The posterior mass at the nodes of a grid.
struct Masses {
    axes: [Vec<(f64, f64)>; 5],
    /// The mass at each node of each axis.
    marginals: [Vec<f64>; 5],
    /// λ and γ at the nodes.
    shares: [Vec<f64>; 2],
    /// The mass for each λ, γ and width.
    widths: Vec<f64>,
}

impl Masses {
    fn new(axes: [Vec<(f64, f64)>; 5], ln_densities: &[f64], shares: [Vec<f64>; 2]) -> Self {
        let sizes = axes.each_ref().map(Vec::len);
        let most = ln_densities.iter().fold(f64::NEG_INFINITY, |most, ln| most.max(*ln));
        let mut marginals = sizes.map(|size| vec![0.0; size]);
        let mut widths = vec![0.0; sizes[WIDTH] * sizes[LAPSE] * sizes[GUESS]];
        for (mut place, ln) in ln_densities.iter().enumerate() {
            let mut nodes = [0; 5];
            for axis in (0..5).rev() {
                nodes[axis] = place % sizes[axis];
                place /= sizes[axis];
            }
            let weight: f64 = (0..5).map(|axis| axes[axis][nodes[axis]].1).product();
            let mass = weight * (ln - most).exp();
            (0..5).for_each(|axis| marginals[axis][nodes[axis]] += mass);
            let [_, width, lapse, guess, _] = nodes;
            widths[(lapse * sizes[GUESS] + guess) * sizes[WIDTH] + width] += mass;
        }
        Self { axes, marginals, shares, widths }
    }

    /// Returns the part of an axis in which the density is not negligible, with one node on either side. Where it is not
    /// negligible at an end, the part extends beyond the grid.
    fn region(&self, axis: usize, [low, high]: [f64; 2], all: [f64; 2]) -> [f64; 2] {
        let nodes = &self.axes[axis];
        let densities: Vec<f64> =
            nodes.iter().zip(&self.marginals[axis]).map(|((_, weight), mass)| mass / weight).collect();
        let least =
            (if axis <= WIDTH { NEGLIGIBLE } else { NEGLIGIBLE_SHARE }) * densities.iter().copied().fold(0.0, f64::max);
        let first = densities.iter().position(|density| *density > least).unwrap_or(0);
        let last = densities.iter().rposition(|density| *density > least).unwrap_or(nodes.len() - 1);
        let more = (high - low) / 2.0;
        let below = first.checked_sub(1).map_or((low - more).max(all[0]), |before| nodes[before].0);
        [below, nodes.get(last + 1).map_or((high + more).min(all[1]), |after| after.0)]
    }

    /// Returns the interval of the threshold or of the logarithm of the width.
    fn interval(&self, axis: usize) -> Interval {
        central(&self.axes[axis], &[(0.0, &self.marginals[axis])])
    }

    /// Returns the interval of the logarithm of the width divided by 1 − γ − λ. The slope is inversely proportional to
    /// this ratio.
    fn relative_width(&self) -> Interval {
        let [lapses, guesses] = &self.shares;
        let parts: Vec<(f64, &[f64])> =
            (lapses.iter().flat_map(|lapse| guesses.iter().map(move |guess| lapse + guess)))
                .zip(self.widths.chunks(self.axes[WIDTH].len()))
                .map(|(share, masses)| (-(-share).ln_1p(), masses))
                .collect();
        central(&self.axes[WIDTH], &parts)
    }
}

fn exp(interval: Interval) -> Interval {
    Interval { low: interval.low.exp(), high: interval.high.exp() }
}

/// Returns the 2.5 % and 97.5 % quantiles of a mixture. Each part is a shift and the masses at equidistant nodes, between
/// which its density is linear.
fn central(nodes: &[(f64, f64)], parts: &[(f64, impl AsRef<[f64]>)]) -> Interval {
    let (first, step) = (nodes[0].0, nodes[1].0 - nodes[0].0);
    let below = |x: f64| -> f64 {
        parts.iter().map(|(shift, masses)| cumulative(masses.as_ref(), (x - shift - first) / step)).sum()
    };
    let ends = |x: f64| parts.iter().fold([x; 2], |[low, high], (shift, _)| [low.min(x + shift), high.max(x + shift)]);
    let ([low, _], [_, high]) = (ends(first), ends(nodes[nodes.len() - 1].0));
    let all = below(high);
    let quantile = |share: f64| {
        let (mut low, mut high) = (low, high);
        for _ in 0..50 {
            let middle = f64::midpoint(low, high);
            *if below(middle) < share * all { &mut low } else { &mut high } = middle;
        }
        low
    };
    Interval { low: quantile(0.025), high: quantile(0.975) }
}

/// Returns the mass below a place, counted in steps from the first node.
fn cumulative(masses: &[f64], place: f64) -> f64 {
    let last = masses.len() - 1;
    // The trapezoidal rule gives half of the weight to the ends.
    let density = |i: usize| if i == 0 || i == last { 2.0 * masses[i] } else { masses[i] };
    let place = place.clamp(0.0, last as f64);
    let whole = (place as usize).min(last - 1);
    let part = place - whole as f64;
    let before: f64 = (0..whole).map(|i| f64::midpoint(density(i), density(i + 1))).sum();
    before + part * (density(whole) + part * (density(whole + 1) - density(whole)) / 2.0)
}
