//! Descriptive statistics: the number, mean, median and proportions of the ratings in each cell, at each factor level
//! and by each participant.

use std::collections::BTreeMap;

use rayon::prelude::*;
use serde::Serialize;

use super::{
    counts::{Combinations, CountRow, Counts},
    levels,
};
use crate::statistics::{Interval, mean_and_sd};

/// A summary of the ratings in one group.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Summary {
    /// Number of ratings.
    pub n: u64,
    /// Number of participants who gave these ratings.
    pub subjects: usize,
    /// Mean rating. A category counts as its number or, if the categories are not numbers, as its position, starting at
    /// 0. Each participant counts equally, and each condition of a participant counts equally, regardless of how many
    /// ratings there are.
    pub mean: f64,
    /// Median rating. For an even number of ratings, it is halfway between the two in the middle.
    pub median: f64,
    /// Proportion of ratings in each category.
    pub proportions: Vec<f64>,
    /// The 95 % interval of the mean over participants, or over trials if the study has only one participant. `None` if
    /// there are fewer than two, or all have the same mean.
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
    levels::values_of(&counts.categories)
}

/// Summarizes every cell of the design that has ratings.
pub fn by_cell(counts: &Counts) -> Vec<Group> {
    by_levels(counts, &(0..counts.factors.len()).collect::<Vec<_>>())
}

/// Summarizes every combination of the levels of some factors, given by index.
pub fn by_levels(counts: &Counts, factors: &[usize]) -> Vec<Group> {
    let Combinations { all, of } = counts.combinations(factors);
    let name = |group: usize| counts.names(factors, &all[group]).into_iter().map(str::to_owned).collect();
    groups(counts, all.len(), |_, condition| of[condition as usize], name, true)
}

/// Summarizes every level of a factor. Ratings without a level are left out.
pub fn by_factor(counts: &Counts, factor: usize) -> Vec<Group> {
    by_levels(counts, &[factor]).into_iter().filter(|group| !group.names[0].is_empty()).collect()
}

/// Summarizes every participant, without intervals.
pub fn by_subject(counts: &Counts) -> Vec<Group> {
    let name = |group: usize| vec![counts.subjects[group].clone()];
    groups(counts, counts.subjects.len(), |subject, _| subject as usize, name, false)
}

/// Returns the mean rating of each participant in each condition that they rated: participant, condition and mean.
pub(super) fn cell_means(counts: &Counts) -> impl Iterator<Item = (u32, u32, f64)> {
    let values = category_values(counts);
    let mean = move |cell: &[CountRow]| {
        let n: u64 = cell.iter().map(|row| row.count).sum();
        let sum: f64 = cell.iter().map(|row| row.count as f64 * values[row.rating as usize]).sum();
        (n > 0).then(|| (cell[0].subject, cell[0].condition, sum / n as f64))
    };
    // Rows are sorted by participant and condition.
    counts.rows.chunk_by(|l, r| (l.subject, l.condition) == (r.subject, r.condition)).filter_map(mean)
}

/// Computes, for each of some groups of the conditions, the mean rating of each participant who rated any: each condition counts
/// equally.
pub fn means_by_subject(
    counts: &Counts,
    groups: usize,
    group_of: impl Fn(u32, u32) -> Option<usize>,
) -> Vec<BTreeMap<u32, f64>> {
    let mut sums: Vec<BTreeMap<u32, (f64, f64)>> = vec![BTreeMap::new(); groups];
    for (subject, condition, mean) in cell_means(counts) {
        let Some(group) = group_of(subject, condition) else { continue };
        let (conditions, sum) = sums[group].entry(subject).or_default();
        *conditions += 1.0;
        *sum += mean;
    }
    let means = |group: BTreeMap<u32, (f64, f64)>| group.into_iter().map(|(own, (n, sum))| (own, sum / n)).collect();
    sums.into_iter().map(means).collect()
}

fn groups(
    counts: &Counts,
    number: usize,
    group_of: impl Fn(u32, u32) -> usize,
    name: impl Fn(usize) -> Vec<String> + Sync,
    intervals: bool,
) -> Vec<Group> {
    let values = category_values(counts);
    let mut tallies = vec![vec![0_u64; values.len()]; number];
    for row in &counts.rows {
        tallies[group_of(row.subject, row.condition)][row.rating as usize] += row.count;
    }
    let means = means_by_subject(counts, number, |subject, condition| Some(group_of(subject, condition)));
    let single = counts.subjects.len() == 1;
    (tallies.par_iter().zip(&means).enumerate())
        .filter(|(_, (tally, _))| tally.iter().any(|count| *count > 0))
        .map(|(group, (tally, means))| {
            let means: Vec<f64> = means.values().copied().collect();
            Group { names: name(group), summary: summarize(tally, &values, &means, intervals, single) }
        })
        .collect()
}

/// Summarizes ratings from their tally and the participants' means. With a `single` participant, the interval is that
/// over the trials.
fn summarize(tally: &[u64], values: &[f64], means: &[f64], intervals: bool, single: bool) -> Summary {
    let n: u64 = tally.iter().sum();
    let (mean, mut sd) = mean_and_sd(means);
    let mut sample = means.len() as f64;
    if single {
        sample = n as f64;
        let pooled = tally.iter().zip(values).map(|(&count, value)| count as f64 * value).sum::<f64>() / sample;
        let squares = tally.iter().zip(values).map(|(&count, value)| count as f64 * (value - pooled).powi(2));
        sd = (squares.sum::<f64>() / (sample - 1.0)).sqrt();
    }
    let ends = [f64::INFINITY, f64::NEG_INFINITY];
    let ends = values.iter().fold(ends, |[low, high], value| [low.min(*value), high.max(*value)]);
    Summary {
        n,
        subjects: means.len(),
        mean,
        median: (value_at(tally, values, (n - 1) / 2) + value_at(tally, values, n / 2)) / 2.0,
        proportions: tally.iter().map(|&count| count as f64 / n as f64).collect(),
        interval: Interval::of_bounded_mean(sample, mean, sd, ends).filter(|_| intervals && sample > 1.0),
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
