//! The order of levels. A level is identified by its text; numbers only order levels.

use std::cmp::Ordering;

use crate::text::names::natural;
pub use crate::text::number::{number_of, numbers_of};

/// Returns the number that each category represents: its own number or, if the categories are not finite numbers, its
/// position, starting at 0.
pub(super) fn values_of(categories: &[String]) -> Vec<f64> {
    numbers_of(categories)
        .filter(|numbers| numbers.iter().all(|number| number.is_finite()))
        .unwrap_or_else(|| (0..categories.len()).map(|index| index as f64).collect())
}

/// Returns the order of any two strings: numbers in ascending order, with `inf` last, before other strings in natural
/// order.
pub(super) fn compare_mixed(left: &str, right: &str) -> Ordering {
    match (number_of(left), number_of(right)) {
        (Some(l), Some(r)) => l.total_cmp(&r).then_with(|| left.len().cmp(&right.len())).then_with(|| left.cmp(right)),
        (Some(_), None) => Ordering::Less,
        (None, Some(_)) => Ordering::Greater,
        (None, None) => natural(left, right),
    }
}

/// Sorts different strings: in ascending order if all of them are numbers, and otherwise in natural order. Strings for
/// the same number, such as `0.1` and `0.10`, stay apart.
pub(super) fn sort<S: AsRef<str>>(levels: &mut [S]) {
    if levels.iter().all(|level| number_of(level.as_ref()).is_some()) {
        levels.sort_by(|l, r| compare_mixed(l.as_ref(), r.as_ref()));
    } else {
        levels.sort_by(|l, r| natural(l.as_ref(), r.as_ref()));
    }
}

/// Returns the distinct levels of some strings, sorted, and the index of each string's level. A missing value stays `None`.
/// Levels in `declared` come first, in that order.
pub(super) fn rank(declared: &[String], texts: &[Option<&str>]) -> (Vec<String>, Vec<Option<u32>>) {
    let mut present: Vec<&str> = texts.iter().flatten().copied().collect();
    present.sort_unstable();
    present.dedup();
    sort(&mut present);
    // A number may be written in several ways.
    let same = |level: &str, text: &str| level == text || number_of(level).is_some_and(|n| number_of(text) == Some(n));
    let place = |text: &str| declared.iter().position(|level| same(level, text)).unwrap_or(declared.len());
    present.sort_by_key(|text| place(text));
    let index_of: std::collections::HashMap<&str, u32> = present.iter().copied().zip(0..).collect();
    let indices = texts.iter().map(|text| text.and_then(|text| index_of.get(text).copied())).collect();
    (present.into_iter().map(str::to_owned).collect(), indices)
}
