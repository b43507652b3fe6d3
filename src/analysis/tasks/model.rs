//! The model of a psychometric function: what is assumed about its parameters before the answers, the likelihood of these, and
//! the posterior density: its maximum, and draws from it.

use std::{array::from_fn, f64::consts::PI, fmt, str::FromStr};

use rand::{RngExt as _, SeedableRng as _};
use rand_chacha::ChaCha8Rng;
use serde::Serialize;

use super::numeric::highest;
use crate::{
    experiment::{
        Protocol,
        task::{
            Easier, Measures, Method,
            curve::{Curve, Psychometric},
        },
    },
    text::names::serde_as_text,
};

/// The answers at one level, or in one block of trials at a level.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Point {
    /// The level, on the scale of the curve: its base-10 logarithm on a logarithmic axis; infinite in catch trials
    /// ([`Model::unseen`]).
    pub x: f64,
    /// Number of correct answers, or of yes answers; at most that of trials.
    pub correct: u32,
    /// Number of trials.
    pub total: u32,
}

impl Point {
    /// Adds answers at a level to the points.
    pub fn add(points: &mut Vec<Self>, x: f64, correct: u32, total: u32) {
        match points.iter_mut().find(|point| point.x == x) {
            Some(point) => (point.correct, point.total) = (point.correct + correct, point.total + total),
            None => points.push(Self { x, correct, total }),
        }
    }

    /// Returns whether the trials showed a target.
    pub fn is_target(&self) -> bool {
        self.x.is_finite()
    }
}

/// γ, the probability of a correct answer, or of yes, at a level that cannot be seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Guess {
    /// A known probability, at least 0 and below 1: 1/n for n alternatives.
    Fixed(f64),
    /// Estimated, 0…½, as for answers of yes and no.
    Free,
}

impl fmt::Display for Guess {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Fixed(guess) => write!(f, "{guess}"),
            Self::Free => f.write_str("free"),
        }
    }
}

impl FromStr for Guess {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text == "free" {
            return Ok(Self::Free);
        }
        let guess = text.parse().ok().filter(|guess: &f64| (0.0..1.0).contains(guess));
        let guess =
            guess.ok_or("expected free, or a probability from 0 to below 1, such as 0.5 for two alternatives")?;
        Ok(Self::Fixed(guess))
    }
}

serde_as_text!(Guess);

/// What is known about a psychometric function before the answers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Model {
    /// The shape of F.
    pub curve: Curve,
    /// γ.
    pub guess: Guess,
    /// Whether F falls with x. It is mirrored, as by a negative slope in [`Psychometric`].
    pub falls: bool,
    /// Whether η is free; otherwise it is 0. Blocks of a few trials say little about it, and single trials nothing, so that
    /// the same answers as counts have wider intervals than as trials.
    pub overdispersed: bool,
    /// The lowest and the highest level that could have been shown; those of the points if `None`. After an adaptive
    /// procedure, the points cover only a part of the range, which would make the priors too narrow.
    pub range: Option<[f64; 2]>,
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
    /// Returns what is known about the psychometric functions of a study; `None` if no levels are varied.
    pub fn of(protocol: &Protocol) -> Option<Self> {
        let adaptive = protocol.adaptive.as_ref()?;
        if !matches!(protocol.task.measures(), Measures::Proportions | Measures::Detection) {
            return None;
        }
        let curve = if let Method::QuestPlus(quest) = &adaptive.method { quest.function } else { Curve::Normal };
        let guess = protocol.task.guess().map_or(Guess::Free, Guess::Fixed);
        let falls = adaptive.common.easier == Easier::Low;
        let range = Some(adaptive.range().map(|level| adaptive.common.scaled(level)));
        // Blocks of constant stimuli can vary more than binomially; blocks of a few trials say nothing about it.
        let overdispersed = matches!(adaptive.method, Method::Constant(_));
        Some(Self { curve, guess, falls, overdispersed, range })
    }

    /// Returns the level of catch trials: at the end of the scale where F is 0, so that their answers tell γ.
    pub fn unseen(&self) -> f64 {
        if self.falls { f64::INFINITY } else { f64::NEG_INFINITY }
    }

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
    pub(super) fn slope_at_threshold(&self, width: f64, lapse: f64, guess: f64) -> f64 {
        const STEP: f64 = 1e-4;
        let (slope, half) = self.slope(width);
        let rise = self.curve.sigmoid(half + STEP) - self.curve.sigmoid(half - STEP);
        (1.0 - guess - lapse) * slope * rise / (2.0 * STEP)
    }

    /// Returns these parameters as the experiment uses them; its threshold is that of [`Curve`].
    pub fn parameters(&self, estimate: &Estimate) -> Psychometric {
        let (slope, half) = self.slope(estimate.width);
        let Estimate { threshold, lapse, guess, .. } = *estimate;
        Psychometric { threshold: threshold - half / slope, slope, guess, lapse }
    }
}

/// The exponent of the priors of λ, γ and η, whose distribution function is 1 − (1 − λ)¹⁰.
const SHARPNESS: f64 = 10.0;
/// The greatest λ and free γ.
const MAX_LAPSE: f64 = 0.5;

/// The prior distributions.
#[derive(Clone, Copy, Debug)]
pub(super) struct Priors {
    /// The lowest and the highest level.
    pub range: [f64; 2],
    /// The least width.
    least_width: f64,
    /// Whether γ is estimated.
    pub has_free_guess: bool,
    /// The greatest λ.
    max_lapse: f64,
    /// The greatest η.
    max_overdispersion: f64,
}

impl Priors {
    /// Returns the priors for these data.
    pub fn new(points: &[Point], model: &Model) -> Result<Self, &'static str> {
        let mut levels: Vec<f64> =
            points.iter().filter(|point| point.total > 0 && point.is_target()).map(|point| point.x).collect();
        levels.sort_by(f64::total_cmp);
        let steps = levels.windows(2).map(|pair| pair[1] - pair[0]).filter(|step| *step > 0.0);
        let nearest = steps.min_by(f64::total_cmp).ok_or("expected trials at two or more levels")?;
        // psignifit's rule for a range that was stated.
        let stated = |[low, high]: [f64; 2]| ([low, high], (high - low) / 100.0);
        let (range, least_width) = model.range.map_or(([levels[0], levels[levels.len() - 1]], nearest), stated);
        let (has_free_guess, max_lapse) = match model.guess {
            Guess::Fixed(guess) => (false, MAX_LAPSE.min(1.0 - guess)),
            Guess::Free => (true, MAX_LAPSE),
        };
        // A single trial cannot vary more than binomially.
        let varies = model.overdispersed && points.iter().any(|point| point.total > 1);
        Ok(Self { range, least_width, has_free_guess, max_lapse, max_overdispersion: f64::from(u8::from(varies)) })
    }

    /// The logarithm of the density of the parameters, except for a constant.
    pub fn ln_density(&self, at: &Estimate) -> f64 {
        let shares = [at.lapse, if self.has_free_guess { at.guess } else { 0.0 }, at.overdispersion];
        let greatest = [self.max_lapse, MAX_LAPSE, 1.0];
        if shares.iter().zip(greatest).any(|(share, greatest)| *share >= greatest) {
            return f64::NEG_INFINITY;
        }
        let [low, high] = self.range;
        let (span, least) = (high - low, self.least_width);
        let fall = |share: f64| if share < 1.0 { ((1.0 + (PI * share).cos()) / 2.0).ln() } else { f64::NEG_INFINITY };
        let outside = (low - at.threshold).max(at.threshold - high).max(0.0);
        let beyond =
            if at.width >= span { (at.width - span) / (2.0 * span) } else { (2.0 - at.width / least).max(0.0) };
        let of_shares: f64 = shares.into_iter().map(|share| (SHARPNESS - 1.0) * (-share).ln_1p()).sum();
        fall(2.0 * outside / span) + fall(beyond) + of_shares
    }

    /// The bounds of the threshold, the logarithm of the width, λ, γ and η.
    pub fn bounds(&self) -> [[f64; 2]; 5] {
        let [low, high] = self.range;
        let span = high - low;
        let shares = [self.max_lapse, if self.has_free_guess { MAX_LAPSE } else { 0.0 }, self.max_overdispersion];
        let [lapse, guess, eta] = shares.map(|most| [0.0, most]);
        [[low - span / 2.0, high + span / 2.0], [self.least_width.ln(), (3.0 * span).ln()], lapse, guess, eta]
    }
}

/// Returns the logarithm of the beta-binomial likelihood of these points, without the binomial coefficients. The probability
/// is Π(ψ + j/ν)·Π(1 − ψ + j/ν)/Π(1 + j/ν), over the correct answers, the others, and all.
pub(super) fn ln_likelihood(model: &Model, points: &[Point], at: &Estimate) -> f64 {
    // 1/ν for η; 0 where the beta-binomial distribution is binomial in floating point, as in psignifit.
    let square = at.overdispersion.powi(2);
    let step = if square <= 1e-9 { 0.0 } else { square / (1.0 - square) };
    let [mut product, mut all] = [Product { factor: 1.0, ln: 0.0 }; 2];
    for (point, sigmoid) in points.iter().zip(model.sigmoids(points, at.threshold, at.width)) {
        let chance = at.guess + (1.0 - at.guess - at.lapse) * sigmoid;
        product.multiply(chance, step, point.correct);
        product.multiply(1.0 - chance, step, point.total - point.correct);
        all.multiply(1.0, step, point.total);
    }
    product.ln + product.factor.ln() - all.ln - all.factor.ln()
}

/// A product whose logarithm is wanted. Few logarithms are computed.
#[derive(Clone, Copy)]
struct Product {
    /// A part of the product, above 1e-140 after each multiplication that leaves it above 0.
    factor: f64,
    /// The logarithm of the rest.
    ln: f64,
}

impl Product {
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

/// The parameters as coordinates: the threshold, the logarithm of the width, λ, γ and η.
pub(super) type Place = [f64; 5];

/// The axes.
const THRESHOLD: usize = 0;
const WIDTH: usize = 1;
const LAPSE: usize = 2;
const GUESS: usize = 3;
const ETA: usize = 4;
/// Maxima whose logarithm is lower than the highest by more than this are not where walkers begin.
const FAR: f64 = 10.0;
/// Number of walkers that draw parameters, of their first steps, which do not count, and of those that do.
const WALKERS: usize = 40;
const FIRST_STEPS: usize = 250;
const STEPS: usize = 1_500;
/// How far from a maximum walkers begin, as a share of the way to a bound.
const SPREAD: f64 = 0.1;

/// The posterior density of a study.
pub(super) struct Posterior<'a> {
    pub model: &'a Model,
    /// The points with trials.
    pub points: Vec<Point>,
    pub priors: Priors,
}

impl<'a> Posterior<'a> {
    /// Returns the density for these points and the priors that they imply.
    pub fn new(points: &[Point], model: &'a Model) -> Result<Self, &'static str> {
        Ok(Self::with(points, model, Priors::new(points, model)?))
    }

    /// Returns the density with given priors.
    pub fn with(points: &[Point], model: &'a Model, priors: Priors) -> Self {
        Self { model, priors, points: points.iter().copied().filter(|point| point.total > 0).collect() }
    }

    /// Returns the parameters at a place.
    pub fn at(&self, place: &Place) -> Estimate {
        let [threshold, ln_width, lapse, guess, overdispersion] = *place;
        Estimate { threshold, width: ln_width.exp(), lapse, guess: self.model.guess.or(guess), overdispersion }
    }

    /// The logarithm of the density of the parameters, except for a constant.
    fn ln_density(&self, place: &Place) -> f64 {
        let at = self.at(place);
        let prior = self.priors.ln_density(&at);
        if prior == f64::NEG_INFINITY {
            return prior;
        }
        prior + ln_likelihood(self.model, &self.points, &at)
    }

    /// Returns the most probable parameters.
    pub fn most_probable(&self) -> Estimate {
        self.at(&self.maxima()[0].1)
    }

    /// Searches for maxima of the density from several starts: it can have one with few lapses and another one with many,
    /// or one with η = 0 and another one above. The highest comes first.
    pub fn maxima(&self) -> Vec<(f64, Place)> {
        let bounds = self.priors.bounds();
        let within = |axis: usize, share: f64| bounds[axis][0] + share * (bounds[axis][1] - bounds[axis][0]);
        let searched = |[lapse, eta]: [f64; 2]| {
            let start = |threshold: f64, width: f64| {
                [within(THRESHOLD, threshold), within(WIDTH, width), within(LAPSE, lapse), within(GUESS, 0.04), eta]
            };
            let nodes = (1..12).flat_map(|i| (1..12).map(move |j| [f64::from(i) / 12.0, f64::from(j) / 12.0]));
            let starts = self.highest_first(nodes.map(|[threshold, width]| start(threshold, width)));
            self.search(&starts[0].1)
        };
        let etas = if bounds[ETA][1] > 0.0 { &[0.0, 0.1, 0.3][..] } else { &[0.0] };
        let shares = etas.iter().map(|&eta| [0.03, eta]).chain([[0.0, 0.0], [0.08, 0.0], [0.3, 0.0]]);
        self.highest_first(shares.map(searched))
    }

    fn highest_first(&self, places: impl Iterator<Item = Place>) -> Vec<(f64, Place)> {
        let mut all: Vec<(f64, Place)> = places.map(|place| (self.ln_density(&place), place)).collect();
        all.sort_by(|l, r| r.0.total_cmp(&l.0));
        all
    }

    /// Searches for the highest density from a start; η stays 0 if it is 0 there. Squares keep the shares positive.
    pub fn search(&self, start: &Place) -> Place {
        let [[low, high], .., guess, _] = self.priors.bounds();
        let place = |x: &Place| from_fn(|axis| if axis < LAPSE { x[axis] } else { x[axis].powi(2) });
        let x = from_fn(|axis| if axis < LAPSE { start[axis] } else { start[axis].sqrt() });
        let step = |is_free: bool| if is_free { 0.06 } else { 0.0 };
        let steps = [(high - low) / 40.0, 0.2, 0.06, step(guess[1] > 0.0), step(start[ETA] > 0.0)];
        place(&highest(|x| self.ln_density(&place(x)), x, steps, 1e-9).0)
    }

    /// Draws parameters from the density by the ensemble sampler of Goodman & Weare (2010, Commun. Appl. Math. Comput. Sci.
    /// 5, 65): a walker moves along the line through another one. The draws are the same each time.
    pub fn draws(&self, maxima: &[(f64, Place)]) -> Vec<Estimate> {
        let bounds = self.priors.bounds();
        let axes = bounds.iter().filter(|[low, high]| low < high).count() as f64;
        let ln = |place: &Place| {
            let is_within = place.iter().zip(&bounds).all(|(x, [low, high])| low <= x && x <= high);
            // The density is per unit of the logarithm of the width.
            if is_within { self.ln_density(place) + place[WIDTH] } else { f64::NEG_INFINITY }
        };
        let mut rng = ChaCha8Rng::seed_from_u64(0);
        let near: Vec<&Place> =
            maxima.iter().filter(|(ln, _)| *ln > maxima[0].0 - FAR).map(|(_, place)| place).collect();
        let mut begin = |walker: usize| {
            let center = near[walker % near.len()];
            let place = from_fn(|axis| {
                let bound = bounds[axis][rng.random_range(0..2_usize)];
                center[axis] + SPREAD * rng.random::<f64>() * (bound - center[axis])
            });
            (ln(&place), place)
        };
        let mut walkers: Vec<(f64, Place)> = (0..WALKERS).map(&mut begin).collect();
        let mut draws = Vec::with_capacity(WALKERS * STEPS);
        for step in 0..FIRST_STEPS + STEPS {
            for walker in 0..WALKERS {
                let (before, place) = walkers[walker];
                let (_, other) = walkers[(walker + rng.random_range(1..WALKERS)) % WALKERS];
                let stretch = (1.0 + rng.random::<f64>()).powi(2) / 2.0;
                let next = from_fn(|axis| other[axis] + stretch * (place[axis] - other[axis]));
                let after = ln(&next);
                if rng.random::<f64>().ln() < (axes - 1.0) * stretch.ln() + after - before {
                    walkers[walker] = (after, next);
                }
            }
            if step >= FIRST_STEPS {
                draws.extend(walkers.iter().map(|(_, place)| self.at(place)));
            }
        }
        draws
    }
}
