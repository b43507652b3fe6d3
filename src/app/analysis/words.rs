//! Numbers and lists as a reader wants them.

use crate::analysis::bootstrap::Interval;

/// A number to some decimals; infinite ones by a word, since no font has every sign.
pub fn fixed(value: f64, decimals: usize) -> String {
    match value {
        value if value.is_nan() => "–".to_owned(),
        value if value.is_infinite() => if value > 0.0 { "infinite" } else { "−infinite" }.to_owned(),
        value => {
            let text = format!("{value:.decimals$}");
            // −0.000 is 0.000, and a minus sign is not a hyphen.
            let zero = text.bytes().all(|byte| matches!(byte, b'-' | b'0' | b'.'));
            if zero { text.trim_start_matches('-').to_owned() } else { text.replace('-', "−") }
        }
    }
}

/// The same, empty where there is none.
pub fn maybe(value: Option<f64>, decimals: usize) -> String {
    value.map(|value| fixed(value, decimals)).unwrap_or_default()
}

/// A probability.
pub fn probability(p: f64) -> String {
    if p < 0.001 { "< 0.001".to_owned() } else { fixed(p, 3) }
}

/// The ends of an interval.
pub fn interval(interval: Interval, decimals: usize) -> String {
    format!("{} to {}", fixed(interval.low, decimals), fixed(interval.high, decimals))
}

/// A number of things: `1 file`, `2 files`.
pub fn many(number: u64, one: &str) -> String {
    let text = grouped(number);
    if number == 1 { format!("{text} {one}") } else { format!("{text} {one}s") }
}

/// A whole number with its thousands apart.
pub fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let mut text = String::new();
    for (index, digit) in digits.char_indices() {
        if index > 0 && (digits.len() - index).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_read_well() {
        assert_eq!([fixed(-0.0001, 3), fixed(-1.25, 2), fixed(f64::NEG_INFINITY, 2)], ["0.000", "−1.25", "−infinite"]);
        assert_eq!([grouped(7), grouped(1_000), grouped(1_234_567)], ["7", "1,000", "1,234,567"]);
        assert_eq!([many(1, "file"), many(0, "file")], ["1 file", "0 files"]);
        assert_eq!([probability(0.000_9), probability(0.001)], ["< 0.001", "0.001"]);
    }
}
