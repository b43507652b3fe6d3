//! What the text of a cell means.

use std::{borrow::Cow, collections::BTreeMap};

use serde_json::{Map, Value};

use crate::store::columns::Texts;

/// Maximum count in a row. The sum of many such counts still fits in 64 bits.
const MAX_COUNT: f64 = 1e12;

/// True if a cell has no value. Words that are only sometimes written for a missing value may name a level, so they are
/// missing only if all other values of the column are numbers (`among_numbers`).
pub(super) fn is_missing(text: &str, among_numbers: bool) -> bool {
    matches!(text, "" | "NA" | "NaN" | "nan" | "NULL" | "#N/A" | "N/A" | "n/a")
        || (among_numbers && matches!(text, "." | "None" | "null"))
}

/// True if there is no response: the cell has no value, or one of the texts that are `named` as missing.
pub(super) fn is_no_response(text: &str, named: &[String], among_numbers: bool) -> bool {
    let same = |name: &String| name == text || number(name).is_some_and(|named| number(text) == Some(named));
    is_missing(text, among_numbers) || matches!(text, "." | "null") || named.iter().any(same)
}

/// Returns the value of a JSON object with a single entry, as jsPsych writes the answer to a question; empty for `null`.
pub(super) fn answer(text: &str) -> Option<String> {
    let object: Map<String, Value> =
        if text.starts_with('{') { serde_json::from_str(text).ok()? } else { return None };
    let mut values = object.into_iter().map(|(_, value)| value);
    match (values.next()?, values.next()) {
        (Value::String(text), None) => Some(text),
        (Value::Null, None) => Some(String::new()),
        (value @ (Value::Number(_) | Value::Bool(_)), None) => Some(value.to_string()),
        _ => None,
    }
}

/// Returns the groups of IDs that differ only in capitals, in zeros before a number, or in its form, such as `1.0`.
pub(super) fn alike<'a>(ids: impl Iterator<Item = &'a str>) -> Vec<Vec<&'a str>> {
    let mut groups: BTreeMap<String, Vec<&str>> = BTreeMap::new();
    for id in ids.filter(|id| !id.is_empty()) {
        let group = groups.entry(common_form(id)).or_default();
        if !group.contains(&id) {
            group.push(id);
        }
    }
    groups.into_values().filter(|group| group.len() > 1).collect()
}

fn common_form(id: &str) -> String {
    // A number with more digits would be rounded.
    if let Some(number) = number(id).filter(|_| id.len() <= 15) {
        return (number + 0.0).to_string();
    }
    let mut form = String::new();
    let lower = id.to_lowercase();
    let mut rest = lower.chars().peekable();
    while let Some(char) = rest.next() {
        let is_first = !form.ends_with(|before: char| before.is_ascii_digit() || before == '.');
        if char != '0' || !is_first || !rest.peek().is_some_and(char::is_ascii_digit) {
            form.push(char);
        }
    }
    form
}

/// Returns a cell with a point in place of a decimal comma. If cells are not separated by commas, a comma in a number is
/// a decimal comma, as in spreadsheets from many countries.
pub(in crate::store) fn with_point(text: &str, separator: u8) -> Cow<'_, str> {
    // One comma, so that `1,234,567` stays text.
    if separator != b',' && text.matches(',').count() == 1 {
        let number = text.replace(',', ".");
        if number.parse::<f64>().is_ok() {
            return number.into();
        }
    }
    text.into()
}

/// Returns the number in a cell; `None` for other texts and missing values.
pub(super) fn number(text: &str) -> Option<f64> {
    text.parse().ok().filter(|number: &f64| !number.is_nan())
}

/// True if all values of a column, in all files together, are numbers.
pub(super) fn are_numbers(column: &[&Texts]) -> bool {
    let mut values = column.iter().flat_map(|file| &file.texts).filter(|text| !is_missing(text, true)).peekable();
    values.peek().is_some() && values.all(|text| number(text).is_some())
}

/// True if hardly any values of a column, at most one in 50, are not numbers: these are then mistakes.
pub(super) fn are_mostly_numbers(column: &[&Texts]) -> bool {
    let rows = |is: fn(&str) -> bool| -> usize {
        column.iter().map(|file| file.map(is).iter().filter(|is| **is).count()).sum()
    };
    50 * rows(|text| !is_missing(text, true) && number(text).is_none()) <= rows(|text| !is_missing(text, true))
}

/// Returns a whole number from 1 to a million, written with digits only; a session has at most 100,000 trials.
pub(super) fn ordinal(text: &str) -> Option<u32> {
    let digits = text.len() < 10 && text.bytes().all(|byte| byte.is_ascii_digit());
    text.parse().ok().filter(|number| digits && (1..=1_000_000).contains(number))
}

/// True if a text is a rating: a number on our own scale, or on other scales anything but a missing value.
pub(super) fn is_rating(text: &str, own_scale: Option<u8>, among_numbers: bool) -> bool {
    if let Some(highest) = own_scale {
        // A spreadsheet or pandas may have written 2 as 2.0.
        text.parse().is_ok_and(|number: f64| (0..=highest).any(|rating| number == f64::from(rating)))
    } else {
        !is_missing(text, among_numbers)
    }
}

/// Returns a level as the definition writes it, so that a level that a spreadsheet or pandas wrote as `0.40` or `1.0` is
/// the level `0.4` or `1`; otherwise as it is written. A missing value is empty.
pub(super) fn level<'a>(text: &'a str, defined: &'a [String], among_numbers: bool) -> &'a str {
    if is_missing(text, among_numbers) {
        return "";
    }
    let is_exact = defined.iter().any(|level| level == text);
    let number = if is_exact { None } else { text.parse::<f64>().ok() };
    let same = number.and_then(|number| defined.iter().find(|level| level.parse() == Ok(number)));
    same.map_or(text, String::as_str)
}

/// Returns how many trials a row represents. A count of 3 may be written as `3.0`, because pandas does so.
///
/// # Errors
/// Says what was expected.
pub(super) fn count(text: &str) -> Result<u64, &'static str> {
    let count = text.parse::<f64>().ok().filter(|count| (0.0..=MAX_COUNT).contains(count) && count.fract() == 0.0);
    count.map(|count| count as u64).ok_or("a count, a whole number from 0 to 10^12")
}

/// Returns the number of a repetition; `None` if it is missing.
///
/// # Errors
/// Says what was expected.
pub(super) fn repetition(text: &str) -> Result<Option<u32>, &'static str> {
    match text.parse() {
        _ if is_missing(text, true) => Ok(None),
        Ok(repetition) => Ok(Some(repetition)),
        Err(_) => Err("the number of a repetition, 1 or more"),
    }
}

/// Returns the place of a trial in its session, or `None` if it is missing.
///
/// # Errors
/// Says what was expected.
pub(super) fn position(text: &str) -> Result<Option<f64>, &'static str> {
    match text.parse() {
        _ if is_missing(text, true) => Ok(None),
        Ok(position) if f64::is_finite(position) => Ok(Some(position)),
        _ => Err("a number that increases from trial to trial"),
    }
}

/// Returns a response time in seconds: NaN if it is missing, and negative if it is not a time.
pub(super) fn seconds(text: &str) -> f64 {
    match text.parse() {
        _ if is_missing(text, true) => f64::NAN,
        Ok(seconds) if f64::is_finite(seconds) && seconds >= 0.0 => seconds,
        _ => -1.0,
    }
}

/// True if a cell of the column `simulated` says that a program answered: anything but no value, 0, false and no.
pub(super) fn is_mark(text: &str) -> bool {
    let denies = |word: &str| text.eq_ignore_ascii_case(word);
    !is_missing(text, true) && number(text) != Some(0.0) && !denies("false") && !denies("no")
}
