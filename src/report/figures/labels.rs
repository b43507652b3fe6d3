//! Names as they are set in a chart.

use crate::analysis::Results;

/// The text without characters that XML does not allow, or that end a line.
pub(super) fn clean(text: &str) -> String {
    text.chars().map(|c| if c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}') { ' ' } else { c }).collect()
}

/// Width of a text in a sans serif of ordinary width. Fonts differ, so it is an estimate, rather too large.
pub(super) fn width(text: &str, size: f64) -> f64 {
    size * text.chars().map(em).sum::<f64>()
}

fn em(c: char) -> f64 {
    match c {
        'i' | 'j' | 'l' | 'I' | '\'' | '|' => 0.29,
        ' ' | '.' | ',' | ':' | ';' | '!' | '(' | ')' | '[' | ']' | 'f' | 't' | 'r' | '-' | '/' => 0.39,
        'm' | 'w' | 'M' | 'W' | '@' | '%' | '…' | '∞' => 0.95,
        'A'..='Z' => 0.71,
        // Scripts whose characters are as wide as they are high.
        '\u{1100}'..='\u{11ff}' | '\u{2e80}'..='\u{d7ff}' | '\u{f900}'..='\u{faff}' | '\u{1f000}'.. => 1.0,
        _ => 0.59,
    }
}

/// The text, or as much of its two ends as there is room for: levels often differ at the end.
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

/// A level as it is read: the depth `inf` is ∞.
pub(super) fn level(name: &str) -> String {
    if name.eq_ignore_ascii_case("inf") {
        "∞".to_owned()
    } else {
        name.replace('-', if is_number(name) { "−" } else { "-" })
    }
}

fn is_number(name: &str) -> bool {
    crate::analysis::number_of(name).is_some()
}

/// A factor as the title of an axis, with its unit.
pub(super) fn axis(factor: &str) -> String {
    match factor {
        "width" => "Ramp width (proportion of the window)".to_owned(),
        "depth" => "Continuity depth n".to_owned(),
        "orientation_deg" => "Orientation (degrees)".to_owned(),
        other => other.to_owned(),
    }
}

/// A factor as the heading of a legend.
pub(super) fn heading(factor: &str) -> String {
    match factor {
        "width" => "Width".to_owned(),
        "depth" => "Depth n".to_owned(),
        "orientation_deg" => "Angle (°)".to_owned(),
        other => other.to_owned(),
    }
}

/// A factor within a sentence.
pub(super) fn word(factor: &str) -> String {
    match factor {
        "width" => "ramp width".to_owned(),
        "depth" => "continuity depth".to_owned(),
        "orientation_deg" => "orientation".to_owned(),
        other => clean(other),
    }
}

/// What the ratings are about: bands, where the factors are those of our stimuli.
pub(super) fn rating(results: &Results) -> &'static str {
    let ours = ["width", "depth", "orientation_deg"];
    let counts = &results.measured.counts;
    if counts.factors.iter().any(|factor| ours.contains(&factor.name.as_str())) {
        "Mean visibility rating"
    } else {
        "Mean rating"
    }
}

/// How much was measured: `8 subjects, 1920 ratings`.
pub(super) fn sample(results: &Results) -> String {
    let counts = &results.measured.counts;
    format!("{}, {}", number(counts.subjects.len() as u64, "subject"), number(counts.total(), "rating"))
}

/// A number of things: `1 rating`, `2 ratings`.
pub(super) fn number(n: u64, thing: &str) -> String {
    format!("{n} {thing}{}", if n == 1 { "" } else { "s" })
}

/// What the bars on means are, and how much was measured.
pub(super) fn bars(results: &Results) -> String {
    let sample = sample(results);
    if results.is_inferential() {
        let bootstrap = &results.options.bootstrap;
        let level = 100.0 * bootstrap.level;
        format!("bars are {level} % bootstrap intervals over subjects ({} samples); {sample}", bootstrap.replicates)
    } else {
        format!("one person, so there are no intervals; {sample}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_names_keep_both_ends() {
        let name = "gradient with repaired normals, version 12";
        let short = fit(name, 160.0, 17.0);
        assert!(short.starts_with("grad") && short.ends_with("12") && short.contains('…'), "{short}");
        assert!(width(&short, 17.0) <= 160.0);
        assert_eq!(fit("0.4", 160.0, 17.0), "0.4");
        assert_eq!(fit("abc", 1.0, 17.0), "…");
        assert_eq!(fit("a\u{0}b\n", 160.0, 17.0), "a b ");
    }

    #[test]
    fn numbers_have_a_minus_and_texts_a_hyphen() {
        assert_eq!([level("-2"), level("inf"), level("Inf"), level("a-b")], ["−2", "∞", "∞", "a-b"]);
    }
}
