//! The model of a psychometric function: what is assumed about its parameters before the answers, the likelihood of these, and
//! the posterior density: its maximum, and its mass on a grid.

use std::{array::from_fn, f64::consts::PI, fmt, str::FromStr};

use super::numeric::{highest, legendre};
use crate::{
    experiment::{
        Protocol,
        task::{
            Easier, Method,
            curve::{Curve, Psychometric},
        },
    },
    statistics::Interval,
    text::names::serde_as_text,
};

/// The answers at one level, or in one block of trials at a level.
#[derive(Clone, Copy, Debug, PartialEq)]
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

/// Returns the distance between the two levels with trials between which a threshold lies; 0 at a level, and NaN beyond
/// the levels.
pub(super) fn gap<'p>(points: impl Iterator<Item = &'p Point> + Clone, threshold: f64) -> f64 {
    let levels = points.filter(|point| point.total > 0 && point.is_target()).map(|point| point.x);
    let below = levels.clone().filter(|level| *level <= threshold).fold(f64::NAN, f64::max);
    levels.filter(|level| *level >= threshold).fold(f64::NAN, f64::min) - below
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
#[derive(Clone, Copy, Debug, PartialEq)]
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
        let has_blocks = model.overdispersed && points.iter().any(|point| point.total > 1);
        let max_overdispersion = f64::from(u8::from(has_blocks));
        Ok(Self { range, least_width, has_free_guess, max_lapse, max_overdispersion })
    }

    /// The logarithm of the density of the parameters, except for a constant.
    pub fn ln_density(&self, at: &Estimate) -> f64 {
        let shares = [at.lapse, if self.has_free_guess { at.guess } else { 0.0 }, at.overdispersion];
        let greatest = [self.max_lapse, MAX_LAPSE, 1.0];
        if shares.iter().zip(greatest).any(|(share, greatest)| *share >= greatest) {
            return f64::NEG_INFINITY;
        }
        self.ln_place(at.threshold, at.width) + shares.into_iter().map(Self::ln_share).sum::<f64>()
    }

    /// The part of λ, of a free γ, or of η.
    pub fn ln_share(share: f64) -> f64 {
        (SHARPNESS - 1.0) * (-share).ln_1p()
    }

    /// The part of the threshold and the width.
    pub fn ln_place(&self, threshold: f64, width: f64) -> f64 {
        let [low, high] = self.range;
        let (span, least) = (high - low, self.least_width);
        let fall = |share: f64| if share < 1.0 { ((1.0 + (PI * share).cos()) / 2.0).ln() } else { f64::NEG_INFINITY };
        let outside = (low - threshold).max(threshold - high).max(0.0);
        let beyond = if width >= span { (width - span) / (2.0 * span) } else { (2.0 - width / least).max(0.0) };
        fall(2.0 * outside / span) + fall(beyond)
    }

    /// The bounds of the threshold, the logarithm of the width, λ, γ and η.
    pub fn bounds(&self) -> [[f64; 2]; 5] {
        let [low, high] = self.range;
        let span = high - low;
        let guess = if self.has_free_guess { MAX_LAPSE } else { 0.0 };
        let width = [self.least_width.ln(), (3.0 * span).ln()];
        let shares = [self.max_lapse, guess, self.max_overdispersion].map(|most| [0.0, most]);
        [[low - span / 2.0, high + span / 2.0], width, shares[0], shares[1], shares[2]]
    }
}

/// Returns the logarithm of the beta-binomial likelihood of these points for F at each of them, without the binomial
/// coefficients and the term of [`ln_total`], for 1/ν = `step`; 0 is the binomial distribution. The probability is
/// Π(ψ + j/ν)·Π(1 − ψ + j/ν)/Π(1 + j/ν), over the correct answers, the others, and all.
pub(super) fn ln_likelihood(
    points: &[Point],
    sigmoids: impl IntoIterator<Item = f64>,
    [guess, lapse]: [f64; 2],
    step: f64,
) -> f64 {
    let mut product = Product { factor: 1.0, ln: 0.0 };
    for (point, sigmoid) in points.iter().zip(sigmoids) {
        let chance = guess + (1.0 - guess - lapse) * sigmoid;
        product.multiply(chance, step, point.correct);
        product.multiply(1.0 - chance, step, point.total - point.correct);
    }
    product.ln + product.factor.ln()
}

/// Returns the logarithm of the denominators of the beta-binomial probabilities, with a negative sign.
pub(super) fn ln_total(points: &[Point], step: f64) -> f64 {
    let mut product = Product { factor: 1.0, ln: 0.0 };
    points.iter().for_each(|point| product.multiply(1.0, step, point.total));
    -(product.ln + product.factor.ln())
}

/// Returns the logarithm of the binomial likelihood of these points, without the coefficients.
pub(super) fn ln_binomial(model: &Model, points: &[Point], at: &Estimate) -> f64 {
    ln_likelihood(points, model.sigmoids(points, at.threshold, at.width), [at.guess, at.lapse], 0.0)
}

/// Returns 1/ν for η; 0 where the beta-binomial distribution is binomial in floating point, as in psignifit.
pub(super) fn step_of(eta: f64) -> f64 {
    let square = eta * eta;
    if square <= 1e-9 { 0.0 } else { square / (1.0 - square) }
}

/// A product whose logarithm is wanted. Few logarithms are computed.
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

/// The parameters as coordinates of a grid: the threshold, the logarithm of the width, λ, γ and η. With the priors'
/// distribution functions in place of the last three, nodes would miss large values, which only some answers need.
pub(super) type Place = [f64; 5];

/// The axes of a grid.
pub(super) const THRESHOLD: usize = 0;
pub(super) const WIDTH: usize = 1;
const LAPSE: usize = 2;
const GUESS: usize = 3;
const ETA: usize = 4;
/// Numbers of nodes of the grids that find the region, and of the last grid with and without a free γ.
const COARSE: [usize; 5] = [13, 13, 4, 4, 5];
const FREE: [usize; 5] = [26, 26, 6, 6, 4];
const FIXED: [usize; 5] = [28, 28, 10, 1, 6];
/// The grid leaves out where the marginal density is lower than this share of its highest value: for the first two axes,
/// and for the others.
const NEGLIGIBLE: [f64; 2] = [1e-3, 5e-3];
/// Maxima whose logarithm is lower than the highest by more than this are not the start of the grid.
const FAR: f64 = 10.0;
/// Maximum number of grids that find the region.
const MAX_ROUNDS: usize = 12;

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
        let sigmoids = self.model.sigmoids(&self.points, at.threshold, at.width);
        let step = step_of(at.overdispersion);
        prior + ln_likelihood(&self.points, sigmoids, [at.guess, at.lapse], step) + ln_total(&self.points, step)
    }

    /// Returns the most probable parameters.
    pub fn most_probable(&self) -> Estimate {
        self.at(&self.maxima()[0].1)
    }

    /// Searches for maxima of the density from several starts: it can have one with few lapses and another one with many,
    /// one with η = 0 and another one above, or one of a function that rises between two levels. The highest comes first.
    pub fn maxima(&self) -> Vec<(f64, Place)> {
        let bounds = self.priors.bounds();
        let within = |axis: usize, share: f64| bounds[axis][0] + share * (bounds[axis][1] - bounds[axis][0]);
        let node = |i: u32, j: u32| [within(THRESHOLD, f64::from(i) / 12.0), within(WIDTH, f64::from(j) / 12.0)];
        let grid: Vec<[f64; 2]> = (1..12).flat_map(|i| (1..12).map(move |j| (i, j))).map(|(i, j)| node(i, j)).collect();
        // A grid can miss them, because their thresholds lie in a narrow range. Levels with one trial do not count: there is
        // always a step that tells some of their answers apart, and it says nothing about the function.
        let points = self.points.iter().filter(|point| point.is_target());
        let mut shown: Vec<f64> = points.flat_map(|point| vec![point.x; point.total.min(2) as usize]).collect();
        shown.sort_by(f64::total_cmp);
        let levels: Vec<f64> =
            shown.chunk_by(|a, b| a == b).filter(|same| same.len() > 1).map(|same| same[0]).collect();
        let least = bounds[WIDTH][0] + 1.5_f64.ln();
        let step = |pair: &[f64]| [f64::midpoint(pair[0], pair[1]), ((pair[1] - pair[0]) / 2.0).ln().max(least)];
        let steps: Vec<[f64; 2]> = levels.windows(2).map(step).collect();
        let searched = |(nodes, [lapse, eta]): (&Vec<[f64; 2]>, [f64; 2])| {
            let start = |[threshold, ln_width]: &[f64; 2]| {
                [*threshold, *ln_width, within(LAPSE, lapse), within(GUESS, 0.04), eta]
            };
            Some(self.search(&self.highest_first(nodes.iter().map(start)).first()?.1))
        };
        let etas = if bounds[ETA][1] > 0.0 { &[0.0, 0.1, 0.3][..] } else { &[0.0] };
        let shares = etas.iter().map(|&eta| [0.03, eta]).chain([[0.0, 0.0], [0.08, 0.0], [0.3, 0.0]]);
        let from_steps = [[0.03, 0.0], [0.0, 0.0]].map(|shares| (&steps, shares));
        self.highest_first(shares.map(|shares| (&grid, shares)).chain(from_steps).filter_map(searched))
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

    /// Computes the mass at each node of a grid over the region in which the density is not negligible. The search
    /// begins around the maxima, because a grid over all parameters would miss a narrow one.
    pub fn masses(&self, maxima: &[(f64, Place)]) -> Masses {
        let all = self.priors.bounds();
        let near = maxima.iter().filter(|(ln, _)| *ln > maxima[0].0 - FAR).map(|(_, place)| self.surroundings(place));
        let hull = |[low, high]: [f64; 2], other: [f64; 2]| [low.min(other[0]), high.max(other[1])];
        let empty = all.map(|[low, high]| [high, low]);
        let mut bounds = near.fold(empty, |bounds, other| from_fn(|axis| hull(bounds[axis], other[axis])));
        for _ in 0..MAX_ROUNDS {
            let masses = self.masses_at(&bounds, COARSE);
            let next: [[f64; 2]; 5] = from_fn(|axis| masses.region(axis, bounds[axis], all[axis]));
            let shift = |axis: usize| (0..2).map(|end| (bounds[axis][end] - next[axis][end]).abs()).fold(0.0, f64::max);
            let has_changed = (0..5).any(|axis| shift(axis) > 0.1 * (bounds[axis][1] - bounds[axis][0]));
            bounds = next;
            if !has_changed {
                break;
            }
        }
        self.masses_at(&bounds, if self.priors.has_free_guess { FREE } else { FIXED })
    }

    /// Returns, for each axis, how far from a maximum the density remains high if the other parameters do not change.
    fn surroundings(&self, center: &Place) -> [[f64; 2]; 5] {
        let least = self.ln_density(center) - 2.0;
        let bounds = self.priors.bounds();
        from_fn(|axis| {
            bounds[axis].map(|end| {
                let mut place = *center;
                let is_high = |share: &f64| {
                    place[axis] = center[axis] + share * (end - center[axis]);
                    self.ln_density(&place) > least
                };
                // The end itself may be impossible.
                let share = (0..14).map(|halvings| 0.5_f64.powi(halvings)).find(is_high).unwrap_or(0.0);
                center[axis] + share * (end - center[axis])
            })
        })
    }

    fn masses_at(&self, bounds: &[[f64; 2]; 5], sizes: [usize; 5]) -> Masses {
        let axes: [Vec<Node>; 5] =
            from_fn(
                |axis| {
                    if axis < LAPSE { uniform(bounds[axis], sizes[axis]) } else { gauss(bounds[axis], sizes[axis]) }
                },
            );
        let [lapses, guesses] = [LAPSE, GUESS].map(|axis| &axes[axis]);
        let shares = lapses
            .iter()
            .flat_map(|lapse| guesses.iter().map(move |guess| [self.model.guess.or(guess.place), lapse.place]));
        let ln_rises = shares.clone().map(|[guess, lapse]| (-guess - lapse).ln_1p()).collect();
        // With 1/ν, and the logarithms of what these determine: the priors and a part of the likelihood.
        let of_eta = |eta: &Node| {
            let step = step_of(eta.place);
            (step, Priors::ln_share(eta.place) + ln_total(&self.points, step))
        };
        let etas: Vec<(f64, f64)> = axes[ETA].iter().map(of_eta).collect();
        let with_eta = |[guess, lapse]: [f64; 2]| {
            let prior = Priors::ln_share(guess) + Priors::ln_share(lapse);
            etas.iter().map(move |&(step, ln)| ([guess, lapse], step, prior + ln))
        };
        let each: Vec<([f64; 2], f64, f64)> = shares.flat_map(with_eta).collect();
        let mut densities = Vec::with_capacity(axes.iter().map(Vec::len).product());
        for threshold in &axes[THRESHOLD] {
            for ln_width in &axes[WIDTH] {
                let width = ln_width.place.exp();
                // The density is per unit of the logarithm.
                let prior = self.priors.ln_place(threshold.place, width) + ln_width.place;
                let sigmoids: Vec<f64> = self.model.sigmoids(&self.points, threshold.place, width).collect();
                densities.extend(each.iter().map(|&(shares, step, ln)| {
                    prior + ln + ln_likelihood(&self.points, sigmoids.iter().copied(), shares, step)
                }));
            }
        }
        Masses::new(axes, &densities, ln_rises)
    }
}

/// A node of an axis, and the weight of the density there in an integral.
struct Node {
    place: f64,
    weight: f64,
}

/// Returns equidistant nodes with the weights of the trapezoidal rule.
fn uniform([low, high]: [f64; 2], nodes: usize) -> Vec<Node> {
    let step = (high - low) / (nodes - 1) as f64;
    let weight = |i: usize| if i == 0 || i == nodes - 1 { step / 2.0 } else { step };
    (0..nodes).map(|i| Node { place: low + step * i as f64, weight: weight(i) }).collect()
}

/// Returns the Gauss–Legendre rule between two ends; a single node if they are equal.
fn gauss([low, high]: [f64; 2], nodes: usize) -> Vec<Node> {
    if low == high {
        return vec![Node { place: low, weight: 1.0 }];
    }
    let node = |(place, weight): (f64, f64)| Node { place: low + (high - low) * place, weight: (high - low) * weight };
    legendre(nodes).into_iter().map(node).collect()
}

/// The posterior mass at the nodes of a grid.
pub(super) struct Masses {
    axes: [Vec<Node>; 5],
    /// The mass at each node of each axis.
    marginals: [Vec<f64>; 5],
    /// The logarithm of 1 − γ − λ at the nodes of both.
    ln_rises: Vec<f64>,
    /// For each of these, the mass at the nodes of the width.
    widths: Vec<Vec<f64>>,
}

impl Masses {
    fn new(axes: [Vec<Node>; 5], ln_densities: &[f64], ln_rises: Vec<f64>) -> Self {
        let sizes = axes.each_ref().map(Vec::len);
        let most = ln_densities.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let mut marginals = sizes.map(|size| vec![0.0; size]);
        let mut widths = vec![vec![0.0; sizes[WIDTH]]; sizes[LAPSE] * sizes[GUESS]];
        for (mut place, ln) in ln_densities.iter().enumerate() {
            let mut nodes = [0; 5];
            for axis in (0..5).rev() {
                nodes[axis] = place % sizes[axis];
                place /= sizes[axis];
            }
            let weight: f64 = (0..5).map(|axis| axes[axis][nodes[axis]].weight).product();
            let mass = weight * (ln - most).exp();
            (0..5).for_each(|axis| marginals[axis][nodes[axis]] += mass);
            widths[nodes[LAPSE] * sizes[GUESS] + nodes[GUESS]][nodes[WIDTH]] += mass;
        }
        Self { marginals, ln_rises, widths, axes }
    }

    /// Returns the part of an axis in which the density is not negligible, with one node on either side. Where it is not
    /// negligible at an end, the part extends beyond the grid.
    fn region(&self, axis: usize, [low, high]: [f64; 2], all: [f64; 2]) -> [f64; 2] {
        let nodes = &self.axes[axis];
        let densities: Vec<f64> =
            nodes.iter().zip(&self.marginals[axis]).map(|(node, mass)| mass / node.weight).collect();
        let least = NEGLIGIBLE[usize::from(axis >= LAPSE)] * densities.iter().copied().fold(0.0, f64::max);
        let first = densities.iter().position(|density| *density > least).unwrap_or(0);
        let last = densities.iter().rposition(|density| *density > least).unwrap_or(nodes.len() - 1);
        let more = (high - low) / 2.0;
        let below = first.checked_sub(1).map_or((low - more).max(all[0]), |before| nodes[before].place);
        [below, nodes.get(last + 1).map_or((high + more).min(all[1]), |after| after.place)]
    }

    /// Returns the 95 % interval of the threshold or of the logarithm of the width.
    pub fn interval(&self, axis: usize) -> Interval {
        central(&self.axes[axis], &[(0.0, &self.marginals[axis])])
    }

    /// Returns the 95 % interval of the logarithm of the width divided by 1 − γ − λ. The slope is inversely proportional
    /// to this ratio.
    pub fn relative_width(&self) -> Interval {
        let parts = self.ln_rises.iter().zip(&self.widths).map(|(ln_rise, masses)| (-ln_rise, masses));
        central(&self.axes[WIDTH], &parts.collect::<Vec<_>>())
    }
}

/// Returns the 2.5 % and 97.5 % quantiles of a mixture. Each part is a shift and the masses at equidistant nodes, between
/// which its density is linear.
fn central(nodes: &[Node], parts: &[(f64, &Vec<f64>)]) -> Interval {
    let (first, step) = (nodes[0].place, nodes[1].place - nodes[0].place);
    let below =
        |x: f64| -> f64 { parts.iter().map(|(shift, masses)| cumulative(masses, (x - shift - first) / step)).sum() };
    let shifts = |best: fn(f64, f64) -> f64| parts.iter().map(|(shift, _)| *shift).reduce(best).unwrap_or(0.0);
    let (low, high) = (first + shifts(f64::min), nodes[nodes.len() - 1].place + shifts(f64::max));
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
