//! Scale values from paired comparisons: Thurstone's Case V and the model of Bradley and Terry.

use nalgebra::{Cholesky, DMatrix, DVector};
use serde::Serialize;

use super::curve::Curve;

/// How often each item (row) was chosen over each other (column).
pub type Wins = DMatrix<f64>;

/// How the difference of two scale values becomes the probability of a choice.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
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
    /// The logarithm of the likelihood, without the priors.
    pub log_likelihood: f64,
}

impl Scaling {
    /// Returns ln P of a difference, its derivative, and the negative of its second derivative.
    fn log_probability(self, d: f64) -> [f64; 3] {
        match self {
            Self::Thurstone => {
                let p = Curve::Normal.sigmoid(d).max(f64::MIN_POSITIVE);
                let ratio = (-0.5 * d * d).exp() / (2.0 * std::f64::consts::PI).sqrt() / p;
                [p.ln(), ratio, ratio * (d + ratio)]
            }
            Self::BradleyTerry => {
                let p = Curve::Logistic.sigmoid(d);
                [-(-d).exp().ln_1p(), 1.0 - p, p * (1.0 - p)]
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
        let each = compared(wins).map(|(i, j, n)| n * self.log_probability(values[i] - values[j])[0]);
        let log_likelihood = each.sum();
        Some(Mode { values, information, log_likelihood })
    }

    /// Returns the gradient of the log posterior and the negative of its second derivatives.
    fn derivatives(self, wins: &Wins, values: &DVector<f64>, precision: f64) -> (DVector<f64>, DMatrix<f64>) {
        let items = values.len();
        let (mut gradient, mut information) = (values * -precision, DMatrix::identity(items, items) * precision);
        for (i, j, n) in compared(wins) {
            let [_, slope, curvature] = self.log_probability(values[i] - values[j]);
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
