//! Adaptive pairs: which two items to compare next, so that the answer is expected to tell most about all of them.

use nalgebra::{Cholesky, DMatrix, DVector};

use super::{
    curve::Curve,
    scaling::{Scaling, Wins},
};

/// Standard deviation of a scale value before any comparison, in units of the noise of one comparison.
const PRIOR_SD: f64 = 2.0;
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
    wins: Wins,
    mode: DVector<f64>,
    covariance: DMatrix<f64>,
}

fn entropy(p: f64) -> f64 {
    [p, 1.0 - p].into_iter().filter(|p| *p > 0.0).map(|p| -p * p.ln()).sum()
}

impl Ranking {
    /// Begins without comparisons.
    pub fn new(items: usize) -> Self {
        let covariance = DMatrix::identity(items, items) * PRIOR_SD.powi(2);
        Self { wins: Wins::zeros(items, items), mode: DVector::zeros(items), covariance }
    }

    /// Learns that one item won against another.
    pub fn learn(&mut self, winner: usize, loser: usize) {
        self.wins[(winner, loser)] += 1.0;
        let Some(mode) = Scaling::Thurstone.mode(&self.wins, PRIOR_SD.powi(-2)) else { return };
        if let Some(cholesky) = Cholesky::new(mode.information) {
            (self.mode, self.covariance) = (mode.values, cholesky.inverse());
        }
    }

    /// Returns the pair whose comparison is expected to reduce the uncertainty most (Lindley 1956): the entropy of the
    /// answer, minus its mean entropy given the scale values. `tie`, uniform in 0…1, decides between equal pairs.
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
        let at = NODES.map(|(node, weight)| (Curve::Normal.sigmoid(mean + sd * node), weight));
        let seen: f64 = at.iter().map(|(p, weight)| p * weight).sum();
        entropy(seen) - at.iter().map(|(p, weight)| entropy(*p) * weight).sum::<f64>()
    }
}
