//! The threshold of a population: a psychometric function whose threshold differs between people, for one condition.
//!
//! Person i answers correctly with probability γ + (1 − γ − λ)·F(x; t_i, w), where t_i is normally distributed with mean
//! μ and standard deviation τ; w, λ and γ are common to all people. The parameters maximize the likelihood, in which t_i
//! is integrated out, multiplied by the priors of a single function; that of the threshold is for μ. The integrals are
//! sums over equidistant nodes about the peak of each person's likelihood (Trefethen & Weideman 2014, SIAM Rev. 56, 385);
//! Gauss–Hermite quadrature fails where the likelihood is a step, as with a small w.
//!
//! The standard error of μ is that of the sandwich (Liang & Zeger 1986, Biometrika 73, 13): each person moves μ by some
//! amount, and these amounts vary between people. It holds also where the data do not tell τ from w, and where τ is
//! estimated as 0, which is common with few people; the observed information does not. Where people have unequal numbers
//! of trials, the amounts are weighted as in a meta-analysis (Hartung & Knapp 2001, Stat. Med. 20, 3875), because the t
//! interval assumes that they vary equally.

use std::{array::from_fn, collections::BTreeMap, f64::consts::PI};

use nalgebra::{DMatrix, DVector};

use super::{
    model::{Estimate, Model, Point, Posterior, Priors, gap, ln_binomial},
    numeric::{curvature, highest},
};
use crate::statistics::{Interval, holm, mean_and_sd, t_quantile, t_two_sided};

/// The thresholds of people in one condition.
#[derive(Clone, Debug, PartialEq)]
pub struct Population {
    /// The function of the population: its threshold is μ, the mean threshold, and all people share its width, λ and γ.
    pub function: Estimate,
    /// The 95 % interval of μ, with the t quantile for one degree of freedom less than there are people; `None` if all people's
    /// functions rise between the same two levels, so that no answers show where in between, or are the same.
    pub interval: Option<Interval>,
    /// τ, the standard deviation of the people's thresholds, on the scale of x. With few people, it is often too small.
    pub sd: f64,
    /// The lowest and the highest level: those of the model, or of all people's points.
    pub range: [f64; 2],
    /// What each person contributes to μ, which is the mean of the contributions, in the order of their answers: not
    /// shrunken, so that contributions can be compared between conditions ([`Difference`]). It is not an estimate
    /// of the person's threshold where people have unequal numbers of trials.
    pub contributions: Vec<f64>,
    /// The logarithm of the likelihood, without binomial coefficients.
    pub log_likelihood: f64,
}

/// Fits a population; each person has points. The model's `overdispersed` has no effect, because people's answers vary
/// binomially about their own function here.
///
/// # Errors
///
/// There are fewer than two people, one has no trials, or all trials are at one level.
pub fn fit(people: &[Vec<Point>], model: &Model) -> Result<Population, &'static str> {
    let has_trials = |points: &Vec<Point>| points.iter().any(|point| point.total > 0);
    if people.len() < 2 || !people.iter().all(has_trials) {
        return Err("expected two or more people, each with trials");
    }
    let all = people.concat();
    let binomial = Model { overdispersed: false, ..*model };
    let priors = Priors::new(&all, &binomial)?;
    let single = |points: &[Point]| Posterior::with(points, &binomial, priors).most_probable();
    let own: Vec<Estimate> = people.iter().map(|points| single(points)).collect();
    let common = single(&all);
    let starts: Vec<f64> = own.iter().map(|own| own.threshold).collect();
    let answers = Answers { model, priors, people, starts };
    let x = answers.search(&own, &common);
    let at = answers.parameters(&x);
    let (contributions, interval) = answers.contributions(&x);
    Ok(Population {
        function: at,
        interval,
        sd: x[SD].abs(),
        range: priors.range,
        contributions,
        log_likelihood: answers.ln_density(&x) - priors.ln_density(&at),
    })
}

/// The parameters of the search: μ, τ with any sign, the logarithm of w, and the roots of λ and γ.
const MEAN: usize = 0;
const SD: usize = 1;
const WIDTH: usize = 2;
const LAPSE: usize = 3;
const GUESS: usize = 4;
/// The 95 % quantile of the normal distribution: F rises from .05 to .95 over twice as many standard deviations.
const Z_90: f64 = 1.644_853_626_951_472_7;
/// The second start of an estimated guess rate: that of two alternatives.
const HIGH_GUESS: f64 = 0.5;
/// The least weight of a person, as a share of the mean weight.
const LEAST_WEIGHT: f64 = 0.1;
/// Maximum number of nodes of the quadrature on either side of the peak.
const MAX_NODES: u32 = 1_000;
/// The peak of an integrand is found to this share of its width, and thresholds that differ by less of the width of a
/// function are the same.
const CLOSE: f64 = 1e-4;
/// People whose contributions to the mean differ by less than this share of the width answered alike.
const ALIKE: f64 = 2e-3;

struct Answers<'a> {
    model: &'a Model,
    priors: Priors,
    people: &'a [Vec<Point>],
    /// The threshold of each person alone: where the search for the peak of the integrand begins.
    starts: Vec<f64>,
}

impl Answers<'_> {
    fn parameters(&self, x: &[f64; 5]) -> Estimate {
        let [lapse, guess] = [x[LAPSE], x[GUESS]].map(|root| root.powi(2));
        let guess = self.model.guess.or(guess);
        Estimate { threshold: x[MEAN], width: x[WIDTH].exp(), lapse, guess, overdispersion: 0.0 }
    }

    /// The logarithm of the likelihood of all people, times the priors.
    fn ln_density(&self, x: &[f64; 5]) -> f64 {
        let prior = self.priors.ln_density(&self.parameters(x));
        if prior == f64::NEG_INFINITY {
            return prior;
        }
        prior + (0..self.people.len()).map(|person| self.integral(person, x)).sum::<f64>()
    }

    /// Searches from the parameters of each person alone, and of all people's answers together. A low guess rate with a low
    /// threshold and a high one with a high threshold can both be maxima, so an estimated rate has two starts.
    fn search(&self, own: &[Estimate], common: &Estimate) -> [f64; 5] {
        let (mean, sd) = mean_and_sd(&self.starts);
        let [low, high] = self.priors.range;
        let sd = sd.max((high - low) / 50.0);
        let width = own.iter().map(|own| own.width.ln()).sum::<f64>() / own.len() as f64;
        let [lapse, guess] = [common.lapse, common.guess].map(|share| share.sqrt().min(0.2));
        let steps = [sd, sd / 2.0, 0.2, 0.1, if self.priors.has_free_guess { 0.1 } else { 0.0 }];
        let from = |guess: f64| highest(|x| self.ln_density(x), [mean, sd, width, lapse, guess], steps, 1e-7);
        let found = from(guess);
        let second = self.priors.has_free_guess.then(|| from(HIGH_GUESS.sqrt()));
        second.filter(|second| second.1 > found.1).unwrap_or(found).0
    }

    /// Integrates a person's likelihood over the threshold, and returns the logarithm.
    fn integral(&self, person: usize, x: &[f64; 5]) -> f64 {
        let at = self.parameters(x);
        // A population without differences is a narrow one.
        let sd = x[SD].abs().max(1e-4 * at.width);
        let ln_likelihood =
            |threshold: f64| ln_binomial(self.model, &self.people[person], &Estimate { threshold, ..at });
        let ln_normal = |threshold: f64| -((threshold - at.threshold) / sd).powi(2) / 2.0;
        let start = self.starts[person].clamp(at.threshold - 5.0 * sd, at.threshold + 5.0 * sd);
        let (peak, scale) = peak(&ln_likelihood, at.threshold, sd, at.width, start);
        let top = ln_likelihood(peak) + ln_normal(peak);
        let step = scale.min(at.width / 4.0);
        let mass = |threshold: f64| (ln_likelihood(threshold) + ln_normal(threshold) - top).exp();
        let mut total = 1.0;
        for side in [-step, step] {
            let outward = (1..=MAX_NODES).map(|node| mass(peak + f64::from(node) * side));
            total = outward.take_while(|mass| *mass > 1e-12).fold(total, |total, mass| total + mass);
        }
        top + (step / sd * total).ln() - (2.0 * PI).ln() / 2.0
    }

    /// Returns what each person contributes to the mean, and its interval.
    fn contributions(&self, x: &[f64; 5]) -> (Vec<f64>, Option<Interval>) {
        let n = self.people.len();
        let (weights, influences) = (self.weights(x), self.influences(x));
        // The priors, too, move μ; the contributions exclude this.
        let moved: f64 = influences.iter().sum();
        // An influence varies with the square root of its weight, so that these vary equally (Hartung & Knapp 2001).
        let equal = |(influence, weight): (f64, &f64)| (influence - weight * moved) * (n as f64 / weight).sqrt();
        let equal: Vec<f64> = influences.into_iter().zip(&weights).map(equal).collect();
        // With unequal weights, their mean is not 0. Without it, they would vary too little.
        let (middle, _) = mean_and_sd(&equal);
        let [about_zero, about_middle] =
            [0.0, middle].map(|from| equal.iter().map(|one| (one - from).powi(2)).sum::<f64>());
        let spread = if about_middle > 0.0 { (about_zero / about_middle).sqrt() } else { 1.0 };
        let contribution = |own: f64| x[MEAN] + spread * (own - middle);
        let contributions: Vec<f64> = equal.into_iter().map(contribution).collect();
        // Equal answers give contributions that differ by rounding, which says nothing about how people differ.
        let differ = mean_and_sd(&contributions).1 > ALIKE * self.parameters(x).width;
        let interval = Interval::of_mean(&contributions);
        (contributions, interval.filter(|_| differ && !self.rises_between_levels(x)))
    }

    /// The psychometric function of the population, whose width includes the differences between people.
    fn marginal(&self, x: &[f64; 5]) -> Estimate {
        let at = self.parameters(x);
        Estimate { width: at.width.hypot(2.0 * Z_90 * x[SD]), ..at }
    }

    /// Returns whether the functions of all people rise between the same two levels. The likelihood is then flat about μ.
    fn rises_between_levels(&self, x: &[f64; 5]) -> bool {
        let at = self.marginal(x);
        at.width < gap(self.people.iter().flatten(), at.threshold)
    }

    /// Returns the share of each person in what is known about μ: proportional to 1 / (τ² + s²), with s² the variance of
    /// the person's own threshold. The information 1 / s² is that of the trials at the function of the population, so that
    /// it does not depend on how the person happened to answer.
    fn weights(&self, x: &[f64; 5]) -> Vec<f64> {
        let at = self.marginal(x);
        let step = 0.01 * at.width;
        let weight = |points: &Vec<Point>| {
            let sigmoids = |by: f64| self.model.sigmoids(points, at.threshold + by, at.width);
            let rises = sigmoids(step).zip(sigmoids(-step)).map(|(one, other)| (one - other) / (2.0 * step));
            let terms = points.iter().zip(sigmoids(0.0).zip(rises)).map(|(point, (sigmoid, rise))| {
                let span = 1.0 - at.guess - at.lapse;
                let chance = at.guess + span * sigmoid;
                f64::from(point.total) * (span * rise).powi(2) / (chance * (1.0 - chance)).max(1e-6)
            });
            let information: f64 = terms.sum();
            information / (1.0 + x[SD].powi(2) * information)
        };
        let weights: Vec<f64> = self.people.iter().map(weight).collect();
        // Trials that tell nothing about the threshold still move μ by what they tell about w, λ and γ.
        let least = LEAST_WEIGHT * weights.iter().sum::<f64>() / weights.len() as f64;
        let weights = weights.into_iter().map(|weight| weight.max(least).max(f64::MIN_POSITIVE));
        let all: f64 = weights.clone().sum();
        weights.map(|weight| weight / all).collect()
    }

    /// Returns by how much each person moves μ: a row of the inverse of the observed information, times the person's
    /// score. Parameters of which the information is not positive definite are taken as known.
    fn influences(&self, x: &[f64; 5]) -> Vec<f64> {
        let step = 0.05 * x[SD].hypot(x[WIDTH].exp() / 4.0);
        let steps = [step, step, 0.02, 0.01, if self.priors.has_free_guess { 0.01 } else { 0.0 }];
        let second = curvature(|x| self.ln_density(x), x, steps);
        let free = if self.priors.has_free_guess { 5 } else { 4 };
        let information = |size: usize| DMatrix::from_fn(size, size, |i, j| -second[(i, j)]).cholesky();
        let unit = |size: usize| DVector::from_fn(size, |i, _| if i == MEAN { 1.0 } else { 0.0 });
        let row = (1..=free).rev().find_map(|size| Some(information(size)?.solve(&unit(size))));
        let weights = row.unwrap_or_else(|| DVector::zeros(0));
        let score = |person: usize, axis: usize| {
            let at =
                |sign: f64| self.integral(person, &from_fn(|i| x[i] + if i == axis { sign * steps[i] } else { 0.0 }));
            (at(1.0) - at(-1.0)) / (2.0 * steps[axis])
        };
        let influence =
            |person: usize| weights.iter().enumerate().map(|(axis, weight)| weight * score(person, axis)).sum();
        (0..self.people.len()).map(influence).collect()
    }
}

/// Finds the peak of a likelihood times a normal density by Newton's method, and the standard deviation of the normal
/// density with the same curvature there.
fn peak(ln_likelihood: &impl Fn(f64) -> f64, mean: f64, sd: f64, width: f64, start: f64) -> (f64, f64) {
    let step = 1e-3 * width;
    let ln_normal = |x: f64| -((x - mean) / sd).powi(2) / 2.0;
    let (mut x, mut scale, mut middle) = (start, sd, ln_likelihood(start));
    for _ in 0..50 {
        let [below, above] = [x - step, x + step].map(ln_likelihood);
        // The likelihood need not be concave; the normal density is.
        let curvature = ((below - 2.0 * middle + above) / step.powi(2)).min(0.0) - sd.powi(-2);
        scale = (-curvature).sqrt().recip();
        let rise = (above - below) / (2.0 * step) - (x - mean) / sd.powi(2);
        let mut by = (rise * scale.powi(2)).clamp(-width, width);
        let mut next = ln_likelihood(x + by);
        // The quadrature does not need the exact peak.
        while by.abs() > CLOSE * scale && next + ln_normal(x + by) < middle + ln_normal(x) {
            by /= 2.0;
            next = ln_likelihood(x + by);
        }
        (x, middle) = (x + by, next);
        if by.abs() <= CLOSE * scale {
            break;
        }
    }
    (x, scale)
}

/// The mean of one value of each person.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mean {
    /// The mean, in the unit of the values; NaN without people.
    pub mean: f64,
    /// Its 95 % t interval; `None` for fewer than two people, or if all values are the same.
    pub interval: Option<Interval>,
    /// Number of people.
    pub people: usize,
}

impl Mean {
    /// Returns the mean of one value of each person.
    pub fn new(values: &[f64]) -> Self {
        Self { mean: mean_and_sd(values).0, interval: Interval::of_mean(values), people: values.len() }
    }

    /// Returns the mean of one value of each person, none of which can be outside these ends, and neither can its interval.
    pub fn bounded(values: &[f64], ends: [f64; 2]) -> Self {
        let (mean, sd) = mean_and_sd(values);
        let interval = Interval::of_bounded_mean(values.len() as f64, mean, sd, ends);
        Self { interval, ..Self::new(values) }
    }

    /// Returns p of the t test of a mean of 0; `None` without an interval.
    pub fn p(&self) -> Option<f64> {
        let (Interval { low, high }, df) = (self.interval?, self.people as f64 - 1.0);
        Some(t_two_sided(self.mean / ((high - low) / 2.0 / t_quantile(df)), df))
    }
}

/// How two conditions differ.
#[derive(Clone, Debug, PartialEq)]
pub struct Difference {
    /// The conditions.
    pub conditions: [usize; 2],
    /// The first minus the second, of the people who have both.
    pub mean: Mean,
    /// p of the t test with Holm's correction for all pairs; `None` without an interval.
    pub p: Option<f64>,
}

impl Difference {
    /// Tests each pair of conditions for which several people have both.
    pub fn of(pairs: impl Iterator<Item = ([usize; 2], Mean)>) -> Vec<Self> {
        let of_pair = |(conditions, mean)| Self { conditions, mean, p: None };
        let mut found: Vec<Self> = pairs.map(of_pair).filter(|difference| difference.mean.people > 1).collect();
        let corrected = holm(&found.iter().map(|difference| difference.mean.p()).collect::<Vec<_>>());
        found.iter_mut().zip(corrected).for_each(|(difference, p)| difference.p = p);
        found
    }

    /// Compares every two conditions by the values of people: for thresholds, what they contribute to their means.
    pub fn between(all: &[(usize, BTreeMap<usize, f64>)]) -> Vec<Self> {
        let pairs = all.iter().enumerate().flat_map(|(i, one)| all[i + 1..].iter().map(move |two| (one, two)));
        Self::of(pairs.map(|((one, first), (two, second))| {
            let both = first.iter().filter_map(|(person, value)| Some(value - second.get(person)?));
            ([*one, *two], Mean::new(&both.collect::<Vec<_>>()))
        }))
    }

    /// Returns whether the conditions clearly differ.
    pub fn is_clear(&self) -> bool {
        self.p.is_some_and(|p| p < 0.05)
    }
}
