//! Which factors and levels a chart shows.

use crate::analysis::counts::{Counts, Factor};

/// Returns the indices of the two most interesting factors, or of one: those with several levels come first, and among these
/// width and depth.
pub(super) fn chosen(counts: &Counts) -> Vec<usize> {
    let rank = |factor: &Factor| {
        let known = ["width", "depth"].iter().position(|name| *name == factor.name).unwrap_or(2);
        (factor.levels.len() < 2, known)
    };
    let mut order: Vec<usize> = (0..counts.factors.len()).filter(|&f| !counts.factors[f].levels.is_empty()).collect();
    order.sort_by_key(|&factor| rank(&counts.factors[factor]));
    order.truncate(2);
    order
}

/// Returns at most `most` evenly spaced indices below `count`, including the first and the last.
pub(super) fn evenly(count: usize, most: usize) -> Vec<usize> {
    if count <= most {
        return (0..count).collect();
    }
    (0..most).map(|index| (index * (count - 1) + (most - 1) / 2) / (most - 1)).collect()
}
