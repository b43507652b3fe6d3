//! The cumulative-link mixed model P(Y ≤ j | u) = F(θ_j − xβ − σu) with u ~ N(0, 1) for each participant, fitted to
//! counts.
//!
//! A participant's likelihood is the integral over u. It is approximated by Laplace's method (one node) or by adaptive
//! Gauss–Hermite quadrature around the mode (Liu & Pierce 1994). The gradient is analytic and accounts for how the mode
//! and the curvature at the mode change with the parameters: it is the gradient of the approximation that is maximized,
//! not of the exact integral.

use std::ops::Range;

use nalgebra::{DMatrix, DVector};

use super::{
    clm::{add_product, category_bounds},
    link::{Category, Link, Shift},
};

/// Maximum number of quadrature nodes, far more than any likelihood here needs.
pub const MAX_NODES: usize = 100;

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
    /// All observations, grouped by participant.
    pub observations: Vec<Observation>,
    /// The range of each participant's observations.
    pub subjects: Vec<Range<usize>>,
    /// The quadrature rule.
    pub nodes: Vec<Node>,
}

/// The mode of each participant's integrand, kept from one evaluation to the next as starting values.
#[derive(Clone, Debug)]
pub(super) struct Modes {
    pub u: Vec<f64>,
    /// The negative second derivative of the log-integrand at each mode.
    pub curvature: Vec<f64>,
}

/// The log-likelihood and its gradient with respect to θ, β and σ.
#[derive(Clone, Debug)]
pub(super) struct Evaluation {
    pub loglik: f64,
    pub gradient: DVector<f64>,
}

/// One participant's observations at the current parameters.
struct Subject<'a> {
    link: Link,
    sigma: f64,
    observations: &'a [Observation],
    /// The category of each observation at u = 0.
    categories: Vec<Category>,
}

/// Sums, over a participant's observations, of the log-probability and its derivatives with respect to a shift, each
/// weighted by the count.
#[derive(Clone, Copy, Default)]
struct Sums {
    log_p: f64,
    g1: f64,
    g2: f64,
    g3: f64,
}

/// Sums over the nodes, relative to the mode.
#[derive(Default)]
struct NodeSums {
    /// Σ w e^(h − h at the mode); 1 for Laplace.
    total: f64,
    /// The means of h′(u) and of h′(u) z over the nodes.
    slope: f64,
    slope_z: f64,
    /// The mean of ∂h/∂σ.
    sigma: f64,
    /// The means of ∂g/∂a and ∂g/∂b for each observation.
    bounds: Vec<(f64, f64)>,
}

impl Subject<'_> {
    /// Returns the derivatives of each observation at u, and their sums.
    fn at(&self, u: f64) -> (Vec<Shift>, Sums) {
        let by = self.sigma * u;
        let up = by.exp();
        let shifts: Vec<Shift> = self.categories.iter().map(|category| self.link.shift(category, by, up)).collect();
        let mut sums = Sums::default();
        for (shift, Observation { count, .. }) in shifts.iter().zip(self.observations) {
            sums.log_p += count * shift.log_p;
            sums.g1 += count * shift.g1;
            sums.g2 += count * shift.g2;
            sums.g3 += count * shift.g3;
        }
        (shifts, sums)
    }

    /// Finds the mode of the log-integrand, which is concave, by Newton's method. A step is halved until it reduces the
    /// slope.
    fn mode(&self, start: f64) -> Option<f64> {
        let slope_at = |u: f64| {
            let (_, Sums { g1, g2, .. }) = self.at(u);
            (-self.sigma * g1 - u, self.sigma * self.sigma * g2 - 1.0)
        };
        let mut u = start;
        let (mut slope, mut curvature) = slope_at(u);
        if !(slope.is_finite() && curvature.is_finite()) {
            u = 0.0;
            (slope, curvature) = slope_at(u);
        }
        for _ in 0..100 {
            let mut step = -slope / curvature;
            // After a Newton step, the error is of the order of the step squared.
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
                // The limit of precision is reached, or the slope is not a number.
                if step.is_nan() || step.abs() < 1e-13 * (1.0 + u.abs()) {
                    return slope.is_finite().then_some(u);
                }
            }
        }
        None
    }

    /// Computes the sums over the nodes around the mode `u`, where the log-integrand is `h`.
    fn integrate(&self, nodes: &[Node], u: f64, h: f64, spread: f64) -> Option<NodeSums> {
        let mut sums = NodeSums { bounds: vec![(0.0, 0.0); self.observations.len()], ..NodeSums::default() };
        for node in nodes {
            let value = u + spread * node.z;
            let (shifts, Sums { log_p, g1, .. }) = self.at(value);
            let weight = node.weight * (log_p - 0.5 * value * value - h).exp();
            // A node too far out has no weight, and its derivatives may not be finite.
            if weight == 0.0 || weight.is_nan() {
                continue;
            }
            let slope_u = -self.sigma * g1 - value;
            sums.total += weight;
            sums.slope += weight * slope_u;
            sums.slope_z += weight * slope_u * node.z;
            sums.sigma -= weight * value * g1;
            for (mean, shift) in sums.bounds.iter_mut().zip(&shifts) {
                mean.0 += weight * shift.a;
                mean.1 += weight * shift.b;
            }
        }
        let total = sums.total;
        for mean in &mut sums.bounds {
            *mean = (mean.0 / total, mean.1 / total);
        }
        sums.slope /= total;
        sums.slope_z /= total;
        sums.sigma /= total;
        (total > 0.0 && total.is_finite()).then_some(sums)
    }
}

impl ClmmData {
    fn thresholds(&self) -> usize {
        self.categories - 1
    }

    /// Returns the number of parameters: θ, β and σ.
    pub fn parameters(&self) -> usize {
        self.thresholds() + self.x.ncols() + 1
    }

    pub fn ratings(&self) -> f64 {
        self.observations.iter().map(|observation| observation.count).sum()
    }

    /// Returns starting values for the modes: 0 for every participant.
    pub fn modes(&self) -> Modes {
        Modes { u: vec![0.0; self.subjects.len()], curvature: vec![1.0; self.subjects.len()] }
    }

    /// Returns xβ for each design row.
    fn location(&self, parameters: &DVector<f64>) -> DVector<f64> {
        &self.x * parameters.rows(self.thresholds(), self.x.ncols())
    }

    /// Returns the approximate log-likelihood and its gradient, or `None` if the thresholds are not increasing or a
    /// rating that occurs has a probability of 0.
    pub fn evaluate(&self, parameters: &DVector<f64>, modes: &mut Modes) -> Option<Evaluation> {
        let thresholds = &parameters.as_slice()[..self.thresholds()];
        if thresholds.windows(2).any(|pair| pair[0] >= pair[1]) {
            return None;
        }
        let location = self.location(parameters);
        let category = |observation: &Observation| {
            let (a, b) = category_bounds(thresholds, observation.category);
            let location = location[observation.row];
            self.link.category(a - location, b - location)
        };
        let mut value = Evaluation { loglik: 0.0, gradient: DVector::zeros(self.parameters()) };
        let mut by_row = DVector::zeros(self.x.nrows());
        for (index, range) in self.subjects.iter().enumerate() {
            let observations = &self.observations[range.clone()];
            let categories = observations.iter().map(category).collect();
            let sigma = parameters[parameters.len() - 1];
            let subject = Subject { link: self.link, sigma, observations, categories };
            let u = subject.mode(modes.u[index])?;
            modes.u[index] = u;
            modes.curvature[index] = self.add(&subject, u, &mut value, &mut by_row)?;
        }
        value.gradient.rows_mut(thresholds.len(), self.x.ncols()).copy_from(&self.x.tr_mul(&by_row));
        (value.loglik.is_finite() && value.gradient.iter().all(|g| g.is_finite())).then_some(value)
    }

    /// Adds a participant's log-likelihood and its gradient; the gradient of the location is added to `by_row`, per
    /// design row. Returns the curvature at the mode `u`.
    fn add(&self, subject: &Subject, u: f64, sum: &mut Evaluation, by_row: &mut DVector<f64>) -> Option<f64> {
        let sigma = subject.sigma;
        let (shifts, at) = subject.at(u);
        let h = at.log_p - 0.5 * u * u;
        let curvature = 1.0 - sigma * sigma * at.g2;
        let spread = curvature.sqrt().recip();
        let nodes = subject.integrate(&self.nodes, u, h, spread)?;
        // The nodes move with the mode and the spread: `second` is the weight of h_uψ, and `third` is the weight of
        // h_uuψ.
        let third = 0.5 * (nodes.slope_z * spread + 1.0) / curvature;
        let second = (nodes.slope - third * sigma.powi(3) * at.g3) / curvature;
        let (by_mode, by_spread) = (-sigma * second, sigma * sigma * third);
        for ((observation, shift), mean) in subject.observations.iter().zip(&shifts).zip(&nodes.bounds) {
            let upper = observation.count * (mean.0 + by_mode * shift.g1_a + by_spread * shift.g2_a);
            let lower = observation.count * (mean.1 + by_mode * shift.g1_b + by_spread * shift.g2_b);
            if observation.category < self.thresholds() {
                sum.gradient[observation.category] += upper;
            }
            if observation.category > 0 {
                sum.gradient[observation.category - 1] += lower;
            }
            by_row[observation.row] -= upper + lower;
        }
        sum.gradient[self.parameters() - 1] += nodes.sigma
            + second * (-at.g1 + sigma * u * at.g2)
            + third * (2.0 * sigma * at.g2 - sigma * sigma * u * at.g3);
        sum.loglik += h + (spread * nodes.total).ln();
        Some(curvature)
    }

    /// Returns approximate information to begin a search: the curvature of the integrand profiled over the modes. For
    /// σ, it includes the curvature of the log determinant, whose second derivative is what keeps σ away from 0.
    pub fn rough_information(&self, parameters: &DVector<f64>, modes: &Modes) -> DMatrix<f64> {
        let (size, thresholds) = (self.parameters(), self.thresholds());
        let (thetas, sigma) = (&parameters.as_slice()[..thresholds], parameters[size - 1]);
        let location = self.location(parameters);
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
            // The second derivative of log D = log(1 + σ²I) with respect to σ, with I held constant.
            let information = (curvature - 1.0) / (sigma * sigma).max(1e-12);
            sum[(size - 1, size - 1)] += information * (1.0 - sigma * sigma * information) / (curvature * curvature);
        }
        sum
    }
}

/// A node z and its weight w, such that ∫ f(z) dz ≈ √(2π) Σ w f(z) for any f close to the standard normal density. The
/// weight includes the inverse of the density.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Node {
    /// Position in standard deviations.
    z: f64,
    /// 1 for the only node of the Laplace approximation.
    weight: f64,
}

/// Returns the quadrature rule with this many nodes, in ascending order and symmetric to the last bit.
///
/// The eigenvalues of the Jacobi matrix (Golub & Welsch 1969) are the starting values for Newton's iteration on the
/// orthonormal Hermite functions. The values of these functions give the weights without overflow.
pub(super) fn gauss_hermite(nodes: usize) -> Vec<Node> {
    let jacobi = DMatrix::from_fn(nodes, nodes, |row, column| match row.abs_diff(column) {
        1 => (row.max(column) as f64 / 2.0).sqrt(),
        _ => 0.0,
    });
    let mut roots: Vec<f64> = jacobi.symmetric_eigenvalues().iter().copied().collect();
    roots.sort_by(f64::total_cmp);
    let half = nodes / 2;
    let mut rule = vec![Node { z: 0.0, weight: 0.0 }; nodes];
    for index in half..nodes {
        let middle = nodes % 2 == 1 && index == half;
        let root = if middle { 0.0 } else { refine(roots[index], nodes) };
        let (_, before) = hermite_function(root, nodes);
        // ∫ f dx ≈ Σ f(x) / (N ψ²), where ψ is the function of degree N − 1 and x = z/√2.
        let weight = 1.0 / (nodes as f64 * before * before * std::f64::consts::PI.sqrt());
        rule[index] = Node { z: root * std::f64::consts::SQRT_2, weight };
        rule[nodes - 1 - index] = Node { z: -root * std::f64::consts::SQRT_2, weight };
    }
    rule
}

fn refine(mut root: f64, degree: usize) -> f64 {
    for _ in 0..4 {
        let (value, before) = hermite_function(root, degree);
        root -= value / ((2.0 * degree as f64).sqrt() * before);
    }
    root
}

/// Returns the orthonormal Hermite functions of degrees `degree` and `degree` − 1 at `x`.
fn hermite_function(x: f64, degree: usize) -> (f64, f64) {
    let mut before = 0.0;
    let mut value = std::f64::consts::PI.powf(-0.25) * (-x * x / 2.0).exp();
    for n in 0..degree {
        let n = n as f64;
        let next = x * (2.0 / (n + 1.0)).sqrt() * value - (n / (n + 1.0)).sqrt() * before;
        before = value;
        value = next;
    }
    (value, before)
}
