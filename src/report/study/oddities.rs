//! What participants did that a reader should look at: one category only, hasty answers, ratings not repeated.

use super::{limits::LOW_KAPPA, names::participant};
use crate::{
    analysis::{Results, results::SubjectResults},
    report::document::numbers::{count, fixed, percent, short_list, unit},
};

/// Proportion of one category from which a participant is said to have used hardly another.
const NEARLY_ALL: f64 = 0.9;
/// Fewer ratings say nothing about how somebody uses the scale.
const FEW_RATINGS: u64 = 10;
/// Median response time, seconds, in which nobody looks and decides.
const HASTY_S: f64 = 0.3;
/// A participant's median time is odd where it is so many times longer or shorter than the middle one.
const ODD_TIMES: f64 = 3.0;
/// Most names in one sentence.
const MOST_NAMES: usize = 6;

/// What participants did that a reader should look at, in sentences.
pub(super) fn oddities(results: &Results) -> Vec<String> {
    let subjects = &results.subjects;
    let mut sentences: Vec<String> = subjects.iter().filter_map(|subject| one_category(results, subject)).collect();
    sentences.extend(little_agreement(subjects));
    sentences.extend(haste(subjects));
    sentences.extend(odd_times(subjects));
    sentences
}

fn one_category(results: &Results, subject: &SubjectResults) -> Option<String> {
    let (who, summary) = (participant(subject), &subject.group.summary);
    let (category, &share) = summary.proportions.iter().enumerate().max_by(|l, r| l.1.total_cmp(r.1))?;
    if share < NEARLY_ALL || summary.n < FEW_RATINGS {
        return None;
    }
    let category = &results.measured.counts.categories[category];
    let ratings = count(summary.n, "rating");
    Some(if share >= 1.0 {
        format!("{who} used one category only: all {ratings} are {category}.")
    } else {
        let share = percent((share * 100.0).floor() / 100.0);
        format!("{who} hardly used more than one category: {share} of {ratings} are {category}.")
    })
}

/// Those for whom a value is odd, by name, and the least and the greatest such value.
fn odd(
    subjects: &[SubjectResults],
    value: impl Fn(&SubjectResults) -> Option<f64>,
    is_odd: impl Fn(f64) -> bool,
) -> Option<(String, f64, f64)> {
    let found: Vec<(&str, f64)> =
        subjects.iter().filter_map(|s| Some((participant(s), value(s).filter(|value| is_odd(*value))?))).collect();
    let who: Vec<&str> = found.iter().map(|(who, _)| *who).collect();
    let values = || found.iter().map(|(_, value)| *value);
    Some((short_list(&who, MOST_NAMES), values().min_by(f64::total_cmp)?, values().max_by(f64::total_cmp)?))
}

/// Several people with the same oddity share a sentence.
fn little_agreement(subjects: &[SubjectResults]) -> Option<String> {
    let (who, least, most) = odd(subjects, |s| s.kappa, |kappa| kappa <= LOW_KAPPA)?;
    let (least, most) = (unit(least), unit(most));
    let kappa = if least == most { format!("= {least}") } else { format!("from {least} to {most}") };
    Some(format!("{who} agreed little with their own first ratings: κ {kappa}."))
}

fn haste(subjects: &[SubjectResults]) -> Option<String> {
    let (who, _, most) = odd(subjects, |s| Some(s.times?.median), |median| median < HASTY_S)?;
    Some(format!("Half of the answers of {who} came within {} s: too fast to look and decide.", fixed(most, 2)))
}

fn odd_times(subjects: &[SubjectResults]) -> Vec<String> {
    let medians: Vec<(&str, f64)> = subjects.iter().filter_map(|s| Some((participant(s), s.times?.median))).collect();
    let mut sorted: Vec<f64> = medians.iter().map(|(_, median)| *median).collect();
    sorted.sort_by(f64::total_cmp);
    // With two, neither is the odd one.
    let Some(&middle) = sorted.get(sorted.len() / 2).filter(|_| sorted.len() > 2) else { return Vec::new() };
    (medians.into_iter())
        // Of hasty answers this is said already.
        .filter(|(_, median)| *median > ODD_TIMES * middle || (*median * ODD_TIMES < middle && *median >= HASTY_S))
        .map(|(who, median)| {
            let slow = if median > middle { "slowly" } else { "fast" };
            let (own, usual) = (fixed(median, 2), fixed(middle, 2));
            format!("{who} answered unusually {slow}: the median time is {own} s; {usual} s is usual here.")
        })
        .collect()
}
