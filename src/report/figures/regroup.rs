//! Counts over fewer or different factors, for charts of part of a larger design.

use crate::analysis::counts::{CountRow, Counts, Factor};

/// Counts the same ratings by new factors. `levels` returns a condition's levels of the new factors, or `None` to
/// exclude its ratings.
pub(super) fn regroup(
    counts: &Counts,
    factors: Vec<Factor>,
    levels: impl Fn(&[Option<u32>]) -> Option<Vec<u32>>,
) -> Counts {
    let new: Vec<Option<Vec<u32>>> = counts.conditions.iter().map(|condition| levels(condition)).collect();
    let mut conditions: Vec<Vec<u32>> = new.iter().flatten().cloned().collect();
    conditions.sort_unstable();
    conditions.dedup();
    let index: Vec<Option<u32>> =
        (new.iter()).map(|levels| conditions.binary_search(levels.as_ref()?).ok().map(|index| index as u32)).collect();
    let mut rows: Vec<CountRow> = (counts.rows.iter())
        .filter_map(|row| index[row.condition as usize].map(|condition| CountRow { condition, ..*row }))
        .collect();
    rows.sort_unstable();
    rows.dedup_by(|row, kept| {
        let same = (row.subject, row.condition, row.rating) == (kept.subject, kept.condition, kept.rating);
        if same {
            kept.count += row.count;
        }
        same
    });
    Counts {
        subjects: counts.subjects.clone(),
        factors,
        conditions: conditions.into_iter().map(|levels| levels.into_iter().map(Some).collect()).collect(),
        categories: counts.categories.clone(),
        rows,
    }
}

/// Counts the ratings by only some of the factors. Ratings that lack a level of one of these factors are excluded.
pub(super) fn project(counts: &Counts, factors: &[usize]) -> Counts {
    let kept = factors.iter().map(|&factor| counts.factors[factor].clone()).collect();
    regroup(counts, kept, |condition| factors.iter().map(|&factor| condition[factor]).collect())
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
