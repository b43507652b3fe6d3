//! Scale values from paired comparisons: Thurstone's Case V and the model of Bradley and Terry. Adaptive pairs: which two
//! items to compare next, so that the answer is expected to tell most about all of them.

use nalgebra::{Cholesky, DMatrix, DVector};

use super::curve::{Curve, entropy};

/// How often each item (row) was chosen over each other (column).
pub type Wins = DMatrix<f64>;

/// How the difference of two scale values becomes the probability of a choice.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scaling {
    /// Φ(s_i − s_j) (Thurstone 1927, Case V).
    Thurstone,
    /// 1/(1 + e^(s_j − s_i)) (Bradley & Terry 1952).
    BradleyTerry,
}

/// Newton steps.
const STEPS: usize = 200;
/// A step this small ends the search.
const SMALL: f64 = 1e-11;

/// The most probable scale values under independent normal priors around 0.
pub struct Mode {
    /// The values, on the model's own scale; their sum is 0.
    pub values: DVector<f64>,
    /// The negative of the second derivatives of the log posterior there.
    pub information: DMatrix<f64>,
}

impl Scaling {
    /// Returns the derivative of ln P of a difference, and the negative of its second derivative.
    fn slope(self, d: f64) -> [f64; 2] {
        match self {
            Self::Thurstone => {
                let p = Curve::Normal.sigmoid(d).max(f64::MIN_POSITIVE);
                let ratio = (-0.5 * d * d).exp() / (2.0 * std::f64::consts::PI).sqrt() / p;
                [ratio, ratio * (d + ratio)]
            }
            Self::BradleyTerry => {
                let p = Curve::Logistic.sigmoid(d);
                [1.0 - p, p * (1.0 - p)]
            }
        }
    }

    /// Finds the most probable values by Newton's method, always from 0, so that they do not depend on the order of the
    /// comparisons. `precision` is the inverse variance of the priors; 0 finds the most likely values, which are finite
    /// only if every item was chosen over every other, directly or through others. `None` if they are not.
    pub fn mode(self, wins: &Wins, precision: f64) -> Option<Mode> {
        let items = wins.nrows();
        let mut values = DVector::zeros(items);
        for _ in 0..STEPS {
            let (gradient, information) = self.derivatives(wins, &values, precision);
            // Comparisons say nothing about the sum of the values, which the ones keep at 0.
            let step = Cholesky::new(information.add_scalar(1.0))?.solve(&gradient);
            // Far from the mode, a whole step could leave the region in which the model is accurate.
            values += &step * (2.0 / step.amax().max(1e-300)).min(1.0);
            if step.amax() < SMALL {
                break;
            }
        }
        let information = self.derivatives(wins, &values, precision).1;
        Some(Mode { values, information })
    }

    /// Returns the gradient of the log posterior and the negative of its second derivatives.
    fn derivatives(self, wins: &Wins, values: &DVector<f64>, precision: f64) -> (DVector<f64>, DMatrix<f64>) {
        let items = values.len();
        let (mut gradient, mut information) = (values * -precision, DMatrix::identity(items, items) * precision);
        for (i, j, n) in compared(wins) {
            let [slope, curvature] = self.slope(values[i] - values[j]);
            gradient[i] += n * slope;
            gradient[j] -= n * slope;
            for (a, b, sign) in [(i, i, 1.0), (j, j, 1.0), (i, j, -1.0), (j, i, -1.0)] {
                information[(a, b)] += sign * n * curvature;
            }
        }
        (gradient, information)
    }
}

fn compared(wins: &Wins) -> impl Iterator<Item = (usize, usize, f64)> {
    let items = wins.nrows();
    let pairs = (0..items).flat_map(move |i| (0..items).map(move |j| (i, j)));
    pairs.map(|(i, j)| (i, j, wins[(i, j)])).filter(|(.., n)| *n > 0.0)
}

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
