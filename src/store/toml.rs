//! Reads TOML files into types that derive `Deserialize`. Each error has its line and column, and all errors in a file
//! are reported together: a value that cannot be read is reported and then skipped, as if its key were absent.

use std::ops::RangeInclusive;

use serde::de::DeserializeOwned;
use serde_json::{Map, Value};
use toml::de::{DeTable, DeValue};

use super::{FileError, FileErrors, error::position};
use crate::{
    experiment::{DefinitionErrors, task::OptionReader},
    text::{Cell, names::expected_one_of},
};

/// Maximum number of unreadable values, because the document is deserialized again for each of them.
const MAX_UNREAD: usize = 100;

/// A TOML document, and the errors found in it so far.
pub(super) struct Document<'t> {
    file: &'t str,
    text: &'t str,
    table: DeTable<'t>,
    /// Locations in the text, the errors there, and their keys.
    errors: Vec<(usize, String, String)>,
    /// Locations of the values that could not be read.
    unread: Vec<usize>,
}

/// Reads a document, which must have `schema = 1`. The caller checks the value, reports errors with
/// [`Document::error`], and ends with [`Document::finish`].
///
/// # Errors
/// The text is not TOML; or there is an error after which no value can be built, such as a missing key without a
/// default.
pub(super) fn read<'t, T: DeserializeOwned>(file: &'t str, text: &'t str) -> Result<(T, Document<'t>), FileErrors> {
    let mut document = Document::parse(file, text)?;
    let mut value = json_table(&document.table);
    match value.as_object_mut().and_then(|keys| keys.shift_remove("schema")) {
        Some(Value::Number(one)) if one.as_u64() == Some(1) => {}
        Some(other) => document.error("schema", format!("schema is {other}; expected 1")),
        None => document.error("schema", "schema is missing; expected schema = 1"),
    }
    let read = without_unread(value, "", &[], |path, message| {
        let place = document.locate(path);
        // A key that could not be read is missing after that.
        if !document.unread.contains(&place) {
            document.errors.push((place, message, path.to_owned()));
            document.unread.push(place);
        }
    });
    match read {
        Some(read) => Ok((read, document)),
        None => Err(document.located()),
    }
}

/// Deserializes the value at the path `table`, which also has the keys `taken`. Each part of it that cannot be read is
/// reported, with its path and what is wrong, and then removed. `None` if too little is left.
fn without_unread<T: DeserializeOwned>(
    mut value: Value,
    table: &str,
    taken: &[&str],
    mut report: impl FnMut(&str, String),
) -> Option<T> {
    for _ in 0..=MAX_UNREAD {
        let error = match serde_path_to_error::deserialize::<_, T>(&value) {
            Ok(read) => return Some(read),
            Err(error) => error,
        };
        let inner = error.path().to_string().replace('[', ".").replace(']', "");
        // A single dot stands for the whole value.
        let inner = inner.trim_matches('.');
        let message = error.inner().to_string();
        let missing = message.strip_prefix("missing field `").map(|field| field.trim_end_matches('`'));
        let path = [table, inner, missing.unwrap_or_default()].join(".").replace("..", ".");
        let path = path.trim_matches('.');
        let taken = if inner.contains('.') { &[] } else { taken };
        report(
            path,
            match missing {
                Some(field) => format!("{path} is missing; expected {field} = …"),
                None => explained(path, &message, taken),
            },
        );
        if !remove(&mut value, inner) {
            break;
        }
    }
    None
}

/// Reads a table of a definition, such as the options of a task or of an adaptive method.
pub(super) struct TableReader<'e> {
    /// The path of the table in the definition; empty for the whole definition.
    pub path: &'e str,
    /// The keys and values that are left.
    pub table: Map<String, Value>,
    /// The keys that were taken from it, or could have been.
    pub taken: Vec<&'static str>,
    /// Where errors go.
    pub errors: &'e mut DefinitionErrors,
}

impl OptionReader for TableReader<'_> {
    fn read<T: DeserializeOwned + Default>(&mut self) -> T {
        let table = Value::Object(std::mem::take(&mut self.table));
        let read = without_unread(table, self.path, &self.taken, |path, message| {
            let key = path.strip_prefix(self.path).unwrap_or(path).trim_start_matches('.');
            let message = if message.starts_with('"') { format!("{key} {message}") } else { message };
            // A key that could not be read is missing after that.
            if self.errors.0.iter().all(|error| error.path != path) {
                self.errors.add(path, message);
            }
        });
        read.unwrap_or_default()
    }
}

impl<'t> Document<'t> {
    /// Parses the text of a document.
    ///
    /// # Errors
    /// The first place where the text is not TOML.
    pub(super) fn parse(file: &'t str, text: &'t str) -> Result<Self, FileErrors> {
        let table = DeTable::parse(text).map_err(|error| {
            let at = error.span().map_or(text.len(), |span| span.start);
            let message = format!("is not valid TOML: {}", error.message().replace('\n', ", "));
            FileErrors::at(file, position(text, at), message)
        })?;
        Ok(Self { file, text, table: table.into_inner(), errors: Vec::new(), unread: Vec::new() })
    }

    /// True if there is such a key at the top level.
    pub(super) fn has(&self, key: &str) -> bool {
        self.table.contains_key(key)
    }

    /// Reports an error at a dotted path such as `factors.width.2`, or at the nearest existing parent. Does nothing
    /// if the value could not be read, because that error has already been reported.
    pub(super) fn error(&mut self, path: &str, message: impl Into<String>) {
        let place = self.locate(path);
        if !self.unread.contains(&place) {
            self.errors.push((place, message.into(), path.to_owned()));
        }
    }

    /// Reports an error at a dotted path if one of its numbers is outside `range`.
    pub(super) fn check_range(&mut self, path: &str, values: &[f64], range: RangeInclusive<f64>) {
        // NaN is not in any range.
        if let Some(value) = values.iter().find(|value| !range.contains(value)) {
            let (key, value) = (path.rsplit('.').next().unwrap_or(path), Cell::Number(*value));
            self.error(
                path,
                format!("{key} {value} is outside {}…{}; expected a number in this range", range.start(), range.end()),
            );
        }
    }

    /// Returns the value, unless the document has errors.
    ///
    /// # Errors
    /// Returns every error, in the order of the text.
    pub(super) fn finish<T>(self, value: T) -> Result<T, FileErrors> {
        if self.errors.is_empty() { Ok(value) } else { Err(self.located()) }
    }

    /// Returns every error, in the order of the text.
    pub(super) fn located(mut self) -> FileErrors {
        self.errors.sort();
        // Lines are counted from one error to the next and not from the start, because there may be 100,000 errors.
        let (mut from, mut line, mut column) = (0, 1, 1);
        let located = self.errors.into_iter().map(|(at, message, key)| {
            let (lines, columns) = position(&self.text[from..], at - from);
            (line, column) = if lines > 1 { (line + lines - 1, columns) } else { (line, column + columns - 1) };
            from = at;
            FileError { key, ..FileError::at(self.file, (line, column), message) }
        });
        FileErrors(located.collect())
    }

    /// Returns the offset where a key or a list item begins.
    fn locate(&self, path: &str) -> usize {
        let (first, rest) = path.split_once('.').unwrap_or((path, ""));
        let Some((key, value)) = self.table.get_key_value(first) else { return 0 };
        let (mut place, mut value) = (key.span().start, value);
        for step in rest.split('.') {
            let next = match value.get_ref() {
                DeValue::Table(table) => table.get_key_value(step).map(|(key, value)| (key.span(), value)),
                DeValue::Array(items) => {
                    step.parse::<usize>().ok().and_then(|i| items.get(i)).map(|item| (item.span(), item))
                }
                _ => None,
            };
            let Some((span, found)) = next else { break };
            (place, value) = (span.start, found);
        }
        place
    }
}

/// Converts a TOML value to JSON. Non-finite numbers become strings, because `inf` is a valid depth; dates and times
/// become strings too.
fn json(value: &DeValue<'_>) -> Value {
    let number = |number: f64| if number.is_finite() { number.into() } else { number.to_string().into() };
    match value {
        DeValue::String(text) => text.as_ref().into(),
        DeValue::Integer(digits) => match i64::from_str_radix(digits.as_str(), digits.radix()) {
            Ok(whole) => whole.into(),
            Err(_) => digits.to_string().into(),
        },
        DeValue::Float(digits) => digits.as_str().parse().map_or(Value::Null, number),
        DeValue::Boolean(value) => (*value).into(),
        DeValue::Datetime(time) => time.to_string().into(),
        DeValue::Array(items) => items.iter().map(|item| json(item.get_ref())).collect(),
        DeValue::Table(table) => json_table(table),
    }
}

fn json_table(table: &DeTable<'_>) -> Value {
    let entry = |(key, value): (&toml::Spanned<_>, &toml::Spanned<_>)| {
        let key: &toml::de::DeString<'_> = key.get_ref();
        (key.to_string(), json(value.get_ref()))
    };
    Value::Object(table.iter().map(entry).collect::<Map<_, _>>())
}

/// Removes the key at a dotted path, or the key of the list that contains the error, and returns whether there was one.
fn remove(value: &mut Value, path: &str) -> bool {
    let Value::Object(keys) = value else { return false };
    let (first, rest) = path.split_once('.').unwrap_or((path, ""));
    keys.get_mut(first).is_some_and(|inner| remove(inner, rest)) || keys.shift_remove(first).is_some()
}

/// Rephrases a message from serde about the value at `path` in this program's style. Its table also knows the keys `taken`.
fn explained(path: &str, error: &str, taken: &[&str]) -> String {
    let (table, key) = path.rsplit_once('.').unwrap_or(("", path));
    if error.starts_with("unknown field") {
        // unknown field `widht`, expected one of `width`, `depth`
        let known: Vec<&str> = taken.iter().copied().chain(error.split('`').skip(3).step_by(2)).collect();
        return unknown_key(table, key, &known);
    }
    let Some((wrong, expected)) = error.split_once(", expected ") else { return error.to_owned() };
    let expected = match expected {
        "f64" => "a number",
        "u8" => "a whole number from 0 to 255",
        "u32" => "a whole number from 0 to 4294967295",
        "a string" => "text in quotes",
        "a boolean" => "true or false",
        "a sequence" => "a list in brackets",
        other if other == "a map" || other.starts_with("struct ") => "a table",
        other => &other.replace("an array", "a list"),
    };
    let Some(found) = wrong.strip_prefix("invalid type: ").or(wrong.strip_prefix("invalid value: ")) else {
        return format!("{path}: {wrong}; expected {expected}");
    };
    let (found, expected) = match found.strip_prefix("string ").map(|text| text.trim_matches('"')) {
        // A number that is not finite is a string here.
        Some(number @ ("NaN" | "inf" | "-inf")) if expected == "a number" => (number, "a finite number"),
        _ => (found, expected),
    };
    let found = match found.split_once(' ') {
        None if found == "sequence" => "a list",
        None if found == "map" => "a table",
        Some(("string", text)) => &format!("the text {text}"),
        // integer `7`, floating point `0.5`, boolean `true`
        _ => found.split('`').nth(1).unwrap_or(found),
    };
    format!("{path} is {found}; expected {expected}")
}

/// Returns the message for an unknown key in a table, with the valid keys.
pub(super) fn unknown_key(table: &str, key: &str, known: &[&str]) -> String {
    let place = if table.is_empty() { String::new() } else { format!(" in [{table}]") };
    format!("unknown key {key:?}{place}; {}", expected_one_of(key, known))
}
