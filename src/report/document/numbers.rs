//! Formats numbers as readers expect them: with reasonable precision, thousands separators, and no leading zero in a
//! probability. A dash stands for a missing number. The value remains with what is shown, and tables are sorted by it.

use std::{fmt, ops::Deref};

use crate::{statistics::Interval, text::Cell};

/// A no-break space.
pub const NBSP: &str = "\u{a0}";

/// Formats a whole number with thousands separators: `1,920`.
pub fn whole(number: u64) -> Shown {
    let digits: Vec<char> = number.to_string().chars().collect();
    Shown::new(number, digits.rchunks(3).rev().map(String::from_iter).collect::<Vec<_>>().join(","))
}

/// Says how often: `once`, `twice`, `3 times`.
pub fn times(number: u32) -> String {
    match number {
        1 => "once".to_owned(),
        2 => "twice".to_owned(),
        n => format!("{n} times"),
    }
}

/// Formats a number with the given number of decimals and a true minus sign.
pub fn fixed(number: impl Into<Option<f64>>, decimals: usize) -> Shown {
    let number = number.into().unwrap_or(f64::NAN);
    if number.is_nan() {
        return Shown::new(number, "–");
    }
    let text = if number.is_infinite() { "∞".to_owned() } else { format!("{:.decimals$}", number.abs()) };
    // A number that rounds to 0 has no sign.
    let is_negative = number < 0.0 && text.contains(|c| c == '∞' || ('1'..='9').contains(&c));
    Shown::new(number, if is_negative { format!("−{text}") } else { text })
}

/// Formats a number of this size with three digits from the first one of `step`; in scientific notation below 1e−4 and from
/// 1e6 on.
pub fn significant(number: f64, size: f64, step: f64) -> Shown {
    let place = |number: f64| number.log10().floor();
    if size == 0.0 || !number.is_finite() {
        return fixed(number, 0);
    }
    let decimals = |first: f64| (2.0 - first).clamp(0.0, 15.0) as usize;
    if (1e-4..1e6).contains(&size) {
        return fixed(number, decimals(place(step)));
    }
    let power = place(size);
    let mantissa = fixed(number / 10_f64.powf(power), decimals(place(step) - power));
    Shown::new(number, format!("{}e{}", &*mantissa, &*fixed(power, 0)))
}

/// Formats a mean rating.
pub fn mean(number: f64) -> Shown {
    fixed(number, 2)
}

/// Formats a proportion or a coefficient that cannot exceed 1: `.62`, `−.08`, `1.00`.
pub fn unit(number: impl Into<Option<f64>>) -> Shown {
    let fixed = fixed(number, 2);
    Shown::new(fixed.value().clone(), fixed.replacen("0.", ".", 1))
}

/// Formats a probability with three decimals below .1 and two above, and never rounds it across .05.
pub fn probability(p: impl Into<Option<f64>>) -> Shown {
    let p = p.into().unwrap_or(f64::NAN);
    if p.is_nan() {
        return Shown::new(p, "–");
    }
    if p < 0.001 {
        return Shown::new(p, "< .001");
    }
    if p > 0.995 {
        return Shown::new(p, "> .99");
    }
    let decimals = if p < 0.1 { 3 } else { 2 };
    let rounded = format!("{p:.decimals$}");
    let text = if p < 0.05 && rounded == "0.050" { format!("{:.4}", (p * 1e4).floor() / 1e4) } else { rounded };
    Shown::new(p, text.trim_start_matches('0'))
}

/// Formats a probability for a sentence, as `p = .043` or `p < .001`, so that it is never broken across lines.
pub fn p_is(p: f64) -> String {
    let text = probability(p);
    let text = if text.starts_with(['<', '>']) { format!("p {text}") } else { format!("p = {text}") };
    text.replace(' ', NBSP)
}

/// Formats a ratio with about three significant digits.
pub fn ratio(number: f64) -> Shown {
    let decimals = |n| fixed(number, n);
    match number {
        n if !n.is_finite() => decimals(0),
        n if n >= 1e6 => Shown::new(n, "> 1,000,000"),
        n if n >= 999.5 => Shown::new(n, whole(n.round() as u64).to_string()),
        n if n >= 99.95 => decimals(0),
        n if n >= 9.995 => decimals(1),
        n if n >= 0.0995 => decimals(2),
        n if n >= 0.00995 => decimals(3),
        n if n >= 0.001 => decimals(4),
        0.0 => decimals(0),
        n => Shown::new(n, "< 0.001"),
    }
}

/// Formats an interval as `0.81 to 1.20`; its value is the lower end.
pub fn range(interval: Option<Interval>, format: impl Fn(f64) -> Shown) -> Shown {
    let text = interval.map_or_else(|| "–".to_owned(), |i| format!("{} to {}", format(i.low), format(i.high)));
    Shown::new(interval.map(|interval| interval.low), text)
}

/// Formats a 95 % interval that follows its estimate, as ` (95 % interval .81 to .92)`; empty if there is none.
pub fn with_interval(interval: Option<Interval>, format: impl Fn(f64) -> Shown) -> String {
    match interval {
        Some(_) => format!(" (95{NBSP}% interval {})", range(interval, format)),
        None => String::new(),
    }
}

/// Formats a proportion as a percentage with at most one decimal: `95 %`. Only 0 and 1 are 0 % and 100 %.
pub fn percent(proportion: f64) -> Shown {
    let percent = 100.0 * proportion;
    let is_whole = (percent - percent.round()).abs() < 1e-9;
    let text = if is_whole { fixed(percent, 0) } else { fixed(percent.clamp(0.1, 99.9), 1) };
    Shown::new(proportion, format!("{text}{NBSP}%"))
}

/// Formats a proportion as a percentage without decimals, unless it would be 0 % or 100 % only by rounding.
pub fn whole_percent(proportion: f64) -> Shown {
    let rounded = (100.0 * proportion).round() / 100.0;
    percent(if rounded > 0.0 && rounded < 1.0 { rounded } else { proportion })
}

/// Formats a count with its noun, which must have a regular plural: `1 session`, `2 sessions`.
pub fn count(number: u64, one: &str) -> String {
    if number == 1 { format!("1 {one}") } else { format!("{} {one}s", whole(number)) }
}

/// Formats a list: `a, b and c`.
pub fn list<S: AsRef<str>>(items: &[S]) -> String {
    joined(items, "and")
}

/// Formats a list of alternatives, such as `width, depth or size`.
pub fn either<S: AsRef<str>>(items: &[S]) -> String {
    joined(items, "or")
}

fn joined<S: AsRef<str>>(items: &[S], word: &str) -> String {
    let items: Vec<&str> = items.iter().map(AsRef::as_ref).collect();
    match items.as_slice() {
        [rest @ .., last] if !rest.is_empty() => format!("{} {word} {last}", rest.join(", ")),
        items => items.concat(),
    }
}

/// Formats a list that ends after `most` items and says how many more there are.
pub fn short_list<S: AsRef<str>>(items: &[S], most: usize) -> String {
    if items.len() <= most {
        return list(items);
    }
    let shown: Vec<&str> = items[..most].iter().map(AsRef::as_ref).collect();
    format!("{} and {} more", shown.join(", "), whole((items.len() - most) as u64))
}

/// A formatted value. It is used like the text that it shows.
#[derive(Clone, Debug, PartialEq)]
pub struct Shown {
    text: String,
    value: Cell,
}

impl Shown {
    /// Shows a value as this text.
    pub fn new(value: impl Into<Cell>, text: impl Into<String>) -> Self {
        Self { text: text.into(), value: value.into() }
    }

    /// Returns what is shown.
    pub fn value(&self) -> &Cell {
        &self.value
    }
}

impl Deref for Shown {
    type Target = str;

    fn deref(&self) -> &str {
        &self.text
    }
}

impl AsRef<str> for Shown {
    fn as_ref(&self) -> &str {
        self
    }
}

impl fmt::Display for Shown {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self)
    }
}

impl PartialEq<&str> for Shown {
    fn eq(&self, other: &&str) -> bool {
        self.text == *other
    }
}

impl<T: Into<String>> From<T> for Shown {
    /// Shows a text.
    fn from(text: T) -> Self {
        let text = text.into();
        Self { value: Cell::from(text.as_str()), text }
    }
}
