//! Names and other text in charts, and which factors and levels they show.

use crate::{
    analysis::{
        Results,
        counts::{Counts, Factor},
    },
    report::{document::count, names},
};

/// Text size.
pub(super) const TEXT: f64 = 29.0;

/// Removes line breaks and characters that XML does not allow from a text.
pub(super) fn clean(text: &str) -> String {
    text.chars().map(|c| if c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}') { ' ' } else { c }).collect()
}

/// Estimates the width of a text in a typical sans-serif font. Fonts differ, so the estimate errs on the large side.
pub(super) fn width(text: &str) -> f64 {
    let em = |c: char| match c {
        'i' | 'j' | 'l' | 'I' | '\'' | '|' => 0.29,
        ' ' | '.' | ',' | ':' | ';' | '!' | '(' | ')' | '[' | ']' | 'f' | 't' | 'r' | '-' | '/' => 0.39,
        'm' | 'w' | 'M' | 'W' | '@' | '%' | '…' | '∞' => 0.95,
        'A'..='Z' => 0.71,
        // Scripts with square characters, such as Chinese.
        '\u{1100}'..='\u{11ff}' | '\u{2e80}'..='\u{d7ff}' | '\u{f900}'..='\u{faff}' | '\u{1f000}'.. => 1.0,
        _ => 0.59,
    };
    TEXT * text.chars().map(em).sum::<f64>()
}

/// Returns the text, or as much of its beginning and end as fits. The end is kept because levels often differ there.
pub(super) fn fit(text: &str, room: f64) -> String {
    let text = clean(text);
    if width(&text) <= room {
        return text;
    }
    let chars: Vec<char> = text.chars().collect();
    let ends = |kept: usize| {
        let head: String = chars[..kept.div_ceil(2)].iter().collect();
        let tail: String = chars[chars.len() - kept / 2..].iter().collect();
        format!("{}…{}", head.trim_end(), tail.trim_start())
    };
    (1..chars.len()).rev().map(ends).find(|short| width(short) <= room).unwrap_or_else(|| "…".to_owned())
}

/// Formats a level for readers; the depth `inf` becomes ∞.
pub(super) fn level(name: &str) -> String {
    names::level(names::Known::None, "", name).to_string()
}

/// States the size of the sample: `8 participants, 1,920 ratings`.
pub(super) fn sample(results: &Results) -> String {
    let (people, ratings) = (results.people() as u64, results.measured.counts.total());
    format!("{}, {}", count(people, "participant"), count(ratings, "rating"))
}

/// Explains the error bars, and states the size of the sample.
pub(super) fn bars(results: &Results) -> String {
    let whose = if results.is_inferential() { "participants" } else { "the trials of the only participant" };
    format!("bars are 95\u{a0}% intervals over {whose}; {}", sample(results))
}

/// Says how many levels are shown if not all are: ` (12 of 30 are shown)`.
pub(super) fn some_of(shown: usize, all: usize) -> String {
    if shown < all { format!(" ({shown} of {all} are shown)") } else { String::new() }
}

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
