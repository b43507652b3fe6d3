//! Participants' mean ratings at the levels of a factor, and Friedman's test with Kendall's W on their ranks.

use std::collections::BTreeMap;

use serde::Serialize;

use super::{
    counts::{Combinations, Counts},
    summary::{category_values, cell_means},
};
use crate::statistics::{Interval, chi_squared_tail};

/// Participants' mean ratings at each level of a factor. Each mean is over the cells of the other factors that the
/// participant rated at every level, so that an unequal number of ratings in the cells cannot look like an effect.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct SubjectMeans {
    pub levels: Vec<String>,
    /// Participants with comparable ratings at every level, each with their means in the order of the levels.
    pub rows: Vec<(String, Vec<f64>)>,
    /// Participants excluded because no cell of the other factors has ratings at every level.
    pub incomplete: Vec<String>,
    /// Means that differ by less than this are equal: they differ only by rounding errors.
    pub tolerance: f64,
}

impl SubjectMeans {
    /// Computes the means at those levels of a factor that have ratings.
    pub fn new(counts: &Counts, factor: usize) -> Self {
        let values = category_values(counts);
        let levels = counts.factors[factor].levels.len();
        let others: Vec<usize> = (0..counts.factors.len()).filter(|other| *other != factor).collect();
        let Combinations { of: cell_of, .. } = counts.combinations(&others);
        let mut is_rated = vec![false; levels];
        // The means of each participant at the levels, in each cell of the other factors.
        let mut tallies: Vec<BTreeMap<usize, Vec<Option<f64>>>> = vec![BTreeMap::new(); counts.subjects.len()];
        for (subject, condition, mean) in cell_means(counts) {
            let Some(level) = counts.conditions[condition as usize][factor] else { continue };
            let own = tallies[subject as usize].entry(cell_of[condition as usize]);
            own.or_insert_with(|| vec![None; levels])[level as usize] = Some(mean);
            is_rated[level as usize] = true;
        }
        let used: Vec<usize> = (0..levels).filter(|&level| is_rated[level]).collect();
        let span = values.iter().fold(0.0_f64, |most, value| most.max(value.abs()));
        let mut means = Self {
            levels: used.iter().map(|&level| counts.factors[factor].levels[level].clone()).collect(),
            rows: Vec::new(),
            incomplete: Vec::new(),
            tolerance: 1e-9 * span.max(f64::MIN_POSITIVE),
        };
        for (subject, tally) in counts.subjects.iter().zip(tallies) {
            let means_of = |cell: Vec<Option<f64>>| used.iter().map(|&level| cell[level]).collect::<Option<Vec<f64>>>();
            let whole: Vec<Vec<f64>> = tally.into_values().filter_map(means_of).collect();
            if whole.is_empty() {
                means.incomplete.push(subject.clone());
                continue;
            }
            let mean = |place: usize| whole.iter().map(|cell| cell[place]).sum::<f64>() / whole.len() as f64;
            means.rows.push((subject.clone(), (0..used.len()).map(mean).collect()));
        }
        means
    }

    /// Returns the mean over participants of the difference between two levels, the first minus the second, and its 95 %
    /// t interval; `None` if a level has no ratings or there are fewer than two participants.
    pub fn difference(&self, levels: [&str; 2]) -> Option<(f64, Option<Interval>)> {
        let place = |name| self.levels.iter().position(|level| level == name);
        let (first, second) = (place(levels[0])?, place(levels[1])?);
        let own: Vec<f64> = self.rows.iter().map(|(_, row)| row[first] - row[second]).collect();
        (own.len() > 1).then(|| (own.iter().sum::<f64>() / own.len() as f64, Interval::of_mean(&own)))
    }
}

/// Friedman's test of whether all levels are rated alike, and how well participants agree in ranking them.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Friedman {
    pub subjects: usize,
    /// Friedman's χ², corrected for ties.
    pub chi_squared: f64,
    /// Degrees of freedom.
    pub df: usize,
    /// Probability of a statistic at least as large if each participant's order of the levels were random.
    pub p: f64,
    /// Whether the probability is from all possible orders, and not from the χ² distribution.
    pub is_exact: bool,
    /// Kendall's coefficient of concordance W, corrected for ties: 0 is no agreement, and 1 means that all participants
    /// rank the levels alike.
    pub w: f64,
}

/// Performs Friedman's test. Returns `None` if there are fewer than two participants or levels, or if every participant rates
/// all levels alike.
pub fn friedman(means: &SubjectMeans) -> Option<Friedman> {
    let (n, k) = (means.rows.len(), means.levels.len());
    if n < 2 || k < 2 {
        return None;
    }
    let mut sums = vec![0.0; k];
    let mut all = 0.0;
    let mut rows = Vec::with_capacity(n);
    for (_, row) in &means.rows {
        let (ranks, tied) = ranks(row, means.tolerance);
        all += tied;
        sums.iter_mut().zip(&ranks).for_each(|(sum, rank)| *sum += rank);
        rows.push(ranks);
    }
    let (subjects, levels) = (n as f64, k as f64);
    let squares: f64 = sums.iter().map(|sum| (sum - subjects * (levels + 1.0) / 2.0).powi(2)).sum();
    let most = subjects * levels * (levels + 1.0) / 12.0 - all / (12.0 * (levels - 1.0));
    if most <= 0.0 {
        return None;
    }
    let chi_squared = squares / most;
    let df = k - 1;
    let exact = exact_probability(&rows);
    let p = exact.unwrap_or_else(|| chi_squared_tail(chi_squared, df));
    let w = chi_squared / (subjects * df as f64);
    Some(Friedman { subjects: n, chi_squared, df, p, is_exact: exact.is_some(), w })
}

/// Returns the probability that the sum of squares of the rank sums is at least as large as observed if each participant's
/// ranks are in random order; `None` if there are too many orders. Rows are added one after the other, and orders with the
/// same sums are combined. The first row keeps its order, because only differences between the rows matter.
fn exact_probability(rows: &[Vec<f64>]) -> Option<f64> {
    const MAX_STEPS: usize = 500_000;
    const MAX_LEVELS: usize = 6;
    if rows[0].len() > MAX_LEVELS {
        return None;
    }
    // Mid-ranks are multiples of ½, so doubling makes them whole numbers.
    let rows: Vec<Vec<u32>> =
        rows.iter().map(|row| row.iter().map(|rank| (2.0 * rank).round() as u32).collect()).collect();
    let sum = |sums: &[u32], row: &[u32]| sums.iter().zip(row).map(|(sum, rank)| sum + rank).collect::<Vec<u32>>();
    let squares = |sums: &[u32]| sums.iter().map(|sum| u64::from(*sum).pow(2)).sum::<u64>();
    let observed = squares(&rows[1..].iter().fold(rows[0].clone(), |sums, row| sum(&sums, row)));
    let mut steps = 0;
    // In order, so that the last digit of a sum is always the same.
    let mut ways: BTreeMap<Vec<u32>, f64> = BTreeMap::from([(rows[0].clone(), 1.0)]);
    for row in &rows[1..] {
        let orders = orders(row);
        steps += ways.len() * orders.len();
        if steps > MAX_STEPS {
            return None;
        }
        let mut next = BTreeMap::new();
        for (sums, number) in &ways {
            for order in &orders {
                *next.entry(sum(sums, order)).or_insert(0.0) += number / orders.len() as f64;
            }
        }
        ways = next;
    }
    let extreme = ways.iter().filter(|(sums, _)| squares(sums) >= observed);
    Some(extreme.map(|(_, share)| share).sum::<f64>().min(1.0))
}

/// Returns every distinct order of some ranks; all are equally likely.
fn orders(ranks: &[u32]) -> Vec<Vec<u32>> {
    let mut sorted = ranks.to_vec();
    sorted.sort_unstable();
    let mut all = vec![Vec::new()];
    for _ in 0..sorted.len() {
        let extend = |start: &Vec<u32>| {
            let mut left = sorted.clone();
            start.iter().for_each(|used| _ = left.iter().position(|rank| rank == used).map(|place| left.remove(place)));
            left.dedup();
            left.into_iter().map(|rank| [&start[..], &[rank]].concat()).collect::<Vec<_>>()
        };
        all = all.iter().flat_map(extend).collect();
    }
    all
}

/// Returns the mid-ranks, starting at 1, and Σ(t³ − t) over the groups of ties. Neighbors that differ by at most
/// `tolerance` are ties.
pub(crate) fn ranks(values: &[f64], tolerance: f64) -> (Vec<f64>, f64) {
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|l, r| values[*l].total_cmp(&values[*r]));
    let mut ranks = vec![0.0; values.len()];
    let mut ties = 0.0;
    let mut first = 0;
    for group in order.chunk_by(|l, r| values[*r] - values[*l] <= tolerance) {
        let size = group.len() as f64;
        for &index in group {
            ranks[index] = first as f64 + (size + 1.0) / 2.0;
        }
        ties += size * (size * size - 1.0);
        first += group.len();
    }
    (ranks, ties)
}
