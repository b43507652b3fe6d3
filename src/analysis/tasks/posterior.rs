//! The posterior density of a psychometric function: its maximum, and its mass on a grid.

use std::array::from_fn;

use super::{
    model::{Estimate, Model, Point, Priors, ln_likelihood, ln_total, step_of},
    numeric::{highest, legendre},
};
use crate::statistics::Interval;

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

    /// The bounds of the axes.
    fn bounds(&self) -> [[f64; 2]; 5] {
        // A single trial cannot vary more than binomially.
        let has_eta = self.model.overdispersed && self.points.iter().any(|point| point.total > 1);
        let mut bounds = self.priors.bounds();
        bounds[ETA][1] *= f64::from(u8::from(has_eta));
        bounds
    }

    /// Returns the parameters at a place.
    pub fn at(&self, place: &Place) -> Estimate {
        let [threshold, ln_width, lapse, guess, overdispersion] = *place;
        Estimate { threshold, width: ln_width.exp(), lapse, guess: self.model.guess.or(guess), overdispersion }
    }

    /// F at each point.
    fn sigmoids(&self, threshold: f64, width: f64) -> Vec<f64> {
        self.model.sigmoids(&self.points, threshold, width).collect()
    }

    /// The logarithm of the density of the parameters, except for a constant.
    fn ln_density(&self, place: &Place) -> f64 {
        let at = self.at(place);
        let prior = self.priors.ln_density(&at);
        if prior == f64::NEG_INFINITY {
            return prior;
        }
        let (step, sigmoids) = (step_of(at.overdispersion), self.sigmoids(at.threshold, at.width));
        prior + ln_likelihood(&self.points, sigmoids, [at.guess, at.lapse], step) + ln_total(&self.points, step)
    }

    /// Returns the most probable parameters.
    pub fn most_probable(&self) -> Estimate {
        self.at(&self.maxima()[0].1)
    }

    /// Searches for maxima of the density from several starts: it can have one with few lapses and another one with many,
    /// or one with η = 0 and another one above. The highest comes first.
    pub fn maxima(&self) -> Vec<(f64, Place)> {
        let bounds = self.bounds();
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
        let [[low, high], .., guess, _] = self.bounds();
        let place = |x: &Place| from_fn(|axis| if axis < LAPSE { x[axis] } else { x[axis].powi(2) });
        let x = from_fn(|axis| if axis < LAPSE { start[axis] } else { start[axis].sqrt() });
        let step = |is_free: bool| if is_free { 0.06 } else { 0.0 };
        let steps = [(high - low) / 40.0, 0.2, 0.06, step(guess[1] > 0.0), step(start[ETA] > 0.0)];
        place(&highest(|x| self.ln_density(&place(x)), x, steps, 1e-9).0)
    }

    /// Computes the mass at each node of a grid over the region in which the density is not negligible. The search
    /// begins around the maxima, because a grid over all parameters would miss a narrow one.
    pub fn masses(&self, maxima: &[(f64, Place)]) -> Masses {
        let all = self.bounds();
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
        let bounds = self.bounds();
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
                let sigmoids = self.sigmoids(threshold.place, width);
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
