//! The order of levels: numbers in ascending order with `inf` last, and other strings in byte order.

use std::cmp::Ordering;

/// Returns the number that the text of a level represents: a decimal number, or `inf` or `-inf` in any case. `nan` and
/// hexadecimal numbers count as other strings.
pub fn number_of(text: &str) -> Option<f64> {
    text.trim().parse::<f64>().ok().filter(|number| !number.is_nan())
}

/// Returns the numbers of all levels, or `None` if any level is not a number.
pub fn numbers_of<S: AsRef<str>>(levels: &[S]) -> Option<Vec<f64>> {
    levels.iter().map(|level| number_of(level.as_ref())).collect()
}

/// Returns the natural order of two strings from a set. If all of them are numbers (`all_numbers`), they are in
/// ascending order with `inf` last; otherwise, they are in byte order, as in R's C locale and in Python.
pub(super) fn compare(left: &str, right: &str, all_numbers: bool) -> Ordering {
    match (number_of(left), number_of(right)) {
        (Some(l), Some(r)) if all_numbers => l.total_cmp(&r).then_with(|| left.cmp(right)),
        _ => left.cmp(right),
    }
}

/// Returns the natural order of any two strings, with numbers before other strings.
pub(super) fn compare_mixed(left: &str, right: &str) -> Ordering {
    match (number_of(left), number_of(right)) {
        (Some(l), Some(r)) => l.total_cmp(&r).then_with(|| left.cmp(right)),
        (Some(_), None) => Ordering::Less,
        (None, Some(_)) => Ordering::Greater,
        (None, None) => left.cmp(right),
    }
}

/// Returns the distinct levels of some strings, in natural order, and the index of each string's level. If all strings
/// are numbers, strings that mean the same number (`0.1` and `0.10`) are one level, as in R, and its name is the
/// shortest of them. A missing value stays `None`.
pub(super) fn rank(texts: &[Option<&str>]) -> (Vec<String>, Vec<Option<u32>>) {
    let mut present: Vec<&str> = texts.iter().flatten().copied().collect();
    present.sort_unstable();
    present.dedup();
    let all_numbers = present.iter().all(|text| number_of(text).is_some());
    present.sort_by(|l, r| compare(l, r, all_numbers).then_with(|| l.len().cmp(&r.len())));
    let same = |l: &str, r: &str| l == r || (all_numbers && number_of(l) == number_of(r));
    let mut levels: Vec<String> = Vec::new();
    let mut index_of = std::collections::HashMap::new();
    for text in present {
        match levels.last_mut() {
            Some(last) if same(last, text) => {
                if text.len() < last.len() {
                    *last = text.to_owned();
                }
            }
            _ => levels.push(text.to_owned()),
        }
        index_of.insert(text, levels.len() as u32 - 1);
    }
    let indices = texts.iter().map(|text| text.and_then(|text| index_of.get(text).copied())).collect();
    (levels, indices)
}
