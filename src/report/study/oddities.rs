//! What participants did that a reader should look at: one category only, answers in haste, ratings not repeated.

use crate::analysis::{Results, results::SubjectResults};
use crate::report::document::numbers::{count, fixed, percent, short_list, unit};

/// Proportion of one category from which a subject is said to have used hardly another.
const NEARLY_ALL: f64 = 0.9;
/// Fewer ratings say nothing about how somebody uses the scale.
const FEW_RATINGS: u64 = 10;
/// κ up to which agreement is "slight" at most, Landis & Koch (1977).
pub(crate) const LOW_KAPPA: f64 = 0.2;
/// Median response time, seconds, in which nobody looks and decides.
const HASTY_S: f64 = 0.3;
/// A participant's median time is odd where it is so many times longer or shorter than the middle one.
const ODD_TIMES: f64 = 3.0;
/// Most names in one sentence.
const MOST_NAMES: usize = 6;

/// What participants did that a reader should look at, in sentences.
pub(crate) fn oddities(results: &Results) -> Vec<String> {
    let subjects = &results.subjects;
    let mut sentences: Vec<String> = subjects.iter().filter_map(|subject| one_category(results, subject)).collect();
    sentences.extend(little_agreement(subjects));
    sentences.extend(haste(subjects));
    sentences.extend(odd_times(subjects));
    sentences
}

fn name(subject: &SubjectResults) -> &str {
    subject.group.names.first().map_or("", String::as_str)
}

fn one_category(results: &Results, subject: &SubjectResults) -> Option<String> {
    let (who, summary) = (name(subject), &subject.group.summary);
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
        format!("{who} used hardly more than one category: {share} of {ratings} are {category}.")
    })
}

/// Several people with the same oddity share a sentence.
fn little_agreement(subjects: &[SubjectResults]) -> Option<String> {
    let low: Vec<(&str, f64)> =
        subjects.iter().filter_map(|s| Some((name(s), s.kappa?))).filter(|(_, kappa)| *kappa <= LOW_KAPPA).collect();
    let (least, most) = ends(&low)?;
    let who: Vec<&str> = low.iter().map(|(who, _)| *who).collect();
    let (least, most) = (unit(least), unit(most));
    let kappa = if least == most { format!("= {least}") } else { format!("from {least} to {most}") };
    Some(format!("{} agreed little with their own first ratings: κ {kappa}.", short_list(&who, MOST_NAMES)))
}

fn haste(subjects: &[SubjectResults]) -> Option<String> {
    let hasty: Vec<(&str, f64)> = subjects
        .iter()
        .filter_map(|s| Some((name(s), s.times?.median)))
        .filter(|(_, median)| *median < HASTY_S)
        .collect();
    let (_, most) = ends(&hasty)?;
    let who: Vec<&str> = hasty.iter().map(|(who, _)| *who).collect();
    Some(format!(
        "Half of the answers of {} came within {} s: too fast to look and decide.",
        short_list(&who, MOST_NAMES),
        fixed(most, 2)
    ))
}

fn ends(values: &[(&str, f64)]) -> Option<(f64, f64)> {
    let numbers = || values.iter().map(|(_, value)| *value);
    Some((numbers().min_by(f64::total_cmp)?, numbers().max_by(f64::total_cmp)?))
}

fn odd_times(subjects: &[SubjectResults]) -> Vec<String> {
    let medians: Vec<(&str, f64)> =
        subjects.iter().filter_map(|subject| Some((name(subject), subject.times?.median))).collect();
    let mut sorted: Vec<f64> = medians.iter().map(|(_, median)| *median).collect();
    sorted.sort_by(f64::total_cmp);
    // With two, neither is the odd one.
    let Some(&middle) = sorted.get(sorted.len() / 2).filter(|_| sorted.len() > 2) else { return Vec::new() };
    (medians.into_iter())
        // Of those who answer in haste this is said already.
        .filter(|(_, median)| *median > ODD_TIMES * middle || (*median * ODD_TIMES < middle && *median >= HASTY_S))
        .map(|(who, median)| {
            let slow = if median > middle { "slowly" } else { "fast" };
            let (own, usual) = (fixed(median, 2), fixed(middle, 2));
            format!("{who} answered unusually {slow}: {own} s at the median, where {usual} s is usual here.")
        })
        .collect()
}
