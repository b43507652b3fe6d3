//! Scales from paired comparisons: Thurstone's Case V and the model of Bradley and Terry.

use nalgebra::{Cholesky, DMatrix};
use rand_chacha::{ChaCha8Rng, rand_core::Rng as _};

use super::tasks::population::Mean;
pub use crate::experiment::task::{Scaling, Wins};
use crate::statistics::{Interval, Z_95, mean_and_sd, t_quantile};

/// The scale values of items.
#[derive(Clone, Debug, PartialEq)]
pub struct Scale {
    /// The values in units of one JND, the difference that is told apart in 75 % of comparisons. Their mean is 0 in each
    /// group; an item that was compared with no other has NaN.
    pub values: Vec<f64>,
    /// The items that were compared with each other, directly or through others. Values of different groups cannot be
    /// compared.
    pub groups: Vec<Vec<usize>>,
    /// The covariances of the values, in the same unit, if one person had made all comparisons; NaN between groups.
    pub covariances: DMatrix<f64>,
    /// Whether the values of a group are limited by a weak prior, because some items were always or never chosen over all
    /// others (Ford 1957), so that the most likely values are infinite.
    pub is_limited: bool,
}

/// Standard deviation of the weak prior, in JND.
const WEAK_SD: f64 = 5.0;

/// With fewer people, a study that is drawn from them often has the comparisons of one person only, which may not
/// determine a scale. Without such studies, intervals of two people would contain the truth in 70 % of studies, not 95 %.
const FEW: usize = 5;
/// The share of the studies drawn from so few people that must have a scale.
const LEAST_DRAWN: f64 = 0.95;

impl Scale {
    /// Returns the difference between the highest and the lowest value of a group.
    pub fn span(&self, group: &[usize]) -> f64 {
        let [low, high] =
            [f64::min, f64::max].map(|end| group.iter().map(|item| self.values[*item]).fold(f64::NAN, end));
        high - low
    }
}

impl Scaling {
    /// Returns one JND on the model's own scale: z(.75), or ln 3.
    pub fn jnd(self) -> f64 {
        match self {
            Self::Thurstone => 0.674_489_750_196_081_7,
            Self::BradleyTerry => 3.0_f64.ln(),
        }
    }

    /// Finds the most likely scale values.
    ///
    /// Returns `None` if nothing was compared.
    pub fn fit(self, wins: &Wins) -> Option<Scale> {
        let (groups, mut values) = (groups(wins), vec![f64::NAN; wins.nrows()]);
        let mut covariances = DMatrix::from_element(wins.nrows(), wins.nrows(), f64::NAN);
        let mut is_limited = false;
        for group in &groups {
            let own = wins.select_rows(group).select_columns(group);
            let is_connected = is_connected(&own);
            let precision = if is_connected { 0.0 } else { (WEAK_SD * self.jnd()).powi(-2) };
            let mode = self.mode(&own, precision)?;
            let (mean, count) = (mode.values.mean(), group.len() as f64);
            // The ones stand for the sum of the values, which is known.
            let covariance = Cholesky::new(mode.information.add_scalar(1.0))?.inverse().add_scalar(-count.powi(-2));
            for (i, item) in group.iter().enumerate() {
                values[*item] = (mode.values[i] - mean) / self.jnd();
                for (j, other) in group.iter().enumerate() {
                    covariances[(*item, *other)] = covariance[(i, j)] / self.jnd().powi(2);
                }
            }
            is_limited |= !is_connected;
        }
        (!groups.is_empty()).then_some(Scale { values, groups, covariances, is_limited })
    }

    /// Draws `draws` studies of these people with replacement (Efron 1979), and finds the scale of each. `None` for fewer than
    /// two people; with fewer than five, also if many such studies compare other groups or, unlike these people's, are
    /// limited by the prior: the rest would be too much alike.
    pub fn drawn(self, people: &[Wins], draws: usize, rng: &mut ChaCha8Rng) -> Option<Drawn> {
        let scale = self.fit(&people.iter().sum())?;
        if people.len() < 2 {
            return None;
        }
        let study = |_| -> Option<Vec<f64>> {
            let pick = |_| &people[((u128::from(rng.next_u64()) * people.len() as u128) >> 64) as usize];
            let own = self.fit(&(0..people.len()).map(pick).sum()).filter(|own| own.groups == scale.groups)?;
            (!own.is_limited || scale.is_limited).then_some(own.values)
        };
        let drawn: Vec<Vec<f64>> = (0..draws).filter_map(study).collect();
        let least = if people.len() < FEW { LEAST_DRAWN * draws as f64 } else { 2.0 };
        (drawn.len() as f64 >= least).then_some(Drawn { scale, drawn, people: people.len() })
    }
}

/// A scale, and those of studies whose people are drawn from the same ones.
#[derive(Clone, Debug)]
pub struct Drawn {
    scale: Scale,
    drawn: Vec<Vec<f64>>,
    people: usize,
}

impl Drawn {
    /// Returns the value of an item or, with another one, by how much it is higher, with the 95 % interval for people like
    /// these: the standard error is that of the drawn studies, and the quantile is that of the t distribution. No interval
    /// is narrower than if all comparisons were one person's: a few people may agree by chance.
    pub fn mean(&self, item: usize, other: Option<usize>) -> Mean {
        let of = |values: &[f64]| values[item] - other.map_or(0.0, |other| values[other]);
        let covariance = |i: usize, j: usize| self.scale.covariances[(i, j)];
        let variance = other.map_or(covariance(item, item), |other| {
            covariance(item, item) + covariance(other, other) - 2.0 * covariance(item, other)
        });
        let (value, n) = (of(&self.scale.values), self.people as f64);
        let reach = t_quantile(n - 1.0) * (n / (n - 1.0)).sqrt();
        let spread = mean_and_sd(&self.drawn.iter().map(|values| of(values)).collect::<Vec<_>>()).1;
        let half = (reach * spread).max(Z_95 * variance.max(0.0).sqrt());
        Mean { mean: value, interval: Interval::around(value, Some(half), 1.0), people: self.people }
    }
}

/// Returns the items to which edges lead from an item, with itself.
fn reached(items: usize, from: usize, edge: impl Fn(usize, usize) -> bool) -> Vec<usize> {
    let (mut seen, mut next) = (vec![false; items], vec![from]);
    while let Some(i) = next.pop() {
        if !std::mem::replace(&mut seen[i], true) {
            next.extend((0..items).filter(|j| edge(i, *j)));
        }
    }
    (0..items).filter(|item| seen[*item]).collect()
}

/// Returns the groups of two or more items that were compared, directly or through others.
fn groups(wins: &Wins) -> Vec<Vec<usize>> {
    let group = |item| reached(wins.nrows(), item, |i, j| wins[(i, j)] + wins[(j, i)] > 0.0);
    // Each group is found from its first item only.
    let groups = (0..wins.nrows()).map(|item| (item, group(item)));
    groups.filter(|(item, group)| group[0] == *item && group.len() > 1).map(|(_, group)| group).collect()
}

/// Returns whether every item was chosen over every other, directly or through others (Ford 1957).
fn is_connected(wins: &Wins) -> bool {
    let items = wins.nrows();
    let over = reached(items, 0, |i, j| wins[(i, j)] > 0.0);
    let under = reached(items, 0, |i, j| wins[(j, i)] > 0.0);
    over.len() == items && under.len() == items
}

/// Comparisons that contradict each other: a over b, b over c, and c over a.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Triads {
    /// The number of contradictions.
    pub circular: u32,
    /// The number of triads all of whose pairs were decided.
    pub all: u32,
}

impl Triads {
    /// Counts the triads of one person (Kendall & Babington Smith 1940, Biometrika 31, 324). A pair that was compared
    /// several times is decided by the majority.
    pub fn of(wins: &Wins) -> Self {
        let over = |i: usize, j: usize| wins[(i, j)] - wins[(j, i)];
        let items = wins.nrows();
        let (mut circular, mut all) = (0, 0);
        for i in 0..items {
            for j in i + 1..items {
                for k in j + 1..items {
                    let signs = [over(i, j), over(j, k), over(k, i)];
                    if signs.iter().all(|sign| *sign != 0.0) {
                        all += 1;
                        circular +=
                            u32::from(signs.iter().all(|sign| *sign > 0.0) || signs.iter().all(|sign| *sign < 0.0));
                    }
                }
            }
        }
        Self { circular, all }
    }
}
