//! Counts over fewer factors, for charts of part of a larger design.

use crate::analysis::counts::{Counts, Factor};

/// Counts the ratings by only some of the factors. Ratings that lack a level of one of these factors are excluded.
pub(super) fn project(counts: &Counts, factors: &[usize]) -> Counts {
    let kept = factors.iter().map(|&factor| counts.factors[factor].clone()).collect();
    counts.regrouped(kept, |condition| factors.iter().map(|&factor| condition[factor].map(Some)).collect()).0
}

/// Returns the indices of the factors that have levels: those with several levels first, and among these width and
/// depth first.
pub(super) fn by_interest(counts: &Counts) -> Vec<usize> {
    let rank = |factor: &Factor| {
        let known = ["width", "depth"].iter().position(|name| *name == factor.name).unwrap_or(2);
        (factor.levels.len() < 2, known)
    };
    let mut order: Vec<usize> = (0..counts.factors.len()).filter(|&f| !counts.factors[f].levels.is_empty()).collect();
    order.sort_by_key(|&factor| rank(&counts.factors[factor]));
    order
}

/// Returns at most `most` evenly spaced indices below `count`, including the first and the last.
pub(super) fn evenly(count: usize, most: usize) -> Vec<usize> {
    if count <= most {
        return (0..count).collect();
    }
    (0..most).map(|index| (index * (count - 1) + (most - 1) / 2) / (most - 1)).collect()
}
