//! Descriptive statistics: the number, mean, median and proportions of the ratings in each cell, at each factor level
//! and by each participant.

use rayon::prelude::*;
use serde::Serialize;

use super::{
    bootstrap::{Interval, Resamples},
    counts::Counts,
    levels,
};

/// A summary of the ratings in one group.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Summary {
    /// Number of ratings.
    pub n: u64,
    /// Number of participants who gave these ratings.
    pub subjects: usize,
    /// Mean rating. A category counts as its number or, if the categories are not numbers, as its position, starting at
    /// 0.
    pub mean: f64,
    /// Median rating. For an even number of ratings, it is halfway between the two in the middle.
    pub median: f64,
    /// Proportion of ratings in each category.
    pub proportions: Vec<f64>,
    /// Bootstrap interval of the mean over participants; `None` if there is only one participant.
    pub interval: Option<Interval>,
}

/// The ratings at one combination of levels or by one participant.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Group {
    /// Names of the levels, in the order of the factors; a missing value has an empty name. For a participant, the
    /// participant's name.
    pub names: Vec<String>,
    /// The summary of their ratings.
    pub summary: Summary,
}

/// Returns the number that each category represents.
pub fn category_values(counts: &Counts) -> Vec<f64> {
    levels::numbers_of(&counts.categories)
        .filter(|numbers| numbers.iter().all(|number| number.is_finite()))
        .unwrap_or_else(|| (0..counts.categories.len()).map(|index| index as f64).collect())
}

/// Summarizes every cell of the design that has ratings.
pub fn by_cell(counts: &Counts, resamples: &Resamples) -> Vec<Group> {
    let name = |group: usize| -> Vec<String> {
        let levels = counts.conditions[group].iter().zip(&counts.factors);
        levels.map(|(level, factor)| level_name(&factor.levels, *level)).collect()
    };
    groups(counts, counts.conditions.len(), |row| Some(row.condition as usize), name, Some(resamples))
}

/// Summarizes every level of a factor, pooled over all other factors.
pub fn by_factor(counts: &Counts, factor: usize, resamples: &Resamples) -> Vec<Group> {
    let levels = &counts.factors[factor].levels;
    let level = |condition: u32| counts.conditions[condition as usize][factor].map(|level| level as usize);
    groups(counts, levels.len(), |row| level(row.condition), |group| vec![levels[group].clone()], Some(resamples))
}

/// Summarizes every participant. There are no intervals, because the bootstrap resamples participants.
pub fn by_subject(counts: &Counts) -> Vec<Group> {
    let name = |group: usize| vec![counts.subjects[group].clone()];
    groups(counts, counts.subjects.len(), |row| Some(row.subject as usize), name, None)
}

fn level_name(levels: &[String], level: Option<u32>) -> String {
    level.map(|level| levels[level as usize].clone()).unwrap_or_default()
}

/// One participant's ratings in one group.
#[derive(Clone, Copy)]
struct Share {
    subject: usize,
    n: f64,
    sum: f64,
}

fn groups(
    counts: &Counts,
    number: usize,
    group_of: impl Fn(&super::counts::CountRow) -> Option<usize>,
    name: impl Fn(usize) -> Vec<String> + Sync,
    resamples: Option<&Resamples>,
) -> Vec<Group> {
    let values = category_values(counts);
    let mut tallies = vec![vec![0_u64; values.len()]; number];
    let mut shares: Vec<Vec<Share>> = vec![Vec::new(); number];
    // Rows are sorted by participant, so either a group's last share belongs to this participant or a new share is
    // needed.
    for row in &counts.rows {
        let Some(group) = group_of(row) else { continue };
        tallies[group][row.rating as usize] += row.count;
        let (subject, n) = (row.subject as usize, row.count as f64);
        if shares[group].last().is_none_or(|share| share.subject != subject) {
            shares[group].push(Share { subject, n: 0.0, sum: 0.0 });
        }
        if let Some(share) = shares[group].last_mut() {
            share.n += n;
            share.sum += n * values[row.rating as usize];
        }
    }
    (tallies.par_iter().zip(&shares).enumerate())
        .filter(|(_, (tally, _))| tally.iter().any(|count| *count > 0))
        .map(|(group, (tally, shares))| {
            let interval = resamples.and_then(|resamples| {
                let means = resamples.weights.iter().map(|weights| resampled_mean(shares, weights)).collect();
                resamples.interval(shares.len(), means)
            });
            Group { names: name(group), summary: summarize(tally, &values, shares.len(), interval) }
        })
        .collect()
}

fn resampled_mean(shares: &[Share], weights: &[u8]) -> f64 {
    let (n, sum) = shares.iter().fold((0.0, 0.0), |(n, sum), share| {
        let weight = f64::from(weights[share.subject]);
        (n + weight * share.n, sum + weight * share.sum)
    });
    sum / n
}

fn summarize(tally: &[u64], values: &[f64], subjects: usize, interval: Option<Interval>) -> Summary {
    let n: u64 = tally.iter().sum();
    let share = |count: u64| count as f64 / n as f64;
    Summary {
        n,
        subjects,
        mean: tally.iter().zip(values).map(|(&count, value)| count as f64 * value).sum::<f64>() / n as f64,
        median: (value_at(tally, values, (n - 1) / 2) + value_at(tally, values, n / 2)) / 2.0,
        proportions: tally.iter().map(|&count| share(count)).collect(),
        interval,
    }
}

/// Returns the value at a position in the sorted ratings.
fn value_at(tally: &[u64], values: &[f64], position: u64) -> f64 {
    let mut below = 0;
    for (&count, &value) in tally.iter().zip(values) {
        below += count;
        if position < below {
            return value;
        }
    }
    f64::NAN
}
