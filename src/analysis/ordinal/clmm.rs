//! The cumulative-link mixed model P(Y ≤ j | u) = F(θ_j − xβ − aᵀu) with standard normal effects u for each participant,
//! fitted to counts. The weights a of the effects depend on the design row and on the parameters ψ (see
//! [`Loadings`](super::random::Loadings)).
//!
//! A participant's likelihood is the integral over u, approximated by Laplace's method. The gradient is analytic and
//! accounts for how the mode and the curvature at the mode change with the parameters: it is the gradient of the
//! approximation that is maximized, not of the exact integral.

use std::ops::Range;

use nalgebra::{DMatrix, DVector};
use rayon::prelude::*;

use super::{
    arrow::Factor,
    clm::category_bounds,
    link::{Category, Link, Shift},
    random::Loadings,
};

/// Equal ratings by a participant in one design row.
#[derive(Clone, Copy, Debug)]
pub(super) struct Observation {
    /// Row of the design matrix.
    pub row: usize,
    pub category: usize,
    pub count: f64,
}

/// The data of a mixed model.
#[derive(Clone, Debug)]
pub(super) struct ClmmData {
    pub link: Link,
    pub categories: usize,
    /// Location; one row per distinct condition.
    pub x: DMatrix<f64>,
    /// A known part of the location.
    pub offset: DVector<f64>,
    /// How the effects of a participant enter each row.
    pub loadings: Loadings,
    /// All observations, grouped by participant and sorted by row.
    pub observations: Vec<Observation>,
    /// The range of each participant's observations.
    pub subjects: Vec<Range<usize>>,
}

/// Number of participants that are evaluated in one thread.
const TOGETHER: usize = 48;

/// The mode of each participant's integrand, kept from one evaluation to the next as starting values.
pub(super) type Modes = Vec<DVector<f64>>;

/// The log-likelihood and its gradient with respect to θ, β and ψ.
#[derive(Clone, Debug)]
pub(super) struct Evaluation {
    pub loglik: f64,
    pub gradient: DVector<f64>,
}

/// One participant's observations at the current parameters.
struct Subject<'a> {
    link: Link,
    loadings: &'a Loadings,
    /// The effects in each row, with their weights.
    weights: &'a [(usize, f64)],
    observations: &'a [Observation],
    /// The category of each observation at u = 0.
    categories: Vec<Category>,
}

/// Sums over the observations in one row of the log-probability and its derivatives with respect to a shift of the
/// bounds, each weighted by the count.
#[derive(Clone, Copy, Default)]
struct RowSums {
    row: usize,
    log_p: f64,
    g1: f64,
    g2: f64,
    g3: f64,
}

/// A participant's integrand at one u.
struct Point {
    shifts: Vec<Shift>,
    rows: Vec<RowSums>,
    /// The log-integrand.
    h: f64,
}

impl Subject<'_> {
    /// Returns aᵀu in a row.
    fn effect(&self, row: usize, u: &DVector<f64>) -> f64 {
        self.weights_of(row).iter().map(|&(effect, weight)| weight * u[effect]).sum()
    }

    fn weights_of(&self, row: usize) -> &[(usize, f64)] {
        let slots = self.loadings.slots_per_row;
        &self.weights[row * slots..(row + 1) * slots]
    }

    /// Evaluates the log-integrand.
    fn at(&self, u: &DVector<f64>) -> Point {
        let mut rows: Vec<RowSums> = Vec::with_capacity(self.observations.len());
        let (mut by, mut up) = (0.0, 1.0);
        let mut shifts = Vec::with_capacity(self.observations.len());
        for (category, &Observation { row, count, .. }) in self.categories.iter().zip(self.observations) {
            if rows.last().is_none_or(|last| last.row != row) {
                by = self.effect(row, u);
                up = by.exp();
                rows.push(RowSums { row, ..RowSums::default() });
            }
            let shift = self.link.shift(category, by, up);
            if let Some(sums) = rows.last_mut() {
                sums.log_p += count * shift.log_p;
                sums.g1 += count * shift.g1;
                sums.g2 += count * shift.g2;
                sums.g3 += count * shift.g3;
            }
            shifts.push(shift);
        }
        let h = rows.iter().map(|sums| sums.log_p).sum::<f64>() - 0.5 * u.norm_squared();
        Point { shifts, rows, h }
    }

    /// Returns the gradient of the log-integrand and the factor of its negative Hessian.
    fn slope_and_curvature(&self, u: &DVector<f64>, point: &Point) -> Option<(DVector<f64>, Factor)> {
        let mut slope = -u;
        let mut curvature = DMatrix::identity(u.len(), u.len());
        for sums in &point.rows {
            let weights = self.weights_of(sums.row);
            for &(i, wi) in weights {
                slope[i] -= sums.g1 * wi;
                let (column, by) = (&mut curvature.as_mut_slice()[i * u.len()..], sums.g2 * wi);
                for &(j, wj) in weights {
                    column[j] -= by * wj;
                }
            }
        }
        Some((slope, Factor::new(curvature, self.loadings.blocks)?))
    }

    /// Finds the mode of the log-integrand, which is concave, by Newton's method. A step is halved until it raises the
    /// log-integrand.
    fn mode(&self, start: &DVector<f64>) -> Option<DVector<f64>> {
        let mut u = start.clone();
        let mut point = self.at(&u);
        if !point.h.is_finite() {
            u.fill(0.0);
            point = self.at(&u);
        }
        for _ in 0..100 {
            let (slope, curvature) = self.slope_and_curvature(&u, &point)?;
            let mut step = curvature.solve(&slope);
            // After a Newton step, the error is of the order of the step squared.
            let scale = 1.0 + u.amax();
            if step.amax() < 3e-6 * scale {
                return Some(u + step);
            }
            loop {
                let next = &u + &step;
                let at = self.at(&next);
                if at.h >= point.h - 1e-13 * point.h.abs() {
                    (u, point) = (next, at);
                    break;
                }
                step /= 2.0;
                // The limit of precision is reached, or the integrand is not a number.
                if step.amax().is_nan() || step.amax() < 1e-13 * scale {
                    return point.h.is_finite().then_some(u);
                }
            }
        }
        None
    }
}

impl ClmmData {
    pub fn thresholds(&self) -> usize {
        self.categories - 1
    }

    /// Returns the index of the first ψ.
    pub fn first_psi(&self) -> usize {
        self.thresholds() + self.x.ncols()
    }

    /// Returns the number of parameters: θ, β and ψ.
    pub fn parameters(&self) -> usize {
        self.first_psi() + self.loadings.parameters
    }

    pub fn ratings(&self) -> f64 {
        self.observations.iter().map(|observation| observation.count).sum()
    }

    /// Returns starting values for the modes: 0 for every participant.
    pub fn modes(&self) -> Modes {
        vec![DVector::zeros(self.loadings.effects()); self.subjects.len()]
    }

    /// Returns xβ and the known part of the location for each design row.
    pub fn location(&self, parameters: &DVector<f64>) -> DVector<f64> {
        &self.offset + &self.x * parameters.rows(self.thresholds(), self.x.ncols())
    }

    /// Returns the effects in each row, with their weights.
    pub fn weights(&self, parameters: &DVector<f64>) -> Vec<(usize, f64)> {
        self.loadings.weights(&parameters.as_slice()[self.first_psi()..])
    }

    fn subject<'a>(
        &'a self,
        range: &Range<usize>,
        thresholds: &[f64],
        location: &DVector<f64>,
        weights: &'a [(usize, f64)],
    ) -> Subject<'a> {
        let observations = &self.observations[range.clone()];
        let category = |observation: &Observation| {
            let (a, b) = category_bounds(thresholds, observation.category);
            let location = location[observation.row];
            self.link.category(a - location, b - location)
        };
        let categories = observations.iter().map(category).collect();
        Subject { link: self.link, loadings: &self.loadings, weights, observations, categories }
    }

    /// Returns the approximate log-likelihood and its gradient, or `None` if the thresholds are not increasing or a
    /// rating that occurs has a probability of 0.
    pub fn evaluate(&self, parameters: &DVector<f64>, modes: &mut Modes) -> Option<Evaluation> {
        let thresholds = &parameters.as_slice()[..self.thresholds()];
        if thresholds.windows(2).any(|pair| pair[0] >= pair[1]) {
            return None;
        }
        let (location, weights) = (self.location(parameters), self.weights(parameters));
        let of_people = |(ranges, modes): (&[Range<usize>], &mut [DVector<f64>])| {
            let mut value = Evaluation { loglik: 0.0, gradient: DVector::zeros(self.parameters()) };
            let mut by_row = DVector::zeros(self.x.nrows());
            for (range, mode) in ranges.iter().zip(modes) {
                let subject = self.subject(range, thresholds, &location, &weights);
                *mode = subject.mode(mode)?;
                self.add(&subject, mode, &mut value, &mut by_row)?;
            }
            Some((value, by_row))
        };
        // The sums do not depend on the number of threads.
        let parts = self.subjects.par_chunks(TOGETHER).zip(modes.par_chunks_mut(TOGETHER)).map(of_people);
        let mut parts = parts.collect::<Option<Vec<_>>>()?.into_iter();
        let (mut value, mut by_row) = parts.next()?;
        for (part, rows) in parts {
            value.loglik += part.loglik;
            value.gradient += part.gradient;
            by_row += rows;
        }
        value.gradient.rows_mut(thresholds.len(), self.x.ncols()).copy_from(&self.x.tr_mul(&by_row));
        (value.loglik.is_finite() && value.gradient.iter().all(|g| g.is_finite())).then_some(value)
    }

    /// Adds a participant's log-likelihood and its gradient; the gradient of the location is added to `by_row`, per
    /// design row.
    fn add(&self, subject: &Subject, u: &DVector<f64>, sum: &mut Evaluation, by_row: &mut DVector<f64>) -> Option<()> {
        let point = subject.at(u);
        let (_, factor) = subject.slope_and_curvature(u, &point)?;
        let log_determinant = factor.log_determinant();
        let inverse = factor.inverse();
        // With C = inverse curvature: Ca in the slots of each row, and aᵀCa.
        let slots = self.loadings.slots_per_row;
        let mut spread_weights = vec![0.0; point.rows.len() * slots];
        let mut variances = vec![0.0; point.rows.len()];
        // C times the derivative of the logarithm of the approximation with respect to the mode.
        let mut by_mode = DVector::zeros(u.len());
        for ((sums, spread_weights), variance) in
            point.rows.iter().zip(spread_weights.chunks_mut(slots)).zip(&mut variances)
        {
            let weights = subject.weights_of(sums.row);
            for (&(i, wi), spread) in weights.iter().zip(&mut *spread_weights) {
                let column = &inverse.as_slice()[i * u.len()..];
                *spread = weights.iter().map(|&(j, wj)| column[j] * wj).sum();
                *variance += wi * *spread;
            }
            for &(i, wi) in weights {
                by_mode[i] -= 0.5 * sums.g3 * *variance * wi;
            }
        }
        let by_mode = &inverse * by_mode;
        let mut rows = point.rows.iter().zip(spread_weights.chunks(slots)).zip(&variances);
        let (mut mode_in_row, mut variance_in_row, mut row) = (0.0, 0.0, usize::MAX);
        for (observation, shift) in subject.observations.iter().zip(&point.shifts) {
            if observation.row != row {
                let ((sums, spread_weights), variance) = rows.next()?;
                row = observation.row;
                (mode_in_row, variance_in_row) = (subject.effect(row, &by_mode), *variance);
                let weights = subject.weights_of(row);
                for entry in self.loadings.entries(row) {
                    let effect = weights[entry.slot].0;
                    let (du, ds) = (entry.value * u[effect], entry.value * by_mode[effect]);
                    let spread = 2.0 * sums.g2 * entry.value * spread_weights[entry.slot] - sums.g3 * du * variance;
                    sum.gradient[self.first_psi() + entry.parameter] +=
                        0.5 * spread - sums.g1 * du + sums.g2 * du * mode_in_row - sums.g1 * ds;
                }
            }
            let (by_mode, by_spread) = (-mode_in_row, 0.5 * variance_in_row);
            let upper = observation.count * (shift.a + by_mode * shift.g1_a + by_spread * shift.g2_a);
            let lower = observation.count * (shift.b + by_mode * shift.g1_b + by_spread * shift.g2_b);
            if observation.category < self.thresholds() {
                sum.gradient[observation.category] += upper;
            }
            if observation.category > 0 {
                sum.gradient[observation.category - 1] += lower;
            }
            by_row[observation.row] -= upper + lower;
        }
        sum.loglik += point.h - 0.5 * log_determinant;
        Some(())
    }

    /// Computes something for each participant at some parameters and modes.
    fn each<T>(&self, parameters: &DVector<f64>, modes: &Modes, of: impl Fn(&Subject, &DVector<f64>) -> T) -> Vec<T> {
        let (location, weights) = (self.location(parameters), self.weights(parameters));
        let thresholds = &parameters.as_slice()[..self.thresholds()];
        let own = |(range, mode)| of(&self.subject(range, thresholds, &location, &weights), mode);
        self.subjects.iter().zip(modes).map(own).collect()
    }

    /// Returns, for each participant and row, the derivative of the log-probability of the ratings with respect to the
    /// location, and their information on it, both at the mode.
    pub fn residuals(&self, parameters: &DVector<f64>, modes: &Modes) -> Vec<Vec<(usize, f64, f64)>> {
        self.each(parameters, modes, |subject, mode| {
            subject.at(mode).rows.into_iter().map(|sums| (sums.row, -sums.g1, -sums.g2)).collect()
        })
    }

    /// Returns, for each standard deviation of independent effects, the mean sampling variance of an effect: how
    /// uncertain it would be if only its own ratings were known. Effects of which the ratings say next to nothing, such as
    /// those at a level where all ratings are 0, say nothing about the standard deviation either.
    pub fn sampling_variances(&self, parameters: &DVector<f64>, modes: &Modes) -> Vec<f64> {
        let informations = self.each(parameters, modes, |subject, mode| {
            let mut information = vec![(0, 0.0); self.loadings.effects()];
            for sums in subject.at(mode).rows {
                for entry in self.loadings.entries(sums.row) {
                    let own = &mut information[subject.weights_of(sums.row)[entry.slot].0];
                    *own = (entry.parameter, own.1 - sums.g2 * entry.value * entry.value);
                }
            }
            information
        });
        let mut known = vec![Vec::new(); self.loadings.parameters];
        informations.into_iter().flatten().for_each(|(parameter, information)| known[parameter].push(information));
        let mean = |own: Vec<f64>| {
            let least = 0.01 * own.iter().copied().fold(0.0, f64::max);
            let variances: Vec<f64> = own.into_iter().filter(|own| *own > least).map(f64::recip).collect();
            variances.iter().sum::<f64>() / variances.len().max(1) as f64
        };
        known.into_iter().map(mean).collect()
    }
}
