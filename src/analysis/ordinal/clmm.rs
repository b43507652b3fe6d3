//! The cumulative-link mixed model P(Y ≤ j | u) = F(θ_j − xβ − σu) with u ~ N(0, 1) for every subject, fitted on counts.
//!
//! A subject's likelihood is the integral over u, by Laplace's approximation (one node) or adaptive Gauss–Hermite
//! quadrature around the mode (Liu & Pierce 1994). Its gradient is analytic, including how the mode and the curvature
//! there move with the parameters: it is the gradient of the number that is maximized, not of the exact integral.

use std::ops::Range;

use nalgebra::{DMatrix, DVector};

use super::{
    clm::{add_product, category_bounds},
    kernel::{Observation, Point, ShiftSums, Subject, Width, widths},
    link::{Link, Shift},
    quadrature::Node,
};

/// A mixed model's data.
#[derive(Clone, Debug)]
pub(super) struct ClmmData {
    pub link: Link,
    pub categories: usize,
    /// Location, one row a distinct condition.
    pub x: DMatrix<f64>,
    /// All subjects' observations, one subject after the other.
    pub observations: Vec<Observation>,
    /// Where each subject's observations are.
    pub subjects: Vec<Range<usize>>,
    /// The quadrature rule.
    pub nodes: Vec<Node>,
}

/// Where the modes are, kept from one evaluation to the next as starting values.
#[derive(Clone, Debug)]
pub(super) struct Modes {
    pub u: Vec<f64>,
    /// Minus the second derivative of the log-integrand there.
    pub curvature: Vec<f64>,
}

/// Log-likelihood and gradient by θ, β, σ.
#[derive(Clone, Debug)]
pub(super) struct Evaluation {
    pub loglik: f64,
    pub gradient: DVector<f64>,
}

/// What the nodes add up to, relative to the mode.
#[derive(Clone, Copy, Default)]
struct NodeSums {
    /// Σ w e^(h − h at the mode): 1 for Laplace.
    total: f64,
    /// The mean of h′(u) over the nodes, and of h′(u) z.
    slope: f64,
    slope_z: f64,
    /// The mean of ∂h/∂σ.
    sigma: f64,
}

impl ClmmData {
    fn thresholds(&self) -> usize {
        self.categories - 1
    }

    /// θ, β and σ.
    pub fn parameters(&self) -> usize {
        self.thresholds() + self.x.ncols() + 1
    }

    pub fn ratings(&self) -> f64 {
        self.observations.iter().map(|observation| observation.count).sum()
    }

    /// Modes at 0.
    pub fn modes(&self) -> Modes {
        Modes { u: vec![0.0; self.subjects.len()], curvature: vec![1.0; self.subjects.len()] }
    }

    /// xβ for every design row, and the widths of the categories.
    fn prepare(&self, parameters: &DVector<f64>) -> (DVector<f64>, Vec<Width>) {
        let thresholds = self.thresholds();
        let location = &self.x * parameters.rows(thresholds, self.x.ncols());
        (location, widths(&parameters.as_slice()[..thresholds]))
    }

    fn point<'a>(&self, parameters: &'a DVector<f64>, prepared: &'a (DVector<f64>, Vec<Width>)) -> Point<'a> {
        Point {
            link: self.link,
            thresholds: &parameters.as_slice()[..self.thresholds()],
            sigma: parameters[parameters.len() - 1],
            location: prepared.0.as_slice(),
            widths: &prepared.1,
        }
    }

    /// The approximated log-likelihood and its gradient, or None where a rating that occurs has no probability.
    pub fn evaluate(&self, parameters: &DVector<f64>, modes: &mut Modes) -> Option<Evaluation> {
        let prepared = self.prepare(parameters);
        let point = self.point(parameters, &prepared);
        if point.thresholds.windows(2).any(|pair| pair[0] >= pair[1]) {
            return None;
        }
        let mut sums = Sums { theta: vec![0.0; self.thresholds()], rows: vec![0.0; self.x.nrows()], sigma: 0.0 };
        let mut work = Work::default();
        let mut loglik = 0.0;
        for (index, range) in self.subjects.iter().enumerate() {
            let observations = &self.observations[range.clone()];
            work.subject.set(&point, observations);
            let u = mode(&point, &work.subject, modes.u[index], &mut work.shifts)?;
            let (value, curvature) = self.subject(&point, observations, u, &mut sums, &mut work)?;
            (modes.u[index], modes.curvature[index]) = (u, curvature);
            loglik += value;
        }
        let mut gradient = DVector::zeros(self.parameters());
        let thresholds = self.thresholds();
        gradient.rows_mut(0, thresholds).copy_from_slice(&sums.theta);
        let beta = self.x.tr_mul(&DVector::from_vec(sums.rows));
        gradient.rows_mut(thresholds, beta.len()).copy_from(&-beta);
        gradient[thresholds + self.x.ncols()] = sums.sigma;
        (loglik.is_finite() && gradient.iter().all(|g| g.is_finite())).then_some(Evaluation { loglik, gradient })
    }

    /// A subject's log-likelihood and the curvature at the mode; adds the gradient to the sums.
    fn subject(
        &self,
        point: &Point,
        observations: &[Observation],
        u: f64,
        sums: &mut Sums,
        work: &mut Work,
    ) -> Option<(f64, f64)> {
        let sigma = point.sigma;
        let at = work.subject.at(point, u, &mut work.shifts);
        let h = at.log_p - 0.5 * u * u;
        let curvature = 1.0 - sigma * sigma * at.g2;
        let spread = curvature.sqrt().recip();
        let nodes = self.integrate(point, u, h, spread, at, work)?;

        // How the mode and the spread move the nodes: weights of h_uψ and of h_uuψ.
        let third = 0.5 * (nodes.slope_z * spread + 1.0) / curvature;
        let second = (nodes.slope - third * sigma.powi(3) * at.g3) / curvature;
        let (by_mode, by_spread) = (-sigma * second, sigma * sigma * third);
        for ((observation, shift), mean) in observations.iter().zip(&work.shifts).zip(&work.means) {
            let (count, width) = (observation.count, Subject::width(point, observation));
            let upper = count * (mean.0 + width + by_mode * shift.g1_a + by_spread * shift.g2_a);
            let lower = count * (mean.1 - width + by_mode * shift.g1_b + by_spread * shift.g2_b);
            if observation.category < sums.theta.len() {
                sums.theta[observation.category] += upper;
            }
            if observation.category > 0 {
                sums.theta[observation.category - 1] += lower;
            }
            sums.rows[observation.row] += upper + lower;
        }
        sums.sigma += nodes.sigma
            + second * (-at.g1 + sigma * u * at.g2)
            + third * (2.0 * sigma * at.g2 - sigma * sigma * u * at.g3);
        Some((h + (spread * nodes.total).ln(), curvature))
    }

    /// Sums over the nodes; leaves the mean ∂g/∂a and ∂g/∂b of every observation in `work.means`.
    fn integrate(
        &self,
        point: &Point,
        u: f64,
        h: f64,
        spread: f64,
        at: ShiftSums,
        work: &mut Work,
    ) -> Option<NodeSums> {
        work.means.clear();
        if self.nodes.len() == 1 {
            work.means.extend(work.shifts.iter().map(|shift| (shift.a, shift.b)));
            return Some(NodeSums { total: 1.0, sigma: -u * at.g1, ..NodeSums::default() });
        }
        let mut sums = NodeSums::default();
        work.means.resize(work.shifts.len(), (0.0, 0.0));
        for node in &self.nodes {
            let value = u + spread * node.z;
            let ShiftSums { log_p, g1, .. } = work.subject.at(point, value, &mut work.at_node);
            let weight = node.weight * (log_p - 0.5 * value * value - h).exp();
            // A node too far out has no weight, and maybe no finite derivatives.
            if weight == 0.0 || weight.is_nan() {
                continue;
            }
            let slope_u = -point.sigma * g1 - value;
            sums.total += weight;
            sums.slope += weight * slope_u;
            sums.slope_z += weight * slope_u * node.z;
            sums.sigma -= weight * value * g1;
            for (mean, shift) in work.means.iter_mut().zip(&work.at_node) {
                mean.0 += weight * shift.a;
                mean.1 += weight * shift.b;
            }
        }
        let total = sums.total;
        for mean in &mut work.means {
            *mean = (mean.0 / total, mean.1 / total);
        }
        sums.slope /= total;
        sums.slope_z /= total;
        sums.sigma /= total;
        (total > 0.0 && total.is_finite()).then_some(sums)
    }

    /// The information that a search begins with: the curvature of the integrand profiled over the modes, and for σ
    /// that of log det too, whose second derivative is what keeps σ from 0.
    pub fn rough_information(&self, parameters: &DVector<f64>, modes: &Modes) -> DMatrix<f64> {
        let (size, thresholds) = (self.parameters(), self.thresholds());
        let (thetas, sigma) = (&parameters.as_slice()[..thresholds], parameters[size - 1]);
        let (location, _) = self.prepare(parameters);
        let mut sum = DMatrix::zeros(size, size);
        for (index, range) in self.subjects.iter().enumerate() {
            let (u, curvature) = (modes.u[index], modes.curvature[index]);
            let mut by_mode = DVector::zeros(size);
            let mut g1 = 0.0;
            for observation in &self.observations[range.clone()] {
                let (a, b) = category_bounds(thetas, observation.category);
                let shift = location[observation.row] + sigma * u;
                let (a, b) = (a - shift, b - shift);
                let cell = self.link.cell(a, b);
                let mut shift = DVector::zeros(size);
                for c in 0..self.x.ncols() {
                    shift[thresholds + c] = -self.x[(observation.row, c)];
                }
                shift[size - 1] = -u;
                let (mut upper, mut lower) = (shift.clone(), shift);
                if observation.category < thresholds {
                    upper[observation.category] = 1.0;
                }
                if observation.category > 0 {
                    lower[observation.category - 1] = 1.0;
                }
                let count = observation.count;
                add_product(&mut sum, -count * cell.aa, &upper, &upper);
                add_product(&mut sum, -count * cell.bb, &lower, &lower);
                add_product(&mut sum, -count * cell.ab, &upper, &lower);
                add_product(&mut sum, -count * cell.ab, &lower, &upper);
                by_mode.axpy(-sigma * count * (cell.aa + cell.ab), &upper, 1.0);
                by_mode.axpy(-sigma * count * (cell.ab + cell.bb), &lower, 1.0);
                g1 += count * (cell.a + cell.b);
            }
            by_mode[size - 1] -= g1;
            add_product(&mut sum, -1.0 / curvature, &by_mode, &by_mode);
            // log D = log(1 + σ²I): its second derivative by σ, with I held.
            let information = (curvature - 1.0) / (sigma * sigma).max(1e-12);
            sum[(size - 1, size - 1)] += information * (1.0 - sigma * sigma * information) / (curvature * curvature);
        }
        sum
    }
}

/// Sums of the gradient: by threshold, by design row, by σ.
struct Sums {
    theta: Vec<f64>,
    rows: Vec<f64>,
    sigma: f64,
}

/// Room for one subject's observations, used again for the next.
#[derive(Default)]
struct Work {
    subject: Subject,
    /// Derivatives at the mode, and at one node.
    shifts: Vec<Shift>,
    at_node: Vec<Shift>,
    /// Means of ∂g/∂a and ∂g/∂b over the nodes.
    means: Vec<(f64, f64)>,
}

/// The mode of a subject's log-integrand, which is concave: Newton's method, halved while the slope grows.
fn mode(point: &Point, subject: &Subject, start: f64, shifts: &mut Vec<Shift>) -> Option<f64> {
    let sigma = point.sigma;
    let mut slope_at = |u: f64| {
        let ShiftSums { g1, g2, .. } = subject.at(point, u, shifts);
        (-sigma * g1 - u, sigma * sigma * g2 - 1.0)
    };
    let mut u = start;
    let (mut slope, mut curvature) = slope_at(u);
    if !(slope.is_finite() && curvature.is_finite()) {
        u = 0.0;
        (slope, curvature) = slope_at(u);
    }
    for _ in 0..100 {
        let mut step = -slope / curvature;
        // Newton's error after a step is of the order of its square.
        if step.abs() < 1e-9 * (1.0 + u.abs()) {
            return Some(u + step);
        }
        loop {
            let (next_slope, next_curvature) = slope_at(u + step);
            if next_slope.abs() < slope.abs() && next_curvature.is_finite() {
                u += step;
                (slope, curvature) = (next_slope, next_curvature);
                break;
            }
            step /= 2.0;
            // Rounding is reached; a slope that is not a number ends here too.
            if step.is_nan() || step.abs() < 1e-13 * (1.0 + u.abs()) {
                return slope.is_finite().then_some(u);
            }
        }
    }
    None
}
