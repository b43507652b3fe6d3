//! The order of levels: numbers by size, `inf` last, texts by their bytes.

use std::cmp::Ordering;

/// The number that a level's text means: a decimal number, `inf` or `-inf` in any case. `nan` and hexadecimal numbers
/// are texts.
pub fn number_of(text: &str) -> Option<f64> {
    text.trim().parse::<f64>().ok().filter(|number| !number.is_nan())
}

/// The numbers of all levels; `None` if any of them is a text.
pub fn numbers_of<S: AsRef<str>>(levels: &[S]) -> Option<Vec<f64>> {
    levels.iter().map(|level| number_of(level.as_ref())).collect()
}

/// Natural order of two texts out of a set in which all are numbers, or not: numbers ascending, `inf` last; otherwise
/// bytes, as in R's C locale and in Python.
pub(super) fn compare(left: &str, right: &str, all_numbers: bool) -> Ordering {
    match (number_of(left), number_of(right)) {
        (Some(l), Some(r)) if all_numbers => l.total_cmp(&r).then_with(|| left.cmp(right)),
        _ => left.cmp(right),
    }
}

/// Natural order of any two texts: numbers before texts.
pub(super) fn compare_mixed(left: &str, right: &str) -> Ordering {
    match (number_of(left), number_of(right)) {
        (Some(l), Some(r)) => l.total_cmp(&r).then_with(|| left.cmp(right)),
        (Some(_), None) => Ordering::Less,
        (None, Some(_)) => Ordering::Greater,
        (None, None) => left.cmp(right),
    }
}

/// The distinct levels among some texts, in natural order, and for every text the index of its level. Texts that mean
/// the same number (`0.1` and `0.10`) are one level where all of them are numbers, as in R; its name is the shortest
/// of them. None stays None: a missing value.
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
