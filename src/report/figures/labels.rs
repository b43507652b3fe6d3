//! Names and other text in charts.

use crate::{
    analysis::{Results, number_of},
    report::document::numbers::count,
};

/// Removes line breaks and characters that XML does not allow from a text.
pub(super) fn clean(text: &str) -> String {
    text.chars().map(|c| if c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}') { ' ' } else { c }).collect()
}

/// Estimates the width of a text in a typical sans-serif font. Fonts differ, so the estimate errs on the large side.
pub(super) fn width(text: &str, size: f64) -> f64 {
    let em = |c: char| match c {
        'i' | 'j' | 'l' | 'I' | '\'' | '|' => 0.29,
        ' ' | '.' | ',' | ':' | ';' | '!' | '(' | ')' | '[' | ']' | 'f' | 't' | 'r' | '-' | '/' => 0.39,
        'm' | 'w' | 'M' | 'W' | '@' | '%' | '…' | '∞' => 0.95,
        'A'..='Z' => 0.71,
        // Scripts with square characters, such as Chinese.
        '\u{1100}'..='\u{11ff}' | '\u{2e80}'..='\u{d7ff}' | '\u{f900}'..='\u{faff}' | '\u{1f000}'.. => 1.0,
        _ => 0.59,
    };
    size * text.chars().map(em).sum::<f64>()
}

/// Returns the text, or as much of its beginning and end as fits. The end is kept because levels often differ there.
pub(super) fn fit(text: &str, room: f64, size: f64) -> String {
    let text = clean(text);
    if width(&text, size) <= room {
        return text;
    }
    let chars: Vec<char> = text.chars().collect();
    let ends = |kept: usize| {
        let head: String = chars[..kept.div_ceil(2)].iter().collect();
        let tail: String = chars[chars.len() - kept / 2..].iter().collect();
        format!("{}…{}", head.trim_end(), tail.trim_start())
    };
    (1..chars.len()).rev().map(ends).find(|short| width(short, size) <= room).unwrap_or_else(|| "…".to_owned())
}

/// Formats a level for readers; the depth `inf` becomes ∞.
pub(super) fn level(name: &str) -> String {
    if name.eq_ignore_ascii_case("inf") {
        "∞".to_owned()
    } else {
        name.replace('-', if number_of(name).is_some() { "−" } else { "-" })
    }
}

/// Returns a factor's name as an axis title with its unit, as a legend heading, and as used within a sentence. A factor
/// from elsewhere may mean anything.
fn names(factor: &str, is_ours: bool) -> [&str; 3] {
    match factor {
        other if !is_ours => [other; 3],
        "width" => ["Ramp width (proportion of the window)", "Width", "ramp width"],
        "depth" => ["Continuity depth n", "Depth n", "continuity depth"],
        "orientation_deg" => ["Orientation (degrees)", "Angle (°)", "orientation"],
        other => [other; 3],
    }
}

/// Returns a factor's name as an axis title, with its unit.
pub(super) fn axis(factor: &str, is_ours: bool) -> &str {
    names(factor, is_ours)[0]
}

/// Returns a factor's name as a legend heading.
pub(super) fn heading(factor: &str, is_ours: bool) -> &str {
    names(factor, is_ours)[1]
}

/// Returns a factor's name as used within a sentence.
pub(super) fn in_sentence(factor: &str, is_ours: bool) -> String {
    clean(names(factor, is_ours)[2])
}

/// Names what the ratings measure, which is visibility if any factor is a parameter of our stimuli.
pub(super) fn rating(results: &Results) -> &'static str {
    let is_ours = |name: &str| ["width", "depth", "orientation_deg"].contains(&name);
    if results.options.is_ours && results.measured.counts.factors.iter().any(|factor| is_ours(&factor.name)) {
        "Mean visibility rating"
    } else {
        "Mean rating"
    }
}

/// Returns a caption: it begins with a capital letter and ends with a period.
pub(super) fn sentence(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or_else(String::new, |first| first.to_uppercase().chain(letters).chain(['.']).collect())
}

/// States the size of the sample: `8 participants, 1,920 ratings`.
pub(super) fn sample(results: &Results) -> String {
    let total = results.measured.counts.total();
    format!("{}, {}", count(results.people() as u64, "participant"), count(total, "rating"))
}

/// Explains the error bars, and states the size of the sample.
pub(super) fn bars(results: &Results) -> String {
    let sample = sample(results);
    if results.is_inferential() {
        format!("bars are 95\u{a0}% intervals over participants; {sample}")
    } else {
        format!("bars are 95\u{a0}% intervals over the trials of the only participant; {sample}")
    }
}

/// Says how many levels are shown if not all are: ` (12 of 30 are shown)`.
pub(super) fn some_of(shown: usize, all: usize) -> String {
    if shown < all { format!(" ({shown} of {all} are shown)") } else { String::new() }
}
