//! Agreement between participants (Krippendorff's ordinal α) and within a participant (weighted κ between first and
//! second ratings).

use std::collections::BTreeMap;

use rayon::prelude::*;
use serde::Serialize;

use super::counts::Counts;
use crate::statistics::{Interval, mean_and_sd};

/// Krippendorff's α.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Alpha {
    /// 1 is perfect agreement, 0 is chance agreement, and values below 0 are systematic disagreement.
    pub alpha: f64,
    /// Number of conditions that two or more participants rated.
    pub units: usize,
    /// Number of ratings of these conditions.
    pub ratings: u64,
    /// The 95 % interval over participants: the t interval of the jackknife's pseudo-values, at most 1. `None` if a
    /// condition has fewer than four participants, or if α is the same without any of them.
    pub interval: Option<Interval>,
}

/// Smallest number of participants in each condition for an interval of α.
const LEAST_PER_UNIT: usize = 4;

/// Maximum number of groups of participants that the jackknife leaves out in turn.
const MAX_GROUPS: usize = 100;

/// Smallest number of pairs for κ: that of a single pair is 0 whatever its ratings, and that of a few is far too low.
pub const LEAST_PAIRS: usize = 5;

/// Each participant's ratings of one condition: the categories used, and how often each was used.
type Unit = BTreeMap<usize, Vec<(usize, f64)>>;

/// Returns Krippendorff's ordinal α (Hayes & Krippendorff 2007) with conditions as units and participants as coders.
/// Returns `None` if fewer than two conditions were rated by two participants, because a single one is 0 by construction,
/// or if all ratings are the same.
///
/// With one rating per participant and condition, this is the published coefficient. Repeated ratings by a participant
/// are all used, but they are compared only with ratings by other participants.
pub fn ordinal_alpha(counts: &Counts) -> Option<Alpha> {
    let mut units: Vec<Unit> = vec![Unit::new(); counts.conditions.len()];
    for row in counts.rows.iter().filter(|row| counts.is_complete(row.condition)) {
        let tally = units[row.condition as usize].entry(row.subject as usize).or_default();
        tally.push((row.rating.into(), row.count as f64));
    }
    units.retain(|shares| shares.len() > 1);
    if units.len() < 2 {
        return None;
    }
    // If each unit has few participants, as in a design between them, leaving one out changes too much.
    let enough = units.iter().all(|shares| shares.len() >= LEAST_PER_UNIT);
    let people = counts.subjects.len();
    let of = |weights: &[u8]| self::alpha(&units, weights, counts.categories.len());
    let alpha = of(&vec![1; people])?;
    // Each group of participants is left out once; with few participants, a group is one of them.
    let groups = people.min(MAX_GROUPS);
    let without = |group: usize| {
        let weights: Vec<u8> = (0..people).map(|subject| u8::from(subject % groups != group)).collect();
        Some(groups as f64 * alpha - (groups - 1) as f64 * of(&weights)?)
    };
    let pseudo_values: Option<Vec<f64>> = (0..groups).into_par_iter().map(without).collect();
    let interval = pseudo_values.filter(|_| enough).and_then(|values| Interval::of_mean(&values));
    let ratings: f64 = units.iter().flat_map(Unit::values).flatten().map(|(_, n)| n).sum();
    Some(Alpha { alpha, units: units.len(), ratings: ratings as u64, interval: interval.map(at_most_one) })
}

/// Returns α with each participant counted as many times as its weight. The ordinal metric between two categories is the
/// difference of their mean ranks, so the sums over pairs of categories follow from sums over categories.
fn alpha(units: &[Unit], weights: &[u8], categories: usize) -> Option<f64> {
    let weight = |subject: &usize| f64::from(weights[*subject]);
    let ratings = |tally: &[(usize, f64)]| tally.iter().map(|(_, n)| n).sum::<f64>();
    // Number of ratings in a unit, divided by the number of pairs of ratings by different participants.
    let factors: Vec<(f64, f64)> = units
        .iter()
        .map(|shares| {
            let own = shares.iter().map(|(subject, tally)| weight(subject) * ratings(tally));
            let (size, own_pairs) = own.fold((0.0, 0.0), |(size, pairs), n| (size + n, pairs + n * n));
            let pairs = size * size - own_pairs;
            (size, if pairs > 0.0 { size / pairs } else { 0.0 })
        })
        .collect();
    let mut marginals = vec![0.0; categories];
    for (shares, (size, factor)) in units.iter().zip(&factors) {
        for (subject, tally) in shares {
            let others = factor * weight(subject) * (size - weight(subject) * ratings(tally));
            tally.iter().for_each(|&(c, n)| marginals[c] += others * n);
        }
    }
    let mut below = 0.0;
    let ranks: Vec<f64> = marginals
        .iter()
        .map(|n| {
            below += n;
            below - n / 2.0
        })
        .collect();
    // Sums of n, n·rank and n·rank², and the sum of squared differences of rank over pairs.
    let sums = |tally: &[(usize, f64)]| {
        tally.iter().fold([0.0; 3], |[a, b, c], &(k, n)| [a + n, b + n * ranks[k], c + n * ranks[k] * ranks[k]])
    };
    let spread = |[n, first, second]: [f64; 3]| n * second - first * first;
    let mut observed = 0.0;
    for (shares, (_, factor)) in units.iter().zip(&factors) {
        let (mut all, mut own) = ([0.0; 3], 0.0);
        for (subject, tally) in shares {
            let sums = sums(tally).map(|sum| weight(subject) * sum);
            all.iter_mut().zip(sums).for_each(|(all, sum)| *all += sum);
            own += spread(sums);
        }
        observed += factor * (spread(all) - own);
    }
    let marginals: Vec<(usize, f64)> = marginals.into_iter().enumerate().collect();
    let expected = spread(sums(&marginals));
    // Rounding leaves a little even if all ratings are the same.
    (expected > 1e-12 * below.powi(4)).then(|| 1.0 - (below - 1.0) * observed / expected)
}

/// Returns the mean of participants' κ and its 95 % t interval, at most 1, or `None` if there are no values.
pub fn mean_kappa(values: &[f64]) -> Option<(f64, Option<Interval>)> {
    (!values.is_empty()).then(|| (mean_and_sd(values).0, Interval::of_mean(values).map(at_most_one)))
}

fn at_most_one(Interval { low, high }: Interval) -> Interval {
    Interval { low, high: high.min(1.0) }
}

/// Returns Cohen's κ (1968) with quadratic weights for first and second ratings, given as categories: 1 is perfect
/// agreement, 0 is chance agreement. Returns `None` if there are fewer than [`LEAST_PAIRS`] or all ratings are in the same
/// category.
pub fn kappa(pairs: &[[u8; 2]]) -> Option<f64> {
    let sum = |of: &dyn Fn(f64, f64) -> f64| -> f64 { pairs.iter().map(|[a, b]| of((*a).into(), (*b).into())).sum() };
    let observed = sum(&|a, b| (a - b) * (a - b));
    // Σᵢⱼ (i − j)² rᵢ cⱼ / n, for rᵢ first ratings i and cⱼ second ratings j.
    let expected = sum(&|a, b| a * a + b * b) - 2.0 * sum(&|a, _| a) * sum(&|_, b| b) / pairs.len() as f64;
    (pairs.len() >= LEAST_PAIRS && expected > 0.0).then(|| 1.0 - observed / expected)
}
