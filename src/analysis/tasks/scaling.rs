//! Scales from paired comparisons: how much more one item has of an attribute than another.
//!
//! Item i wins against j with probability F(v_i − v_j). In Case V of Thurstone (1927, Psychol. Rev. 34, 273), F = Φ, and
//! in the model of Bradley & Terry (1952, Biometrika 39, 324), F is the logistic function. The values are the maximum
//! of the likelihood, with mean 0, in units of one just noticeable difference (JND): the difference with F = .75, which
//! is 0.6745 standard deviations of a difference, or ln 3 logits.

use nalgebra::{DMatrix, DVector};
use serde::Serialize;

use super::means::Mean;
use crate::{experiment::task::curve::Curve, statistics::Interval};

/// How often each item won against each other: `wins[i][j]` is how often i won against j. The diagonal does not count.
pub type Wins = [Vec<u32>];

/// The shape of F.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Law {
    /// The normal distribution function: Case V of Thurstone.
    Thurstone,
    /// The logistic function: Bradley and Terry.
    BradleyTerry,
}

/// Why there is no scale.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ScalingError {
    /// The counts are not a square of two or more items, or differ in size between people.
    #[error("expected counts of wins for two or more items, with a row and a column for each, the same for all people")]
    Shape,
    /// No items were compared.
    #[error("expected at least one comparison")]
    Empty,
}

/// A scale of the items.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Scale {
    /// The value of each item, in JND; their mean is 0.
    pub values: Vec<f64>,
    /// The logarithm of the likelihood, without binomial coefficients. Both laws have the same number of parameters, so
    /// that the law with the higher one fits better.
    pub log_likelihood: f64,
    /// Whether the likelihood alone has no maximum, so that a weak prior determines the values: a normal distribution
    /// with a standard deviation of [`PRIOR_SD`] about 0. This is so if the items can be divided into two groups such
    /// that no item of the first ever won against one of the second (Ford 1957, Am. Math. Mon. 64, 28).
    pub has_prior: bool,
}

/// The standard deviation of the weak prior of [`Scale::has_prior`], in JND.
pub const PRIOR_SD: f64 = 5.0;

/// Scales of several people.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Scales {
    /// The scale from the comparisons of all people together. Its JND is that of choices by different people: if they
    /// disagree, the values are closer together than those of each person.
    pub pooled: Scale,
    /// The 95 % interval of each pooled value; `None` for a single person.
    pub intervals: Vec<Option<Interval>>,
    /// The scale of each person; `None` for a person without comparisons.
    pub people: Vec<Option<Scale>>,
}

/// How consistent comparisons are.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Triads {
    /// The number of circular triads: i won against j, j against k, and k against i, each in most comparisons.
    pub circular: usize,
    /// The number of triads of which all three pairs were compared and have a winner.
    pub complete: usize,
    /// The coefficient of consistency ζ (Kendall & Babington Smith 1940, Biometrika 31, 324): 1 without circular triads,
    /// and 0 for the greatest possible number; `None` if a pair has no winner or there are fewer than three items.
    pub consistency: Option<f64>,
}

impl Law {
    /// Returns one JND in units of the argument of F.
    fn jnd(self) -> f64 {
        self.curve().inverse(0.75)
    }

    fn curve(self) -> Curve {
        match self {
            Self::Thurstone => Curve::Normal,
            Self::BradleyTerry => Curve::Logistic,
        }
    }

    /// Returns ln F(z) and its first two derivatives.
    fn ln(self, z: f64) -> [f64; 3] {
        match self {
            Self::BradleyTerry => {
                let other = self.curve().sigmoid(-z);
                let ln = if z < 0.0 { z - z.exp().ln_1p() } else { -(-z).exp().ln_1p() };
                [ln, other, -other * (1.0 - other)]
            }
            // Far below, Φ(z) ≈ φ(z)/|z|.
            Self::Thurstone if z < -30.0 => [-z * z / 2.0 - (-z).ln() - LN_ROOT_TAU, -z, -1.0],
            Self::Thurstone => {
                let share = self.curve().sigmoid(z);
                let ratio = (-z * z / 2.0 - LN_ROOT_TAU).exp() / share;
                [share.ln(), ratio, -ratio * (z + ratio)]
            }
        }
    }
}

/// ln √(2π).
const LN_ROOT_TAU: f64 = 0.918_938_533_204_672_8;
/// Newton's method ends if no value changes by more than this, in units of the argument of F.
const TOLERANCE: f64 = 1e-12;

/// Computes the scale of some comparisons.
///
/// # Errors
///
/// The counts are not a square of two or more items, or no items were compared.
pub fn scale(wins: &Wins, law: Law) -> Result<Scale, ScalingError> {
    check(wins, wins.len())?;
    if pairs(wins).next().is_none() {
        return Err(ScalingError::Empty);
    }
    Ok(fit(wins, law).0)
}

/// Computes the scales of several people, and of all together with intervals.
///
/// The intervals are t intervals over people of what each person contributes to a value (the sandwich of Liang & Zeger
/// 1986, Biometrika 73, 13): unlike bootstrap percentiles, they cover also with eight people.
///
/// # Errors
///
/// The counts are not squares of two or more items and of the same size, or no items were compared.
pub fn scales(people: &[Vec<Vec<u32>>], law: Law) -> Result<Scales, ScalingError> {
    let items = people.first().map_or(0, Vec::len);
    people.iter().try_for_each(|wins| check(wins, items))?;
    let sum = |i: usize, j: usize| people.iter().map(|wins| wins[i][j]).sum();
    let all: Vec<Vec<u32>> = (0..items).map(|i| (0..items).map(|j| sum(i, j)).collect()).collect();
    if pairs(&all).next().is_none() {
        return Err(ScalingError::Empty);
    }
    let (pooled, inverse) = fit(&all, law);
    let raw = DVector::from_iterator(items, pooled.values.iter().map(|value| value * law.jnd()));
    let active: Vec<&Vec<Vec<u32>>> = people.iter().filter(|wins| pairs(wins).next().is_some()).collect();
    let moves: Vec<DVector<f64>> = active.iter().map(|wins| &inverse * derivatives(wins, law, &raw, 0.0).1).collect();
    let interval = |item: usize| {
        let moves: Vec<f64> = moves.iter().map(|by| by[item] * moves.len() as f64 / law.jnd()).collect();
        let Mean { mean, interval, .. } = Mean::new(&moves);
        // The prior, too, moves the value.
        let shift = pooled.values[item] - mean;
        interval.map(|Interval { low, high }| Interval { low: low + shift, high: high + shift })
    };
    let intervals = (0..items).map(interval).collect();
    Ok(Scales { intervals, people: people.iter().map(|wins| scale(wins, law).ok()).collect(), pooled })
}

/// Counts circular triads.
///
/// # Errors
///
/// The counts are not a square of two or more items.
pub fn triads(wins: &Wins) -> Result<Triads, ScalingError> {
    let n = wins.len();
    check(wins, n)?;
    let beats = |i: usize, j: usize| wins[i][j] > wins[j][i];
    let is_decided = |i: usize, j: usize| wins[i][j] != wins[j][i];
    let (mut circular, mut complete) = (0, 0);
    for i in 0..n {
        for j in i + 1..n {
            for k in (j + 1..n).filter(|&k| is_decided(i, j) && is_decided(j, k) && is_decided(i, k)) {
                complete += 1;
                circular += usize::from(beats(i, j) == beats(j, k) && beats(j, k) == beats(k, i));
            }
        }
    }
    let is_whole = n > 2 && complete == n * (n - 1) * (n - 2) / 6;
    let most = if n % 2 == 1 { n * (n * n - 1) } else { n * (n * n).saturating_sub(4) } as f64 / 24.0;
    Ok(Triads { circular, complete, consistency: is_whole.then(|| 1.0 - circular as f64 / most) })
}

fn check(wins: &Wins, items: usize) -> Result<(), ScalingError> {
    let is_square = wins.len() == items && items > 1 && wins.iter().all(|row| row.len() == items);
    if is_square { Ok(()) } else { Err(ScalingError::Shape) }
}

/// The numbers of the items that won, of those that lost, and how often.
fn pairs(wins: &Wins) -> impl Iterator<Item = (usize, usize, f64)> {
    let row = |(i, row): (usize, &[u32])| {
        row.iter().enumerate().map(move |(j, &count)| (i, j, f64::from(count))).collect::<Vec<_>>()
    };
    wins.iter().map(Vec::as_slice).enumerate().flat_map(row).filter(|(i, j, count)| i != j && *count > 0.0)
}

/// Whether a chain of wins leads from every item to every other, so that the likelihood has a maximum.
fn is_strongly_connected(wins: &Wins) -> bool {
    let reaches_all = |won: &dyn Fn(usize, usize) -> bool| {
        let (mut reached, mut open) = (vec![false; wins.len()], vec![0]);
        reached[0] = true;
        while let Some(item) = open.pop() {
            for other in (0..wins.len()).filter(|&other| won(item, other)) {
                if !std::mem::replace(&mut reached[other], true) {
                    open.push(other);
                }
            }
        }
        reached.into_iter().all(|is_reached| is_reached)
    };
    reaches_all(&|i, j| wins[i][j] > 0) && reaches_all(&|i, j| wins[j][i] > 0)
}

/// Returns the log-likelihood, its gradient and the negative matrix of its second derivatives, all with a normal prior
/// of this precision.
fn derivatives(wins: &Wins, law: Law, values: &DVector<f64>, precision: f64) -> (f64, DVector<f64>, DMatrix<f64>) {
    let mut ln = -precision * values.norm_squared() / 2.0;
    let mut gradient = values * -precision;
    let mut information = DMatrix::from_diagonal_element(values.len(), values.len(), precision);
    for (i, j, count) in pairs(wins) {
        let [value, first, second] = law.ln(values[i] - values[j]).map(|term| count * term);
        ln += value;
        gradient[i] += first;
        gradient[j] -= first;
        for (row, column, sign) in [(i, i, -1.0), (j, j, -1.0), (i, j, 1.0), (j, i, 1.0)] {
            information[(row, column)] += sign * second;
        }
    }
    (ln, gradient, information)
}

/// Maximizes the likelihood by Newton's method with halved steps; it is concave. Also returns the inverse of the
/// information. Adding a constant to the information fixes the mean of the values, which the likelihood does not.
fn fit(wins: &Wins, law: Law) -> (Scale, DMatrix<f64>) {
    let n = wins.len();
    let has_prior = !is_strongly_connected(wins);
    let precision = if has_prior { (PRIOR_SD * law.jnd()).powi(-2) } else { 0.0 };
    let mut values = DVector::zeros(n);
    let mut inverse = DMatrix::zeros(n, n);
    for _ in 0..200 {
        let (ln, gradient, information) = derivatives(wins, law, &values, precision);
        let Some(factor) = information.add_scalar(1.0).cholesky() else { break };
        inverse = factor.inverse();
        let mut step = factor.solve(&gradient);
        // Near the maximum, a rise is smaller than the rounding error.
        let least = ln - 1e-10 * (1.0 + ln.abs());
        while step.amax() > TOLERANCE && derivatives(wins, law, &(&values + &step), precision).0 < least {
            step /= 2.0;
        }
        values += &step;
        if step.amax() <= TOLERANCE {
            break;
        }
    }
    values.add_scalar_mut(-values.mean());
    let (log_likelihood, ..) = derivatives(wins, law, &values, 0.0);
    let values = values.iter().map(|value| value / law.jnd()).collect();
    (Scale { values, log_likelihood, has_prior }, inverse)
}
