//! Numbers that people type.

use std::{fmt::Display, ops::RangeInclusive, str::FromStr};

/// Returns the number that a text represents: a decimal number, or `inf` or `-inf` in any case. `nan` and
/// hexadecimal numbers are none.
pub fn number_of(text: &str) -> Option<f64> {
    text.trim().parse::<f64>().ok().filter(|number| !number.is_nan())
}

/// Returns the numbers of all texts, or `None` if any of them is not a number.
pub fn numbers_of<S: AsRef<str>>(texts: &[S]) -> Option<Vec<f64>> {
    texts.iter().map(|text| number_of(text.as_ref())).collect()
}

/// Returns a parser that accepts only numbers from `least` to `most`.
pub fn within(least: f64, most: f64) -> impl Fn(&str) -> Result<f64, String> + Clone + Send + Sync {
    move |text| in_range(text, &(least..=most), "number")
}

/// Returns a parser that accepts only whole numbers in `range`.
pub fn whole<T>(range: RangeInclusive<T>) -> impl Fn(&str) -> Result<T, String> + Clone + Send + Sync
where
    T: FromStr + PartialOrd + Display + Clone + Send + Sync,
{
    move |text| in_range(text, &range, "whole number")
}

/// Parses a number above 0.
pub fn positive(text: &str) -> Result<f64, String> {
    let number = text.parse::<f64>().ok().filter(|number| number.is_finite() && *number > 0.0);
    number.ok_or_else(|| "expected a number above 0".to_owned())
}

fn in_range<T: FromStr + PartialOrd + Display>(text: &str, range: &RangeInclusive<T>, kind: &str) -> Result<T, String> {
    let (least, most) = (range.start(), range.end());
    match text.parse() {
        Ok(number) if range.contains(&number) => Ok(number),
        found if found.is_ok() || text.parse::<i128>().is_ok() => {
            Err(format!("outside {least}…{most}; expected a {kind} in this range"))
        }
        _ => Err(format!("not a {kind}; expected one from {least} to {most}")),
    }
}
