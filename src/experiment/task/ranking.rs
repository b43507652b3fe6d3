//! Adaptive pairs: which two items to compare next, so that the answer is expected to tell most about all of them.

use nalgebra::{Cholesky, DMatrix, DVector};
use statrs::function::erf::erfc;

/// Standard deviation of a scale value before any comparison, in units of the noise of one comparison.
const PRIOR_SD: f64 = 2.0;
/// Newton steps to the mode of the posterior.
const STEPS: usize = 50;
/// A step this small ends the search.
const SMALL: f64 = 1e-10;
/// Pairs whose expected information differs by less are equal. Rounding differs between machines, and must not decide.
const EQUAL: f64 = 1e-9;
/// Nodes and weights of the Gauss–Hermite quadrature for a standard normal distribution.
const NODES: [(f64, f64); 5] = [
    (0.0, 0.533_333_333_333_333_3),
    (1.355_626_179_974_266, 0.222_075_922_005_612_64),
    (-1.355_626_179_974_266, 0.222_075_922_005_612_64),
    (2.856_970_013_872_805_6, 0.011_257_411_327_720_691),
    (-2.856_970_013_872_805_6, 0.011_257_411_327_720_691),
];

/// The scale values of some items after some comparisons: Thurstone's Case V, P(i over j) = Φ(s_i − s_j), with
/// independent normal priors, and a normal approximation of the posterior at its mode.
#[derive(Clone, Debug, PartialEq)]
pub struct Ranking {
    /// How often the first item won against the second.
    wins: DMatrix<f64>,
    mode: DVector<f64>,
    covariance: DMatrix<f64>,
}

fn phi(z: f64) -> f64 {
    0.5 * erfc(-z / std::f64::consts::SQRT_2)
}

fn density(z: f64) -> f64 {
    (-0.5 * z * z).exp() / (2.0 * std::f64::consts::PI).sqrt()
}

fn entropy(p: f64) -> f64 {
    [p, 1.0 - p].into_iter().filter(|p| *p > 0.0).map(|p| -p * p.ln()).sum()
}

impl Ranking {
    /// Begins without comparisons.
    #[must_use]
    pub fn new(items: usize) -> Self {
        let covariance = DMatrix::identity(items, items) * PRIOR_SD.powi(2);
        Self { wins: DMatrix::zeros(items, items), mode: DVector::zeros(items), covariance }
    }

    /// Learns that one item won against another.
    pub fn learn(&mut self, winner: usize, loser: usize) {
        self.wins[(winner, loser)] += 1.0;
        // Always from the start, so that the mode does not depend on the order of the comparisons.
        self.mode.fill(0.0);
        for _ in 0..STEPS {
            let (gradient, information) = self.derivatives();
            let Some(cholesky) = Cholesky::new(information) else { return };
            let step = cholesky.solve(&gradient);
            self.mode += &step;
            if step.amax() < SMALL {
                break;
            }
        }
        if let Some(cholesky) = Cholesky::new(self.derivatives().1) {
            self.covariance = cholesky.inverse();
        }
    }

    /// Returns the gradient of the log posterior and the negative of its Hessian.
    fn derivatives(&self) -> (DVector<f64>, DMatrix<f64>) {
        let items = self.mode.len();
        let precision = PRIOR_SD.powi(-2);
        let (mut gradient, mut information) = (&self.mode * -precision, DMatrix::identity(items, items) * precision);
        for (i, j) in (0..items).flat_map(|i| (0..items).map(move |j| (i, j))).filter(|at| self.wins[*at] > 0.0) {
            let (z, wins) = (self.mode[i] - self.mode[j], self.wins[(i, j)]);
            let ratio = density(z) / phi(z).max(f64::MIN_POSITIVE);
            let (slope, curvature) = (wins * ratio, wins * ratio * (z + ratio));
            gradient[i] += slope;
            gradient[j] -= slope;
            for (a, b, sign) in [(i, i, 1.0), (j, j, 1.0), (i, j, -1.0), (j, i, -1.0)] {
                information[(a, b)] += sign * curvature;
            }
        }
        (gradient, information)
    }

    /// Returns the pair whose comparison is expected to reduce the uncertainty most (Lindley 1956): the entropy of the
    /// answer, minus its mean entropy given the scale values. `tie`, uniform in 0…1, decides between equal pairs.
    #[must_use]
    pub fn choose(&self, tie: f64) -> [usize; 2] {
        let items = self.mode.len();
        let pairs: Vec<[usize; 2]> = (0..items).flat_map(|i| (i + 1..items).map(move |j| [i, j])).collect();
        let gains: Vec<f64> = pairs.iter().map(|pair| self.gain(*pair)).collect();
        let most = gains.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let best: Vec<[usize; 2]> =
            pairs.iter().zip(&gains).filter(|(_, gain)| **gain >= most - EQUAL).map(|(pair, _)| *pair).collect();
        best[((tie * best.len() as f64) as usize).min(best.len() - 1)]
    }

    fn gain(&self, [i, j]: [usize; 2]) -> f64 {
        let covariance = &self.covariance;
        let mean = self.mode[i] - self.mode[j];
        let sd = (covariance[(i, i)] + covariance[(j, j)] - 2.0 * covariance[(i, j)]).max(0.0).sqrt();
        let at = NODES.map(|(node, weight)| (phi(mean + sd * node), weight));
        let seen: f64 = at.iter().map(|(p, weight)| p * weight).sum();
        entropy(seen) - at.iter().map(|(p, weight)| entropy(*p) * weight).sum::<f64>()
    }
}
