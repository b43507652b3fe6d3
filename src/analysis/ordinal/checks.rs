//! How well a model describes the data: it is compared with studies simulated from it.
//!
//! Whether ratings depend on the order of the trials, from the residuals of a model: a drift over a session, and the
//! correlation of successive trials.
//!
//! The residual of a rating is the derivative of its log-probability with respect to the location, given the participant's
//! effects. One step of Fisher scoring from these gives the drift (a score test), whose distribution comes from the signs of
//! the participants. Only what the participant and the model do not already tell about a trial's place counts, so that
//! conditions shown in blocks do not hide a drift. If the order does not matter, the residuals of a session can be
//! exchanged; the mean and the variance of the sum of the products of neighbors follow (Wald & Wolfowitz 1943, Ann. Math.
//! Stat. 14, 378).

use std::collections::HashMap;

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;
use serde::Serialize;

use super::{
    clm::{Fit, category_bounds},
    clmm::Modes,
    fitting::{Fitted, Layout, lay_out},
    interactions::{LEAST_FOR_SIGNS, sign_test},
    resampling::Simulator,
};
use crate::{
    analysis::counts::{Combinations, CountRow, Trial},
    statistics::{Interval, normal_two_sided},
};

/// Number of simulated studies for the comparison of observed with expected proportions.
const STUDIES: u64 = 200;
/// With more conditions than this, proportions are compared at the levels of the factors.
const MAX_CELLS: usize = 300;

/// Checks of a model.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Checks {
    /// Observed proportions and those in simulated studies in each condition or, if there are more than 300, at each level of
    /// each factor.
    pub proportions: Vec<Proportion>,
}

/// The proportion of ratings in a category in a condition or at a level of a factor.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Proportion {
    /// Names of the factors.
    pub factor: String,
    /// Their levels.
    pub level: String,
    pub category: String,
    pub observed: f64,
    /// The range of the middle 95 % of simulated studies.
    pub range: Interval,
}

impl Proportion {
    /// Returns whether the observed proportion lies outside the range.
    pub fn is_outside(&self) -> bool {
        self.observed < self.range.low - 1e-9 || self.observed > self.range.high + 1e-9
    }
}

impl Checks {
    /// Returns whether more proportions lie outside than chance allows: three standard deviations more than 5 % of them.
    pub fn is_poor(&self) -> bool {
        let (all, share) = (self.proportions.len() as f64, 0.05);
        let outside = self.proportions.iter().filter(|proportion| proportion.is_outside()).count() as f64;
        outside > all * share + 3.0 * (all * share * (1.0 - share)).sqrt()
    }
}

/// Compares the ratings with those of simulated studies.
pub(super) fn checks(full: &Fitted, seed: u64) -> Checks {
    let (counts, left_out) = (full.frame.counts, full.left_out());
    let described: Vec<usize> = (0..counts.factors.len()).filter(|factor| !left_out.contains(factor)).collect();
    let categories = &full.frame.categories;
    // The number of ratings in each category, one column for each condition.
    let tally = |rows: &[CountRow]| {
        let mut tally = DMatrix::zeros(categories.len(), counts.conditions.len());
        rows.iter().for_each(|row| tally[(row.rating.into(), row.condition as usize)] += row.count as f64);
        tally
    };
    let simulator = Simulator::new(full, false);
    // The streams after those of the calibration.
    let first = u64::from(u32::MAX);
    let simulate = |study: u64| tally(&simulator.ratings(seed, first + study));
    let observed = tally(&full.frame.rows);
    let studies: Vec<DMatrix<f64>> = (0..STUDIES).into_par_iter().map(simulate).collect();
    let compare = |factors: &[usize]| {
        let Combinations { all, of } = counts.combinations(factors);
        let combined = |tally: &DMatrix<f64>| {
            let mut sums = DMatrix::zeros(categories.len(), all.len());
            of.iter().zip(tally.column_iter()).for_each(|(group, own)| sums.column_mut(*group).axpy(1.0, &own, 1.0));
            sums
        };
        let (observed, studies) = (combined(&observed), studies.iter().map(combined).collect::<Vec<DMatrix<f64>>>());
        let names: Vec<&str> = factors.iter().map(|&factor| counts.factors[factor].name.as_str()).collect();
        let mut proportions = Vec::new();
        for (group, levels) in all.iter().enumerate().filter(|(_, levels)| levels[..] != [None]) {
            let n = observed.column(group).sum();
            for (category, label) in categories.iter().enumerate().filter(|_| n > 0.0) {
                let mut values: Vec<f64> = studies.iter().map(|study| study[(category, group)] / n).collect();
                values.sort_by(f64::total_cmp);
                let at = |share: f64| values[((share * values.len() as f64) as usize).min(values.len() - 1)];
                proportions.push(Proportion {
                    factor: names.join(", "),
                    level: counts.names(factors, levels).join(", "),
                    category: label.clone(),
                    observed: observed[(category, group)] / n,
                    range: Interval { low: at(0.025), high: at(0.975) },
                });
            }
        }
        proportions
    };
    let has_many = counts.combinations(&described).all.len() > MAX_CELLS;
    let each = || described.iter().flat_map(|factor| compare(&[*factor])).collect();
    Checks { proportions: if has_many { each() } else { compare(&described) } }
}

/// How ratings depend on the order of the trials.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Order {
    /// Number of ratings with a known place.
    pub ratings: u64,
    /// Change of the latent rating from the first to the last trial of a session, on the scale of the link; `None` if the
    /// effects of the model tell the place of every trial.
    pub drift: Option<f64>,
    /// Probability of a drift at least as large if the mean drift of participants is 0; `None` without a drift or with
    /// fewer than six participants.
    pub drift_p: Option<f64>,
    /// Correlation of the residuals of successive trials of a session.
    pub lag_one: f64,
    /// Two-sided probability of such a correlation if the order of the trials does not matter.
    pub lag_one_p: f64,
}

impl Order {
    /// Returns whether successive ratings are clearly related.
    pub fn is_dependent(&self) -> bool {
        self.lag_one_p < 0.05 && self.lag_one.abs() >= 0.1
    }

    /// Returns whether ratings clearly drift.
    pub fn is_drifting(&self) -> bool {
        self.drift_p.is_some_and(|p| p < 0.05) && self.drift.is_some_and(|drift| drift.abs() >= 0.5)
    }
}

/// The least share of the places that the model must leave open for a drift to be estimated.
const LEAST_LEFT: f64 = 0.01;

/// The residual of a rating.
#[derive(Clone, Copy, Default)]
struct Residual {
    score: f64,
    /// The expected information of the rating on the location.
    information: f64,
    /// The score in units of its standard deviation.
    standard: f64,
}

/// Returns the residual of a rating: of a participant and a category, given as in the frame, in a condition.
fn residuals<'a>(fitted: &'a Fitted, layout: &'a Layout) -> impl Fn(usize, u32, usize) -> Residual + use<'a> {
    let Layout { data, row_of } = layout;
    let mixed = fitted.usable();
    let parameters = fitted.searched(data);
    let (location, weights) = (data.location(&parameters), data.weights(&parameters));
    let (own, _) = fitted.random.effects();
    let people = fitted.frame.subjects.len();
    // With items, the effects of all participants stand one after the other, and then those of the items.
    let mode = move |modes: &Modes, subject: usize, slot: usize| match fitted.random.is_crossed() {
        false => modes[subject][slot],
        true if slot < own => modes[0][subject * own + slot],
        true => modes[0][people * own + slot - own],
    };
    move |subject, condition, category| {
        let (row, slots) = (row_of[condition as usize], data.loadings.slots_per_row);
        let slots = weights[row * slots..(row + 1) * slots].iter();
        let effect = |mixed: &Fit| slots.map(|(slot, weight)| weight * mode(&mixed.modes, subject, *slot)).sum();
        let at = location[row] + mixed.map_or(0.0, effect);
        let cell = |category| {
            let (a, b) = category_bounds(&parameters.as_slice()[..data.thresholds()], category);
            let cell = data.link.cell(a - at, b - at);
            (cell.log_p.exp(), -cell.a - cell.b)
        };
        let information = (0..data.categories).map(cell).map(|(p, score)| p * score * score).sum::<f64>();
        let (_, score) = cell(category);
        Residual { score, information, standard: score / information.sqrt() }
    }
}

/// A rating in the order of the trials.
struct Timed {
    subject: usize,
    /// The row of the design.
    row: usize,
    /// The place in the session, −½…½.
    x: f64,
    residual: Residual,
}

/// Subtracts from each place what the participant and the location of the model tell about it: the weighted regression on
/// both.
fn project(timed: &mut [Timed], design: &DMatrix<f64>) {
    let terms = design.ncols();
    let row = |one: &Timed| design.row(one.row).transpose();
    let mut means = HashMap::new();
    let (mut normal, mut right) = (DMatrix::zeros(terms, terms), DVector::zeros(terms));
    for own in timed.chunk_by_mut(|l, r| l.subject == r.subject) {
        let all: f64 = own.iter().map(|one| one.residual.information).sum();
        let share = |one: &Timed| one.residual.information / all;
        let mean = own.iter().map(|one| row(one) * share(one)).sum::<DVector<f64>>();
        let mean_x: f64 = own.iter().map(|one| one.x * share(one)).sum();
        for one in &mut *own {
            one.x -= mean_x;
            let centered = row(one) - &mean;
            normal.ger(one.residual.information, &centered, &centered, 1.0);
            right.axpy(one.residual.information * one.x, &centered, 1.0);
        }
        means.insert(own[0].subject, mean);
    }
    // A term that is constant within participants tells nothing more.
    let tolerance = 1e-9 * normal.diagonal().max();
    // Without terms, there is no matrix to invert.
    let inverse = if terms > 0 { normal.pseudo_inverse(tolerance).ok() } else { None };
    let slopes = inverse.map_or_else(|| DVector::zeros(terms), |inverse| inverse * right);
    for one in timed {
        one.x -= (row(one) - &means[&one.subject]).dot(&slopes);
    }
}

/// Measures how ratings depend on the order of the trials; `None` if no session has several trials with known places.
pub(super) fn order(fitted: &Fitted, trials: &[Trial], seed: u64) -> Option<Order> {
    let counts = fitted.frame.counts;
    let place = |name: &String| fitted.frame.categories.iter().position(|own| own == name);
    let categories: Vec<Option<usize>> = counts.categories.iter().map(place).collect();
    let conditions = fitted.frame.conditions();
    let occurs = |trial: &&Trial| conditions.binary_search(&trial.condition).is_ok();
    let placed = trials.iter().filter(occurs).filter_map(|trial| Some((trial.position?, trial)));
    let mut placed: Vec<(f64, &Trial)> = placed.collect();
    let session = |(_, trial): &(f64, &Trial)| (trial.subject, trial.session);
    placed.sort_by(|l, r| session(l).cmp(&session(r)).then(l.0.total_cmp(&r.0)));
    let layout = lay_out(fitted, false);
    let residual = residuals(fitted, &layout);
    let mut scores = vec![0.0; fitted.frame.subjects.len()];
    let mut timed = Vec::new();
    let (mut products, mut expected, mut variance, mut squares) = (0.0, 0.0, 0.0, 0.0);
    for session in placed.chunk_by(|l, r| session(l) == session(r)) {
        let Ok(subject) = fitted.frame.subjects.binary_search(&session[0].1.subject) else { continue };
        let own = |(_, trial): &(f64, &Trial)| {
            let category = categories[usize::from(trial.rating)]?;
            Some((layout.row_of[trial.condition as usize], residual(subject, trial.condition, category)))
        };
        let own: Vec<(usize, Residual)> = session.iter().filter_map(own).collect();
        // The variance below needs four trials.
        if own.len() < 4 {
            continue;
        }
        let n = own.len() as f64;
        timed.extend(own.iter().enumerate().map(|(index, &(row, residual))| {
            let x = index as f64 / (n - 1.0) - 0.5;
            Timed { subject, row, x, residual }
        }));
        let mean = own.iter().map(|(_, residual)| residual.standard).sum::<f64>() / n;
        let centered: Vec<f64> = own.iter().map(|(_, residual)| residual.standard - mean).collect();
        let sum = |power: i32| centered.iter().map(|e| e.powi(power)).sum::<f64>();
        let (s2, s4) = (sum(2), sum(4));
        let own_expected = -s2 / n;
        let second = (s2 * s2 - s4) / n
            + 2.0 * (2.0 * s4 - s2 * s2) / (n * (n - 1.0))
            + (3.0 * s2 * s2 - 6.0 * s4) / (n * (n - 1.0));
        products += centered.windows(2).map(|pair| pair[0] * pair[1]).sum::<f64>();
        expected += own_expected;
        variance += second - own_expected * own_expected;
        squares += s2;
    }
    let information = |timed: &[Timed]| timed.iter().map(|one| one.residual.information * one.x.powi(2)).sum::<f64>();
    let whole = information(&timed);
    if timed.is_empty() || variance <= 0.0 || whole <= 0.0 {
        return None;
    }
    project(&mut timed, &layout.data.x);
    timed.iter().for_each(|one| scores[one.subject] += one.residual.score * one.x);
    let left = information(&timed);
    // Where each condition has its place, a drift cannot be told from an effect.
    let is_told = left > LEAST_LEFT * whole;
    Some(Order {
        ratings: timed.len() as u64,
        drift: is_told.then(|| scores.iter().sum::<f64>() / left),
        drift_p: (is_told && scores.len() >= LEAST_FOR_SIGNS).then(|| {
            let observed = scores.iter().sum::<f64>().powi(2);
            sign_test(&DMatrix::from_row_slice(1, scores.len(), &scores), observed, seed).0
        }),
        lag_one: (products - expected) / squares,
        lag_one_p: normal_two_sided((products - expected) / variance.sqrt()),
    })
}
